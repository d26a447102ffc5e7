// Input fields for common members of the document; a change of a field edits the text.

import { byId, make } from "../dom.js";

const NUMBER = /^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*$/;
const xyz = (pointer) => ["x", "y", "z"].map((label, i) => ({ label, pointer: `${pointer}/${i}` }));
const unit = (pointer) => ({ label: "unit", pointer, text: true });
// an element of a symmetric matrix, and its mirror element, which is changed with it
const element = (label) => {
  const [i, j] = [...label].map((axis) => "xyz".indexOf(axis));
  return { label, pointer: `/body/tensor/${i}/${j}`, mirror: i === j ? null : `/body/tensor/${j}/${i}` };
};

// Groups of fields. Fields that the document has are shown; `add` is a member that a button adds.
const GROUPS = [
  { legend: "Principal moments", fields: [...["I1", "I2", "I3"].map((label, i) => ({ label, pointer: `/body/moments/${i}` })), unit("/body/unit")] },
  { legend: "Inertia tensor", fields: [...["xx", "yy", "zz", "xy", "xz", "yz"].map(element), unit("/body/unit")] },
  { legend: "Attitude, quaternion", fields: ["1", "2", "3", "4"].map((label, i) => ({ label, pointer: `/attitude/quaternion/${i}` })) },
  { legend: "Attitude, Euler angles", fields: [...["1", "2", "3"].map((label, i) => ({ label, pointer: `/attitude/euler/${i}` })), unit("/attitude/unit")] },
  { legend: "Body rate", fields: [...xyz("/angular_velocity/value"), unit("/angular_velocity/unit")] },
  { legend: "Epoch", add: "/epoch", fields: [{ label: "date", pointer: "/epoch/time", text: true, wide: true }, { label: "scale", pointer: "/epoch/scale", text: true }] },
  { legend: "Times", fields: [...["start", "stop", "step", "count"].map((label) => ({ label, pointer: `/times/${label}` })), unit("/times/unit")] },
];

export class Form {
  /** `onPut` is called with JSON pointers and the JSON text of their value. */
  constructor(onPut, onRun) {
    this.onPut = onPut;
    this.element = byId("fields");
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      if (event.target === this.element) onRun();
    });
    this.element.addEventListener("change", ({ target }) => this.#written(target));
  }

  /** Shows the values of a document; invalid JSON leaves the fields unchanged. */
  show(text) {
    const document = parsed(text);
    if (!document) return;
    const isComplete = document.body !== undefined; // otherwise a scene or a message may have the rest
    const groups = GROUPS.map((group) => ({ ...group, add: isComplete && group.add, fields: fieldsIn(document, group) }));
    const shape = JSON.stringify(groups);
    if (shape !== this.shape) this.#build(groups);
    this.shape = shape;
    for (const input of this.element.querySelectorAll("input")) {
      if (input.matches(":focus") && input.getAttribute("aria-invalid")) continue;
      input.value = valueAt(document, input.dataset.pointer) ?? "";
      input.removeAttribute("aria-invalid");
    }
  }

  #build(groups) {
    const sets = groups.map(({ legend, fields, add }) => {
      if (!fields.length && !add) return null;
      const inside = fields.length ? fields.map((each) => field(each, legend)) : [this.#adder(add)];
      return make("fieldset", {}, make("legend", {}, legend), ...inside);
    });
    this.element.replaceChildren(...sets.filter(Boolean), make("p", { id: "field-problem", role: "alert", class: "bad", hidden: "" }));
  }

  #adder(pointer) {
    const button = make("button", { type: "button" }, "Add an epoch");
    button.addEventListener("click", () => this.onPut([pointer], '{"time": "2026-01-01T00:00:00", "scale": "utc"}'));
    return button;
  }

  #written(input) {
    const { pointer, mirror, text } = input.dataset;
    const isValid = text ? input.value.trim() !== "" : NUMBER.test(input.value);
    const problem = byId("field-problem");
    problem.hidden = isValid;
    problem.textContent = isValid ? "" : `${input.getAttribute("aria-label")}: a ${text ? "text" : "number"}, not “${input.value}”`;
    if (!isValid) return input.setAttribute("aria-invalid", "true");
    input.removeAttribute("aria-invalid");
    return this.onPut([pointer, mirror].filter(Boolean), text ? JSON.stringify(input.value.trim()) : json(input.value));
  }
}

/** The fields that the document has; none where it has only the unit. */
function fieldsIn(document, { fields }) {
  const present = fields.filter(({ pointer }) => valueAt(document, pointer) !== undefined);
  return present.every(({ label }) => label === "unit") ? [] : present;
}

function field({ label, pointer, mirror, text, wide }, legend) {
  const input = make("input", {
    type: "text", inputmode: text ? null : "decimal", "aria-label": `${legend}, ${label}`, "data-pointer": pointer, "data-mirror": mirror,
    "data-text": text ? "yes" : null, autocomplete: "off", spellcheck: "false", class: wide ? "wide" : null,
  });
  return make("label", {}, make("span", { "aria-hidden": "true" }, label), input);
}

/** A typed number as JSON: no leading plus, digits on both sides of the point. */
const json = (text) => text.trim().replace(/^\+/, "").replace(/^(-?)\./, "$10.").replace(/\.(?=$|[eE])/, "").replace(/^(-?)0+(?=\d)/, "$1");

function parsed(text) {
  try {
    const document = JSON.parse(text);
    return document && typeof document === "object" ? document : null;
  } catch {
    return null;
  }
}

const valueAt = (document, pointer) => pointer.split("/").slice(1).reduce((value, name) => value?.[name], document);
