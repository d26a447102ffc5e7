// Rotations for drawing: quaternions [w, x, y, z], which carry body components to inertial ones,
// and the principal axes of a 3 x 3 inertia.

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const norm = (a) => Math.hypot(a[0], a[1], a[2]);
export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const times = (matrix, v) => matrix.map((row) => dot(row, v));

/** q v q*: v + 2 w (u x v) + 2 u x (u x v). */
export function rotate(q, v) {
  const u = [q[1], q[2], q[3]];
  const t = cross(u, v).map((x) => 2 * x);
  const s = cross(u, t);
  return [0, 1, 2].map((i) => v[i] + q[0] * t[i] + s[i]);
}

/** The rotation vector from attitude a to b, body axes, rad, at most half a turn. */
export function difference(a, b) {
  const [v, w] = [a.slice(1), b.slice(1)];
  const c = cross(v, w);
  const sign = a[0] * b[0] + dot(v, w) < 0 ? -1 : 1;
  const part = [0, 1, 2].map((i) => sign * (a[0] * w[i] - b[0] * v[i] - c[i]));
  const sine = norm(part);
  const angle = 2 * Math.atan2(sine, Math.abs(a[0] * b[0] + dot(v, w)));
  return part.map((x) => (sine > 0 ? (x * angle) / sine : 0));
}

/** Spherical linear interpolation without change of sign: quaternions of the service are continuous. */
export function slerp(a, b, fraction) {
  const cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const angle = Math.acos(Math.min(1, Math.max(-1, cosine)));
  const sine = Math.sin(angle);
  // nearly equal: linear interpolation is as good; opposite: the path is undefined, stay at a
  if (sine < 1e-6) return cosine > 0 ? unit(a.map((x, i) => x + fraction * (b[i] - x))) : a;
  const [p, q] = [Math.sin((1 - fraction) * angle) / sine, Math.sin(fraction * angle) / sine];
  return unit(a.map((x, i) => p * x + q * b[i]));
}

function unit(q) {
  const length = Math.hypot(...q);
  return q.map((x) => x / length);
}

/** Principal moments, ascending, and their axes, right-handed, by Jacobi's rotations. */
export function principal(inertia) {
  const a = inertia.map((row) => [...row]);
  const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 12; sweep++) {
    for (const [i, j] of [[0, 1], [0, 2], [1, 2]]) zero(a, axes, i, j);
  }
  const order = [0, 1, 2].sort((i, j) => a[i][i] - a[j][j]);
  const [first, second] = [axes[order[0]], axes[order[1]]];
  return { moments: order.map((i) => a[i][i]), axes: [first, second, cross(first, second)] };
}

function zero(a, axes, i, j) {
  if (a[i][j] === 0) return;
  // the smaller of the two possible angles: the larger swaps axes, and the sweeps need not converge
  const angle = 0.5 * Math.atan((2 * a[i][j]) / (a[j][j] - a[i][i]));
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  for (const row of a) [row[i], row[j]] = [c * row[i] - s * row[j], s * row[i] + c * row[j]];
  [a[i], a[j]] = turned(a[i], a[j], c, s);
  [axes[i], axes[j]] = turned(axes[i], axes[j], c, s);
}

const turned = (p, q, c, s) => [p.map((x, k) => c * x - s * q[k]), p.map((x, k) => s * x + c * q[k])];

export const conjugate = ([w, x, y, z]) => [w, -x, -y, -z];

/** The quaternion of the rotation matrix whose rows are three orthonormal axes. */
export function fromAxes(m) {
  // the largest of the four squared components is far from zero
  const squares = [
    1 + m[0][0] + m[1][1] + m[2][2], 1 + m[0][0] - m[1][1] - m[2][2],
    1 - m[0][0] + m[1][1] - m[2][2], 1 - m[0][0] - m[1][1] + m[2][2],
  ];
  const products = [
    [squares[0], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]],
    [m[2][1] - m[1][2], squares[1], m[0][1] + m[1][0], m[0][2] + m[2][0]],
    [m[0][2] - m[2][0], m[0][1] + m[1][0], squares[2], m[1][2] + m[2][1]],
    [m[1][0] - m[0][1], m[0][2] + m[2][0], m[1][2] + m[2][1], squares[3]],
  ];
  return unit(products[squares.indexOf(Math.max(...squares))]);
}
