// Constants of the motion, and the state at the current time.

import { make } from "../dom.js";
import { degrees, duration, figure, words } from "../numbers.js";
import { norm } from "../answers/rotation.js";

const REGIMES = {
  short_axis: "short-axis: round the axis of greatest moment",
  long_axis: "long-axis: round the axis of least moment",
  separatrix: "separatrix: asymptotic to the middle axis",
  constant_rate: "constant rate",
};

export class Readouts {
  constructor(element) {
    this.element = element;
  }

  /** `motion` is the answer of /v1/motion, or the text of its refusal. */
  show(ephemeris, motion, hasTorques) {
    this.ephemeris = ephemeris;
    this.live = {};
    const rows = [
      ...motionRows(motion, hasTorques),
      ["Samples", `${ephemeris.length.toLocaleString("en")}, ${ephemeris.frame}`],
      ...costRows(ephemeris.cost),
      ["Time of the sample", this.#live("date")],
      ["Rate |ω|", this.#live("rate")],
      ...(ephemeris.bodyKnown ? [["Momentum |L|", this.#live("momentum")], ["Rotational energy", this.#live("energy")]] : []),
    ];
    this.element.replaceChildren(...rows.map(([name, value]) => make("div", {}, make("dt", {}, name), make("dd", {}, value))));
  }

  at(time) {
    const { ephemeris, live } = this;
    const i = ephemeris.index(time);
    live.date.textContent = ephemeris.dates ? dated(ephemeris.dates[i], ephemeris.scale) : `${figure(ephemeris.t[i], 8)} s`;
    live.rate.textContent = `${figure(ephemeris.rate[i], 6)} rad/s`;
    if (!ephemeris.bodyKnown) return;
    live.momentum.textContent = `${figure(norm(ephemeris.momentumAt(i)), 6)} N m s`;
    live.energy.textContent = `${figure(ephemeris.energy[i], 6)} J`;
  }

  #live(name) {
    this.live[name] = make("span", {});
    return this.live[name];
  }
}

const dated = (date, scale) => `${date.replace("T", " ").replace(/(\.\d{3})\d*$/, "$1")} ${scale.toUpperCase()}`;

function motionRows(motion, hasTorques) {
  if (typeof motion === "string") return [["Motion", motion]];
  const at = hasTorques ? " at the epoch" : "";
  const rate = motion.mean_precession_rate_rad_s;
  return [
    [`Regime${at}`, REGIMES[motion.regime] ?? words(motion.regime)],
    [`Polhode period${at}`, motion.polhode_period_s === null ? "none" : duration(motion.polhode_period_s, 6)],
    [`Precession period${at}`, rate ? duration((2 * Math.PI) / Math.abs(rate), 6) : "none"],
    [`Nutation${at}`, nutation(motion.nutation_range_rad)],
  ];
}

function nutation([low, high]) {
  return high - low < 1e-9 ? degrees(low) : `${degrees(low)} to ${degrees(high)}`;
}

function costRows(cost) {
  if (!cost) return [];
  const bound = cost.error_bound_rad;
  return [
    ["Solver", cost.solver],
    ["Computed in", duration((cost.set_up_s ?? 0) + cost.sample_s, 3)],
    ["Error at most", bound === null || bound === undefined ? "not known" : withSource(`${figure(bound, 2)} rad`, cost.error_bound_source)],
  ];
}

const withSource = (text, source) => make("span", { title: source ?? "" }, text);
