// What the picture of the body shows: which track, where it is seen from, as what the body is drawn.

import { byId, make } from "../dom.js";

const TRACKS = { x: "body x", y: "body y", z: "body z", L: "momentum L", omega: "rate ω", sun: "Sun", earth: "nadir", velocity: "velocity" };
const SCENERIES = { attitude: "the attitude", path: "its path", orbit: "its orbit" };
const CAMERAS = { inertial: "inertial axes", body: "body axes", orbit: "orbit axes" };
const SOLIDS = { shape: "its shape", plates: "plates", box: "box of equal inertia", model: "my model" };
const POINTERS = { sun: "Sun", earth: "nadir", velocity: "velocity" };

export class PictureControls {
  /** `onChange` is told what changed: {track}, {scenery}, {camera}, {solid}, {pointers}. */
  constructor(onChange) {
    this.wanted = { track: "z", scenery: "attitude", camera: "inertial", solid: null };
    this.choices = { ...this.wanted };
    for (const name of Object.keys(this.wanted)) {
      byId(name).addEventListener("change", ({ target }) => {
        this.wanted[name] = this.choices[name] = target.value;
        onChange({ [name]: target.value });
      });
    }
    byId("pointers").addEventListener("change", () => onChange({ pointers: this.pointers }));
  }

  get pointers() {
    return new Set([...byId("pointers").querySelectorAll("input:checked")].map(({ value }) => value));
  }

  /** The choices that a scene has; of what was wanted and it has not, the first. */
  show({ course, about }, solids) {
    const canTravel = course.place && Object.values(solids)[0].metres;
    const { known, hasOrbit } = about;
    this.#offer("track", TRACKS, ["z", "x", "y", ...(course.bodyKnown ? ["L"] : []), "omega", ...known]);
    this.#offer("scenery", SCENERIES, ["attitude", ...(canTravel ? ["path"] : []), ...(hasOrbit ? ["orbit"] : [])]);
    this.#offer("camera", CAMERAS, ["inertial", "body", ...(known.includes("velocity") ? ["orbit"] : [])]);
    this.#offer("solid", SOLIDS, Object.keys(solids));
    this.#offerPointers(known);
    return { ...this.choices, pointers: this.pointers };
  }

  #offer(name, words, values) {
    this.choices[name] = values.includes(this.wanted[name]) ? this.wanted[name] : values[0];
    const order = Object.keys(words).filter((value) => values.includes(value));
    byId(name).replaceChildren(...order.map((value) => make("option", { value }, words[value])));
    byId(name).value = this.choices[name];
    byId(name).parentElement.hidden = values.length < 2;
  }

  #offerPointers(known) {
    const boxes = byId("pointers").querySelectorAll("input");
    const off = new Set([...boxes].filter((box) => !box.checked).map(({ value }) => value));
    byId("pointers").hidden = !known.length;
    byId("pointers").replaceChildren(
      make("legend", { class: "unseen" }, "Directions shown"),
      ...known.map((value) => {
        const box = make("input", { type: "checkbox", value });
        box.checked = !off.has(value);
        return make("label", {}, box, ` ${POINTERS[value]}`);
      }),
    );
  }
}
