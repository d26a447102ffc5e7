// The document as text: line numbers and colours behind a plain text area, and what the service
// refuses at the line it is about.

import { byId, make } from "./dom.js";
import { find, pieces, tidy } from "./json_text.js";

export class Editor {
  constructor(onRun, onChange) {
    this.area = byId("document");
    this.lines = document.querySelector(".editor-lines");
    this.problem = byId("document-problem");
    this.onChange = onChange;
    this.area.addEventListener("input", () => this.#changed());
    this.area.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) onRun();
      if (event.key === "Escape") this.forgive();
    });
    byId("tidy").addEventListener("click", () => this.#tidied());
    new ResizeObserver(() => this.#place()).observe(this.area);
  }

  get text() {
    return this.area.value;
  }

  set text(value) {
    this.area.value = value;
    this.#paint();
    this.forgive();
  }

  /** Shows a refusal at its field: the line marked, the words below it, the value selected. */
  refuse(refusal) {
    const place = this.#placeOf(refusal);
    this.bad = place ? this.#lineAt(place.start) : null;
    this.problem.textContent = refusal.message;
    this.problem.hidden = false;
    this.area.setAttribute("aria-invalid", "true");
    this.area.setAttribute("aria-describedby", this.problem.id);
    byId("document-details").open = true;
    this.#paint();
    if (place) this.area.setSelectionRange(place.start, place.end);
    this.#place(true);
  }

  forgive() {
    this.bad = null;
    this.problem.hidden = true;
    this.area.removeAttribute("aria-invalid");
    this.area.removeAttribute("aria-describedby");
    for (const line of this.lines.children) line.classList.remove("bad");
  }

  #placeOf({ pointer, line }) {
    if (typeof pointer === "string") return find(this.text, pointer);
    if (!line) return null;
    const rows = this.text.split("\n");
    const start = rows.slice(0, line - 1).reduce((sum, row) => sum + row.length + 1, 0);
    return { start, end: start + (rows[line - 1] ?? "").length };
  }

  #lineAt(position) {
    return this.text.slice(0, position).split("\n").length - 1;
  }

  #tidied() {
    this.text = tidy(this.text);
    this.onChange();
  }

  #changed() {
    this.forgive();
    this.#paint();
    this.onChange();
  }

  #paint() {
    const rows = this.text.split("\n");
    this.lines.replaceChildren(...rows.map((row, i) => this.#row(row, i)));
  }

  #row(text, i) {
    const parts = pieces(text).map(([kind, piece]) => (kind ? make("span", { class: kind }, piece) : piece));
    return make("div", { class: i === this.bad ? "line bad" : "line" }, ...(parts.length ? parts : ["\u200b"]));
  }

  /** The words go below their line, and into sight. */
  #place(show = false) {
    if (this.problem.hidden) return;
    const line = this.lines.children[this.bad ?? 0];
    if (!line) return;
    this.problem.style.top = `${line.offsetTop + line.offsetHeight}px`;
    if (show) line.scrollIntoView({ block: "center", behavior: "instant" });
  }
}
