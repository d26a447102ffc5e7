// Further columns of the ephemeris that the user chooses to plot; the service computes them.

import { byId, make } from "../dom.js";

export const AXES = ["x", "y", "z", "-x", "-y", "-z"];
export const TARGETS = { sun: "Sun", earth: "nadir", velocity: "velocity", orbit_normal: "orbit normal", momentum: "momentum", magnetic_field: "magnetic field" };
const SEQUENCES = ["ZYX", "ZXZ", "ZYZ", "XYZ"];

// A kind of column: its label, the choices that complete its name, its title, and whether the axis has 1 sigma.
const KINDS = {
  angle: { words: "Angle of a body axis to", choices: [AXES, Object.keys(TARGETS)], title: (axis, to) => `Angle of body ${axis} to ${TARGETS[to]}`, sigma: true },
  direction: { words: "Direction of a body axis", choices: [AXES], title: (axis) => `Direction of body ${axis}, inertial components`, sigma: true },
  direction_sigma: { words: "1 sigma of a body axis's direction", choices: [AXES], title: (axis) => `1 sigma of the direction of body ${axis}` },
  attitude_sigma: { words: "1 sigma of the attitude", choices: [], title: () => "1 sigma of the attitude, about the body axes" },
  radec: { words: "RA and Dec of a body axis", choices: [AXES], title: (axis) => `RA and Dec of body ${axis}` },
  euler: { words: "Euler angles", choices: [SEQUENCES], title: (sequence) => `Euler angles, ${sequence}` },
  euler_sigma: { words: "1 sigma of Euler angles", choices: [SEQUENCES], title: (sequence) => `1 sigma of Euler angles, ${sequence}` },
  spin: { words: "Spin axis, nutation and phase", choices: [], title: () => "Spin" },
};

export class Quantities {
  /** `onChange` is called when the choice has changed. */
  constructor(onChange) {
    this.names = [];
    this.onChange = onChange;
    byId("quantity").replaceChildren(...Object.entries(KINDS).map(([value, { words }]) => make("option", { value }, words)));
    byId("quantity").addEventListener("change", () => this.#offer());
    byId("quantity-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#add();
    });
    this.#offer();
  }

  /** {column, title, sigmaColumn} of each choice; sigmaColumn only where the document states an uncertainty. */
  chosen(uncertain) {
    return this.names.map((column) => {
      const [kind, ...choices] = column.split(":");
      const sigmaColumn = uncertain && KINDS[kind].sigma ? `direction_sigma:${choices[0]}` : null;
      return { column, title: KINDS[kind].title(...choices), sigmaColumn };
    });
  }

  /** The columns to request for these choices. */
  columns(uncertain) {
    return this.chosen(uncertain).flatMap(({ column, sigmaColumn }) => (sigmaColumn ? [column, sigmaColumn] : [column]));
  }

  remove(column) {
    this.names = this.names.filter((each) => each !== column);
    this.onChange();
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
    if (this.names.includes(column)) return;
    this.names.push(column);
    this.onChange();
  }
}
