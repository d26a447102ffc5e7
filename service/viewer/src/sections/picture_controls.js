// Controls of the picture of the body: track, scenery, camera and solid.

import { byId, make } from "../dom.js";

const TRACKS = { x: "body x", y: "body y", z: "body z", L: "momentum L", omega: "rate ω", sun: "Sun", earth: "nadir", velocity: "velocity" };
const SCENERIES = { attitude: "the attitude", path: "its path", orbit: "its orbit" };
const CAMERAS = { inertial: "inertial axes", body: "body axes", orbit: "orbit axes" };
const SOLIDS = { shape: "its shape", plates: "plates", box: "box of equal inertia", model: "my model" };
const POINTERS = { sun: "Sun", earth: "nadir", velocity: "velocity" };

export class PictureControls {
  /** `onChange` is called with what changed: {track}, {scenery}, {camera}, {solid} or {pointers}. */
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

  /** Offers the choices that a scene has; where it lacks the one wanted, the first is chosen. */
  show({ ephemeris, surroundings }, solids) {
    const canTravel = ephemeris.position && Object.values(solids)[0].metres;
    const { targets, hasOrbit } = surroundings;
    this.#offer("track", TRACKS, ["z", "x", "y", ...(ephemeris.bodyKnown ? ["L"] : []), "omega", ...targets]);
    this.#offer("scenery", SCENERIES, ["attitude", ...(canTravel ? ["path"] : []), ...(hasOrbit ? ["orbit"] : [])]);
    this.#offer("camera", CAMERAS, ["inertial", "body", ...(targets.includes("velocity") ? ["orbit"] : [])]);
    this.#offer("solid", SOLIDS, Object.keys(solids));
    this.#offerPointers(targets);
    return { ...this.choices, pointers: this.pointers };
  }

  #offer(name, words, values) {
    this.choices[name] = values.includes(this.wanted[name]) ? this.wanted[name] : values[0];
    const order = Object.keys(words).filter((value) => values.includes(value));
    byId(name).replaceChildren(...order.map((value) => make("option", { value }, words[value])));
    byId(name).value = this.choices[name];
    byId(name).parentElement.hidden = values.length < 2;
  }

  #offerPointers(targets) {
    const boxes = byId("pointers").querySelectorAll("input");
    const off = new Set([...boxes].filter((box) => !box.checked).map(({ value }) => value));
    byId("pointers").hidden = !targets.length;
    byId("pointers").replaceChildren(
      make("legend", { class: "unseen" }, "Directions shown"),
      ...targets.map((value) => {
        const box = make("input", { type: "checkbox", value });
        box.checked = !off.has(value);
        return make("label", {}, box, ` ${POINTERS[value]}`);
      }),
    );
  }
}
