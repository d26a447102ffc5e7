// What else is plotted: columns of the ephemeris that the reader chooses, as the service computes them.

import * as api from "./api.js";
import { byId, make } from "./dom.js";
import { words } from "./numbers.js";

const AXES = ["x", "y", "z", "-x", "-y", "-z"];
const TARGETS = { sun: "Sun", earth: "nadir", velocity: "velocity", momentum: "momentum", magnetic_field: "magnetic field" };
const SEQUENCES = ["ZYX", "ZXZ", "ZYZ", "XYZ"];
const PAINTS = ["--x", "--y", "--z", "--ink", "--rate"];

// A kind of column: its words, the choices that complete its name, and its title.
const KINDS = {
  angle: { words: "Angle of a body axis to", choices: [AXES, Object.keys(TARGETS)], title: (axis, to) => `Angle of body ${axis} to ${TARGETS[to]}` },
  direction: { words: "Direction of a body axis", choices: [AXES], title: (axis) => `Direction of body ${axis}, inertial components` },
  euler: { words: "Euler angles", choices: [SEQUENCES], title: (sequence) => `Euler angles, ${sequence}` },
  spin: { words: "Spin axis, nutation and phase", choices: [], title: () => "Spin" },
};

export class Quantities {
  /** `onChange` is called when the choice has changed. */
  constructor(onChange) {
    this.chosen = [];
    this.onChange = onChange;
    byId("quantity").replaceChildren(...Object.entries(KINDS).map(([value, { words }]) => make("option", { value }, words)));
    byId("quantity").addEventListener("change", () => this.#offer());
    byId("quantity-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#add();
    });
    this.#offer();
  }

  /** Curves of every chosen column for this document; a column that it cannot have says why. */
  curves(text, signal) {
    return Promise.all(this.chosen.map((column) => this.#curve(column, text, signal)));
  }

  remove(column) {
    this.chosen = this.chosen.filter((each) => each !== column);
    this.onChange();
  }

  async #curve(column, text, signal) {
    const [kind, ...choices] = column.split(":");
    const curve = { column, title: KINDS[kind].title(...choices), series: [], remove: () => this.remove(column) };
    try {
      const path = `v1/ephemeris?columns=${encodeURIComponent(`elapsed,${column}`)}`;
      const { elapsed_s: elapsed, elapsed_rest_s: rest, ...columns } = (await api.post(path, text, signal)).columns;
      const order = Array.from(elapsed.keys()).sort((i, j) => elapsed[i] - elapsed[j]);
      curve.series = Object.entries(columns).map(([name, values], i) => ({
        name: words(name),
        data: order.map((k) => values[k]),
        paint: PAINTS[i % PAINTS.length],
      }));
    } catch (error) {
      if (!(error instanceof api.Refusal)) throw error;
      curve.refused = error.message;
    }
    return curve;
  }

  #offer() {
    const { choices } = KINDS[byId("quantity").value];
    const labels = ["Axis or sequence", "Target"];
    byId("quantity-choices").replaceChildren(
      ...choices.map((values, i) => make("select", { "aria-label": labels[i] }, ...values.map((value) => make("option", { value }, TARGETS[value] ?? value)))),
    );
  }

  #add() {
    const choices = [...byId("quantity-choices").children].map((select) => select.value);
    const column = [byId("quantity").value, ...choices].join(":");
    if (this.chosen.includes(column)) return;
    this.chosen.push(column);
    this.onChange();
  }
}
