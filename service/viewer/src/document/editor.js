// The document as text: an element <json-editor> with undo, colours, completion of keys, and errors at their
// lines. In a shadow root CodeMirror adopts its style sheets, which a strict content security policy allows.

import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, isolateHistory } from "@codemirror/commands";
import { json } from "@codemirror/lang-json";
import { bracketMatching, foldGutter, HighlightStyle, syntaxHighlighting } from "@codemirror/language";
import { EditorState, StateEffect, StateField } from "@codemirror/state";
import { Decoration, drawSelection, EditorView, highlightActiveLine, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { completionsFrom } from "./completion.js";
import { byId } from "../dom.js";
import { changeOf, find, tidy } from "./json_text.js";

const COLOURS = HighlightStyle.define([
  { tag: tags.propertyName, color: "var(--accent)" },
  { tag: tags.string, color: "color-mix(in srgb, var(--y) 78%, var(--ink))" },
  { tag: tags.number, color: "var(--ink)" },
  { tag: [tags.bool, tags.null], color: "var(--rate)" },
]);

// The characters that are marked as wrong, or null.
const setWrong = StateEffect.define();
const wrong = StateField.define({
  create: () => Decoration.none,
  update(marks, transaction) {
    const set = transaction.effects.find((effect) => effect.is(setWrong));
    if (!set) return marks.map(transaction.changes);
    if (!set.value) return Decoration.none;
    const { start, end } = set.value;
    const line = Decoration.line({ class: "cm-wrong-line" }).range(transaction.state.doc.lineAt(start).from);
    const mark = end > start ? [Decoration.mark({ class: "cm-wrong" }).range(start, end)] : [];
    return Decoration.set([line, ...mark], true);
  },
  provide: (field) => EditorView.decorations.from(field),
});

const THEME = EditorView.theme({
  "&": { height: "100%", background: "var(--page)", color: "var(--ink)", fontSize: "0.78125rem" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.55" },
  ".cm-content": { caretColor: "var(--ink)", overflowWrap: "anywhere" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  ".cm-gutters": { background: "var(--page)", color: "var(--muted)", border: "0" },
  ".cm-activeLine, .cm-activeLineGutter": { background: "color-mix(in srgb, var(--accent) 8%, transparent)" },
  "&.cm-focused .cm-selectionBackground, .cm-selectionBackground": {
    background: "color-mix(in srgb, var(--accent) 28%, transparent) !important",
  },
  ".cm-tooltip": { background: "var(--panel)", color: "var(--ink)", border: "1px solid var(--rule)" },
  ".cm-tooltip-autocomplete > ul > li[aria-selected]": { background: "var(--accent)", color: "var(--accent-ink)" },
  ".cm-completionDetail": { color: "var(--muted)", fontStyle: "normal" },
  ".cm-wrong-line": { background: "var(--bad-wash)" },
  ".cm-wrong": { textDecoration: "underline wavy var(--bad)" },
  ".cm-matchingBracket": { background: "color-mix(in srgb, var(--accent) 22%, transparent) !important" },
});

class JsonEditor extends HTMLElement {
  /** Builds the editor inside this element; `completions` is a completion source. */
  start({ onRun, onChange, completions }) {
    this.onChange = onChange;
    const run = () => {
      onRun();
      return true;
    };
    this.extensions = [
      lineNumbers(), foldGutter(), wrong, history(), drawSelection(), bracketMatching(), closeBrackets(),
      highlightActiveLine(), EditorView.lineWrapping, json(), syntaxHighlighting(COLOURS), THEME,
      autocompletion({ override: [completions], icons: false }),
      keymap.of([
        { key: "Mod-Enter", run },
        ...closeBracketsKeymap, ...defaultKeymap, ...historyKeymap, ...completionKeymap,
      ]),
      EditorView.contentAttributes.of({ "aria-label": "Scene document, JSON", tabindex: "0" }),
      EditorView.updateListener.of((update) => update.docChanged && this.onChange()),
    ];
    const root = this.attachShadow({ mode: "open" });
    this.view = new EditorView({ parent: root, root, state: this.#state("") });
  }

  get value() {
    return this.view.state.doc.toString();
  }

  /** Replaces the text; undo restores the one before. */
  set value(text) {
    const { length } = this.view.state.doc;
    const annotations = isolateHistory.of("full");
    if (text !== this.value) this.view.dispatch({ changes: { from: 0, to: length, insert: text }, annotations });
  }

  /** Marks characters as wrong, selects them and scrolls to them; null removes the mark. */
  mark(place) {
    const effects = [setWrong.of(place)];
    if (!place) return this.view.dispatch({ effects });
    effects.push(EditorView.scrollIntoView(place.start, { y: "center" }));
    return this.view.dispatch({ effects, selection: { anchor: place.start, head: place.end } });
  }

  /** Applies changes that are undone in one step. */
  change(changes) {
    this.view.dispatch({ changes, annotations: isolateHistory.of("full") });
  }

  lineAt(position) {
    return this.view.state.doc.lineAt(Math.min(position, this.view.state.doc.length)).number;
  }

  line(number) {
    const { from, to } = this.view.state.doc.line(Math.min(number, this.view.state.doc.lines));
    return { start: from, end: to };
  }

  setInvalid(invalid, by) {
    const content = this.view.contentDOM;
    if (invalid) content.setAttribute("aria-invalid", "true");
    else content.removeAttribute("aria-invalid");
    content.setAttribute("aria-description", invalid ? by : "");
  }

  #state(text) {
    return EditorState.create({ doc: text, extensions: this.extensions });
  }
}

customElements.define("json-editor", JsonEditor);

export class Editor {
  /** `onChange` is called when the user has typed, `onText` whenever the text has changed;
   * `schema`, which resolves to the OpenAPI document, is called once, for the first completion. */
  constructor({ onRun, onChange, onText, schema }) {
    this.element = byId("document");
    this.problem = byId("document-problem");
    this.isProgrammatic = false;
    Object.assign(this, { onChange, onText });
    this.element.start({ onRun, onChange: () => this.#changed(), completions: completionsFrom(schema) });
    byId("tidy").addEventListener("click", () => (this.element.value = tidy(this.text)));
  }

  get text() {
    return this.element.value;
  }

  /** Sets members to a value, JSON text, as if it had been typed. */
  put(pointers, value) {
    const changes = pointers.map((pointer) => changeOf(this.text, pointer, value)).filter(Boolean);
    if (changes.length) this.element.change(changes);
  }

  /** Sets the text without a call of `onChange`. */
  set text(value) {
    this.isProgrammatic = true;
    this.element.value = value;
    this.isProgrammatic = false;
    this.clearError();
  }

  /** Shows a refusal: its line marked, its text below the document, its value selected. */
  showError(refusal) {
    const place = this.#placeOf(refusal);
    this.problem.textContent = place ? `Line ${this.element.lineAt(place.start)}: ${refusal.message}` : refusal.message;
    this.problem.hidden = false;
    byId("document-details").open = true;
    this.element.mark(place);
    this.element.setInvalid(true, refusal.message);
  }

  clearError() {
    if (this.problem.hidden) return;
    this.problem.hidden = true;
    this.element.mark(null);
    this.element.setInvalid(false);
  }

  #placeOf({ pointer, line }) {
    if (typeof pointer === "string") return find(this.text, pointer);
    return line ? this.element.line(line) : null;
  }

  #changed() {
    this.clearError();
    this.onText();
    if (!this.isProgrammatic) this.onChange();
  }
}
