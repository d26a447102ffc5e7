// What is plotted of a scene: attitude, rate, what is kept, and the columns that were chosen. A curve is
// {title, series: [{name, data, paint, sigma}], least}; sigma is how far to either side the band of 1 sigma
// goes, `least` the range of values that the axis shows at least.

import { norm } from "../answers/rotation.js";

const PAINTS = ["--x", "--y", "--z", "--ink", "--rate"];
const DEGREES = 180 / Math.PI;
const ROUNDING = 1e-13; // a relative change below it is no more than that of doubles

/** `chosen` are {column, title, sigma} of the quantities section. */
export function curvesOf({ course, columns }, chosen) {
  const [q, omega] = course.sigmas ?? [[], []];
  const [w, ...xyz] = course.q;
  const motion = [
    { title: "Quaternion, body to inertial", series: [{ name: "w", data: w, paint: "--ink", sigma: q[0] }, ...vector(["x", "y", "z"], xyz, q.slice(1))] },
    { title: "Body rate, rad/s", series: vector(["ωx", "ωy", "ωz"], course.omega, omega) },
  ];
  return [...motion, ...(course.bodyKnown ? kept(course) : []), ...chosen.map((each) => chosenCurve(each, columns))];
}

const vector = (names, data, sigmas) => names.map((name, i) => ({ name, data: data[i], paint: PAINTS[i], sigma: sigmas[i] }));

function kept(course) {
  const [energy, momentum] = [energyChange(course), momentumChange(course)];
  return [
    { ...energy, series: [{ name: "", data: energy.data, paint: "--rate" }] },
    { ...momentum, series: [{ name: "", data: momentum.data, paint: "--momentum" }] },
  ];
}

/** Against the start; a body that starts at rest has nothing to be relative to. */
function energyChange(course) {
  const first = course.energy[0];
  return first > 0
    ? { title: "Energy, change relative to the start", least: ROUNDING, data: course.energy.map((energy) => energy / first - 1) }
    : { title: "Energy, J", data: course.energy };
}

function momentumChange(course) {
  const first = course.momentumAt(0);
  const size = norm(first) || 1;
  const title = norm(first) ? "Momentum, |L − L₀| / |L₀|, inertial" : "Momentum, |L|, N m s";
  const change = (_, i) => norm(course.momentumAt(i).map((x, k) => x - first[k])) / size;
  return { title, least: norm(first) ? ROUNDING : 0, data: course.t.map(change) };
}

function chosenCurve({ column, title, sigmaColumn }, columns) {
  const found = columns[column];
  if (!found || found.refused) return { column, title, refused: found?.refused ?? "A file has no such columns.", series: [] };
  const sigma = sigmaColumn && columns[sigmaColumn]?.data?.[0];
  // that of a direction is in degrees; a component of a unit vector changes by no more than its angle
  const scaled = sigma && (found.labels[0].endsWith("deg") ? sigma : sigma.map((x) => x / DEGREES));
  const series = found.data.map((data, i) => ({ name: found.labels[i], data, paint: PAINTS[i % PAINTS.length], sigma: scaled }));
  return { column, title, series };
}
