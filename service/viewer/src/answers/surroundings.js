// Directions to the Sun, to nadir and of the velocity, and the orbit, interpolated between the samples of
// columns that the service computes.

import { cross, dot, norm } from "./rotation.js";

const DIRECTIONS = ["sun", "earth", "velocity"];
const MIN_COSINE = Math.cos(0.5); // of neighbouring samples that are interpolated
const PARTS_PER_SAMPLE = 8; // into which the orbit between two samples is divided when it is drawn

/** The columns needed for the targets of a plan. */
export function surroundingColumns({ targets }) {
  const directions = [...DIRECTIONS, "orbit_normal"].filter((name) => targets.includes(name));
  return [...directions.map((name) => `direction_to:${name}`), ...(targets.includes("earth") ? ["position", "velocity"] : [])];
}

export class Surroundings {
  constructor(ephemeris, columns, plan) {
    this.ephemeris = ephemeris;
    this.centralBody = plan?.central_body ?? null;
    this.columns = columns;
    this.targets = DIRECTIONS.filter((name) => columns[`direction_to:${name}`]?.data);
    // where the centre of mass is simulated, its positions are no longer those of the orbit
    this.hasOrbit = Boolean(columns.position?.data) && !ephemeris.position;
  }

  /** Unit vector to a target at a time, inertial components. */
  direction(name, t) {
    const [here, next, part] = this.#around(`direction_to:${name}`, t);
    if (dot(here, next) < MIN_COSINE) return here;
    const vector = here.map((x, k) => x + part * (next[k] - x));
    return vector.map((x) => x / norm(vector));
  }

  /** Position on the orbit, m: Hermite interpolation of the positions and velocities of two samples. */
  position(t) {
    const [r0, r1, part, span] = this.#around("position", t);
    const [v0, v1] = this.#around("velocity", t);
    if (dot(r0, r1) < MIN_COSINE * norm(r0) * norm(r1)) return r0;
    return r0.map((x, k) => hermite(part, x, r1[k], span * v0[k], span * v1[k]));
  }

  /** The orbit as segments of positions that can be joined by lines. */
  path() {
    const { t } = this.ephemeris;
    const segments = [[]];
    for (let i = 0; i < t.length; i++) {
      const [here, next] = [this.#row("position", i), this.#row("position", Math.min(i + 1, t.length - 1))];
      const parts = dot(here, next) < MIN_COSINE * norm(here) * norm(next) ? 1 : PARTS_PER_SAMPLE;
      const step = ((t[i + 1] ?? t[i]) - t[i]) / parts;
      for (let k = 0; k < (step > 0 ? parts : 1); k++) segments.at(-1).push(this.position(t[i] + k * step));
      if (parts === 1 && i < t.length - 1) segments.push([]);
    }
    return segments;
  }

  /** Rows: unit vectors along the track, across it, and up. */
  axes(t) {
    const up = this.direction("earth", t).map((x) => -x);
    const normal = this.direction("orbit_normal", t);
    const along = cross(normal, up);
    return [along, cross(up, along), up];
  }

  #around(name, t) {
    const { ephemeris } = this;
    const i = ephemeris.index(t);
    const j = Math.min(i + 1, ephemeris.length - 1);
    const span = ephemeris.t[j] - ephemeris.t[i];
    return [this.#row(name, i), this.#row(name, j), span > 0 ? Math.min(1, (t - ephemeris.t[i]) / span) : 0, span];
  }

  #row(name, i) {
    return this.columns[name].data.map((column) => column[i]);
  }
}

function hermite(s, a, b, slopeA, slopeB) {
  const [s2, s3] = [s * s, s * s * s];
  return (2 * s3 - 3 * s2 + 1) * a + (s3 - 2 * s2 + s) * slopeA + (3 * s2 - 2 * s3) * b + (s3 - s2) * slopeB;
}
