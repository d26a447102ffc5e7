// What is about the body: directions to the Sun, to nadir and of the velocity, and the orbit. All of it is
// columns of the service; here they are read between samples.

import { cross, dot, norm } from "./rotation.js";

const DIRECTIONS = ["sun", "earth", "velocity"];
const FAR = Math.cos(0.5); // directions further apart from sample to sample are not joined
const PARTS = 8; // of the orbit between two samples, for a line that looks smooth

/** The columns that are needed for what a plan knows. */
export function columnsAbout({ targets }) {
  const known = [...DIRECTIONS, "orbit_normal"].filter((name) => targets.includes(name));
  return [...known.map((name) => `direction_to:${name}`), ...(targets.includes("earth") ? ["position", "velocity"] : [])];
}

export class Surroundings {
  constructor(course, columns, plan) {
    this.course = course;
    this.centralBody = plan?.central_body ?? null;
    this.columns = columns;
    this.known = DIRECTIONS.filter((name) => columns[`direction_to:${name}`]?.data);
    // where the centre of mass is followed, its positions are no longer those of the orbit
    this.hasOrbit = Boolean(columns.position?.data) && !course.place;
  }

  /** Unit vector to a target at a time, inertial components. */
  direction(name, t) {
    const [here, next, part] = this.#around(`direction_to:${name}`, t);
    if (dot(here, next) < FAR) return here;
    const vector = here.map((x, k) => x + part * (next[k] - x));
    return vector.map((x) => x / norm(vector));
  }

  /** Place in the orbit, m: by Hermite's polynomial of the places and velocities of two samples. */
  place(t) {
    const [r0, r1, part, span] = this.#around("position", t);
    const [v0, v1] = this.#around("velocity", t);
    if (dot(r0, r1) < FAR * norm(r0) * norm(r1)) return r0;
    return r0.map((x, k) => hermite(part, x, r1[k], span * v0[k], span * v1[k]));
  }

  /** Stretches of the orbit that can be joined. */
  path() {
    const { t } = this.course;
    const stretches = [[]];
    for (let i = 0; i < t.length; i++) {
      const [here, next] = [this.#row("position", i), this.#row("position", Math.min(i + 1, t.length - 1))];
      const parts = dot(here, next) < FAR * norm(here) * norm(next) ? 1 : PARTS;
      const step = ((t[i + 1] ?? t[i]) - t[i]) / parts;
      for (let k = 0; k < (step > 0 ? parts : 1); k++) stretches.at(-1).push(this.place(t[i] + k * step));
      if (parts === 1 && i < t.length - 1) stretches.push([]);
    }
    return stretches;
  }

  /** Axes of the orbit along the rows: along the track, across it, and up. */
  axes(t) {
    const up = this.direction("earth", t).map((x) => -x);
    const normal = this.direction("orbit_normal", t);
    const along = cross(normal, up);
    return [along, cross(up, along), up];
  }

  #around(name, t) {
    const { course } = this;
    const i = course.index(t);
    const j = Math.min(i + 1, course.length - 1);
    const span = course.t[j] - course.t[i];
    return [this.#row(name, i), this.#row(name, j), span > 0 ? Math.min(1, (t - course.t[i]) / span) : 0, span];
  }

  #row(name, i) {
    return this.columns[name].data.map((column) => column[i]);
  }
}

function hermite(s, a, b, slopeA, slopeB) {
  const [s2, s3] = [s * s, s * s * s];
  return (2 * s3 - 3 * s2 + 1) * a + (s3 - 2 * s2 + s) * slopeA + (3 * s2 - 2 * s3) * b + (s3 - s2) * slopeB;
}
