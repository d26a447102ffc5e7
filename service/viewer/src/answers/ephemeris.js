// The answer of /v1/ephemeris as arrays sorted by time, with interpolation for drawing.

import { timeOrder } from "./columns.js";
import { difference, dot, norm, rotate, slerp, times } from "./rotation.js";

// Samples that are further apart cannot be interpolated: the rotation between them is ambiguous.
export const MAX_TURN = Math.PI; // rad

const SPHERE = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

export class Ephemeris {
  /** `isTranslated`: whether positions are those of a centre of mass that moves, not of an orbit. */
  constructor(answer, isTranslated = true) {
    const columns = answer.columns;
    const order = timeOrder(columns.elapsed_s);
    const column = (name) => Float64Array.from(order, (i) => columns[name][i]);
    const vector = (names) => (names[0] in columns ? names.map(column) : null);
    this.name = answer.name;
    this.frame = answer.frame;
    this.scale = answer.time_scale;
    this.cost = { ...answer.plan, ...answer.cost }; // what was computed, and how long it took
    this.events = answer.events ?? [];
    this.jumps = this.events.map((event) => event.elapsed_s).sort((a, b) => a - b);
    // a file may hold neither a body nor rates
    this.bodyKnown = Boolean(answer.body);
    this.inertia = this.bodyKnown ? tensor(answer.body) : SPHERE;
    this.t = column("elapsed_s");
    this.dates = columns.time ? order.map((i) => columns.time[i]) : null;
    this.q = ["w", "x", "y", "z"].map((letter) => column(`q_${letter}`));
    this.omega = vector(["omega_x_rad_s", "omega_y_rad_s", "omega_z_rad_s"]) ?? this.#differences();
    this.position = isTranslated ? vector(["position_x_m", "position_y_m", "position_z_m"]) : null;
    // a column of its own where rotors or dissipation change it; otherwise inertia times rate
    const columnsOfMomentum = vector(["momentum_x_N_m_s", "momentum_y_N_m_s", "momentum_z_N_m_s"]);
    this.hasMomentumColumns = columnsOfMomentum !== null;
    this.momentum = columnsOfMomentum ?? this.#momentum();
    this.energy = this.t.map((_, i) => 0.5 * dot(this.omegaAt(i), times(this.inertia, this.omegaAt(i))));
    this.sigmas = "attitude_covariance_xx_rad2" in columns ? this.#sigmas(column) : null;
    this.rate = this.t.map((_, i) => norm(this.omegaAt(i)));
    this.meanRate = this.rate.reduce((sum, rate) => sum + rate, 0) / this.length;
    this.turn = this.#greatestTurn();
  }

  get length() {
    return this.t.length;
  }

  get start() {
    return this.t[0];
  }

  get stop() {
    return this.t[this.t.length - 1];
  }

  get span() {
    return this.stop - this.start;
  }

  /** Whether the samples are close enough to interpolate between them. */
  get connected() {
    return this.turn <= MAX_TURN;
  }

  omegaAt(i) {
    return this.omega.map((column) => column[i]);
  }

  quaternionAt(i) {
    return this.q.map((column) => column[i]);
  }

  momentumAt(i) {
    return this.momentum.map((column) => column[i]);
  }

  /** The sample at a time, or the last before it. */
  index(t) {
    let [low, high] = [0, this.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.t[middle] <= t) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** The state at a time: interpolated where the samples are close enough, otherwise that of the last sample. */
  at(t) {
    const i = this.index(t);
    const [here, next] = [this.t[i], this.t[i + 1]];
    const fraction = this.connected && next > here ? Math.min(1, Math.max(0, (t - here) / (next - here))) : 0;
    const jump = fraction > 0 ? this.#jumpIn(i) : null;
    // rate and momentum jump at an event: those of the sample before it hold until then
    const part = jump === null ? fraction : Number(t >= jump);
    const between = (columns, by = part) => columns.map((c) => (by > 0 ? c[i] + by * (c[i + 1] - c[i]) : c[i]));
    return {
      index: i,
      quaternion: fraction > 0 ? slerp(this.quaternionAt(i), this.quaternionAt(i + 1), fraction) : this.quaternionAt(i),
      omega: this.#onEllipsoid(between(this.omega), between([this.energy])[0]),
      momentum: between(this.momentum),
      position: this.position && between(this.position, fraction),
      energy: between([this.energy])[0],
    };
  }

  /** Times at which curves are drawn: those of the samples, with steps between them so short that curves look smooth. */
  smooth(maxCount) {
    const stride = Math.max(1, Math.ceil(this.length / maxCount));
    const parts = this.connected && stride === 1 ? Math.min(24, Math.ceil(this.turn / 0.05), Math.floor(maxCount / this.length)) : 1;
    const instants = [];
    for (let i = 0; i < this.length; i += stride) {
      const step = ((this.t[i + 1] ?? this.t[i]) - this.t[i]) / parts;
      for (let k = 0; k < (step > 0 ? parts : 1); k++) instants.push(this.t[i] + k * step);
    }
    return instants;
  }

  /** These times divided at the events, where rate and momentum jump. */
  segments(maxCount) {
    const segments = [[]];
    let next = 0;
    for (const t of this.smooth(maxCount)) {
      while (next < this.jumps.length && this.jumps[next] <= t) {
        next += 1;
        if (segments.at(-1).length) segments.push([]);
      }
      segments.at(-1).push(t);
    }
    return segments;
  }

  /** Time of the first event in the interval after a sample, s; null without an event. */
  #jumpIn(i) {
    return this.jumps.find((jump) => jump > this.t[i] && jump <= this.t[i + 1]) ?? null;
  }

  /** 1 sigma of the components of quaternion and rate, from the covariances: dq = q (0, theta / 2). */
  #sigmas(column) {
    const [xx, yy, zz, xy, xz, yz] = ["xx", "yy", "zz", "xy", "xz", "yz"].map((name) => column(`attitude_covariance_${name}_rad2`));
    const [w, x, y, z] = this.q;
    const variance = (i, a, b, c) => a * a * xx[i] + b * b * yy[i] + c * c * zz[i] + 2 * (a * b * xy[i] + a * c * xz[i] + b * c * yz[i]);
    const rows = [(i) => [x[i], y[i], z[i]], (i) => [w[i], -z[i], y[i]], (i) => [z[i], w[i], -x[i]], (i) => [-y[i], x[i], w[i]]];
    const quaternion = rows.map((row) => this.t.map((_, i) => 0.5 * Math.sqrt(Math.max(0, variance(i, ...row(i))))));
    const rate = ["xx", "yy", "zz"].map((name) => column(`angular_velocity_covariance_${name}_rad2_s2`).map(Math.sqrt));
    return [quaternion, rate];
  }

  /** Rates as differences of attitudes, for a file without rates. */
  #differences() {
    const columns = [0, 1, 2].map(() => new Float64Array(this.length));
    for (let i = 0; i < this.length; i++) {
      const k = Math.min(i, this.length - 2);
      const turn = k < 0 ? [0, 0, 0] : difference(this.quaternionAt(k), this.quaternionAt(k + 1));
      turn.forEach((angle, axis) => (columns[axis][i] = angle / (this.t[k + 1] - this.t[k] || 1)));
    }
    return columns;
  }

  #momentum() {
    const columns = [0, 1, 2].map(() => new Float64Array(this.length));
    for (let i = 0; i < this.length; i++) {
      const vector = rotate(this.quaternionAt(i), times(this.inertia, this.omegaAt(i)));
      vector.forEach((value, axis) => (columns[axis][i] = value));
    }
    return columns;
  }

  #greatestTurn() {
    let greatest = 0;
    for (let i = 1; i < this.length; i++) {
      const rate = Math.max(this.rate[i - 1], this.rate[i]);
      greatest = Math.max(greatest, rate * (this.t[i] - this.t[i - 1]));
    }
    return greatest;
  }

  /** A linearly interpolated rate, scaled to the interpolated energy. */
  #onEllipsoid(omega, energy) {
    const chordEnergy = 0.5 * dot(omega, times(this.inertia, omega));
    return chordEnergy > 0 && energy > 0 ? omega.map((x) => x * Math.sqrt(energy / chordEnergy)) : omega;
  }
}

function tensor(body) {
  return body.tensor ?? body.moments.map((moment, i) => [0, 1, 2].map((j) => (i === j ? moment : 0)));
}
