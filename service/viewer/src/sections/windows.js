// Windows in which a condition holds: requested from the service, listed, and shaded on every plot.

import * as api from "../answers/api.js";
import { byId, make } from "../dom.js";
import { duration, figure, unitFor } from "../numbers.js";
import { table } from "./plan.js";
import { AXES, TARGETS } from "./quantities.js";
import { linkTo } from "./saving.js";

const MAX_ROWS = 200;
const SHADOWS = { umbra: "the umbra", penumbra: "the penumbra" };

export class WindowsSection {
  /** `onResult` is called with the windows, `onPick` with a time, s. */
  constructor(onResult, onPick) {
    Object.assign(this, { onResult, onPick, isRequested: false });
    const options = (choices) => Object.entries(choices).map(([value, text]) => make("option", { value }, text));
    byId("window-axis").replaceChildren(...AXES.map((axis) => make("option", { value: axis }, `body ${axis}`)));
    byId("window-axis").value = "z";
    byId("window-shadow").replaceChildren(...options(SHADOWS));
    byId("window-kind").addEventListener("change", () => this.#offer());
    byId("window-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.isRequested = true;
      this.find();
    });
    byId("window-clear").addEventListener("click", () => this.#clear());
    byId("window-file").addEventListener("click", () => this.#file());
  }

  /** Shows another scene; the condition is requested again where the scene has targets. */
  show({ text, plan, ephemeris }) {
    Object.assign(this, { text, ephemeris });
    const targets = plan?.targets ?? [];
    byId("window-to").replaceChildren(...targets.map((value) => make("option", { value }, TARGETS[value])));
    byId("window-kind").querySelector("[value=shadow]").disabled = !targets.includes("sun") || !targets.includes("earth");
    if (byId("window-kind").selectedOptions[0].disabled) byId("window-kind").value = "below";
    byId("window-find").disabled = !targets.length;
    this.#offer();
    this.#empty();
    if (this.isRequested && targets.length) this.find();
  }

  async find() {
    const { text } = this;
    const condition = this.#condition();
    this.#setStatus("Searching");
    try {
      const answer = await api.post("v1/windows", body(text, condition));
      if (text === this.text) this.#list(answer);
    } catch (error) {
      if (!(error instanceof api.Refusal)) throw error;
      this.#empty();
      this.#setStatus(error.message, "bad");
    }
  }

  #condition() {
    const kind = byId("window-kind").value;
    if (kind === "shadow") return { shadow: byId("window-shadow").value };
    const limit = { value: Number(byId("window-angle").value), unit: "deg" };
    return { axis: byId("window-axis").value, to: byId("window-to").value, [kind]: limit };
  }

  #offer() {
    const isShadow = byId("window-kind").value === "shadow";
    byId("window-angle-fields").hidden = isShadow;
    byId("window-shadow").hidden = !isShadow;
  }

  #list({ windows, total_s: total, span_s: [start, stop] }) {
    const share = figure((100 * total) / (stop - start || 1), 3);
    const count = windows.length === 1 ? "1 window" : `${windows.length.toLocaleString("en")} windows`;
    const more = windows.length > MAX_ROWS ? ` The first ${MAX_ROWS} are listed; the file holds all.` : "";
    this.#setStatus(windows.length ? `${count}, ${duration(total)} in all: ${share} % of the span.${more}` : "No window: the condition never holds.");
    const unit = unitFor(Math.max(...windows.map((each) => each.duration_s)));
    const heads = ["From", "To", `Lasts, ${unit.name}`, "In the picture"];
    byId("window-list").replaceChildren(windows.length ? table(heads, windows.slice(0, MAX_ROWS).map((each) => this.#row(each, unit))) : "");
    byId("window-clear").hidden = false;
    byId("window-file").hidden = !windows.length;
    this.onResult(windows);
  }

  #row(window, unit) {
    const end = (name, cut) => (cut ? "(span) " : "") + (window[name] ? dated(window[name]) : `${figure(window[`${name}_s`], 9)} s`);
    const go = make("button", { type: "button", class: "quiet" }, "Show");
    go.setAttribute("aria-label", `Show ${end("start")}`);
    go.addEventListener("click", () => this.onPick(window.start_s));
    return [end("start", window.begins_before), end("stop", window.ends_after), figure(window.duration_s / unit.seconds, 6), go];
  }

  async #file() {
    try {
      const { blob, name } = await api.download("v1/windows?format=csv", body(this.text, this.#condition()), "windows.csv");
      const link = linkTo(blob, name);
      byId("window-status").replaceChildren(link);
      link.click();
    } catch (error) {
      this.#setStatus(error.message, "bad");
    }
  }

  #clear() {
    this.isRequested = false;
    this.#empty();
  }

  #empty() {
    this.#setStatus("");
    byId("window-list").replaceChildren();
    byId("window-clear").hidden = byId("window-file").hidden = true;
    this.onResult([]);
  }

  #setStatus(text, kind = "") {
    byId("window-status").textContent = text;
    byId("window-status").className = kind;
  }
}

/** The request, with the text of the scene unchanged. */
const body = (text, condition) => `{"scene": ${text}, "condition": ${JSON.stringify(condition)}}`;

const dated = (date) => date.replace("T", " ").replace(/(\.\d{3})\d*$/, "$1");
