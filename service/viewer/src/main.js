// Wiring: the document is asked about, and what comes back goes to every part of the page.

import * as api from "./answers/api.js";
import { columnsOf } from "./answers/columns.js";
import { answersAbout, answersTo, answersWithin } from "./answers/scene.js";
import { columnsAbout } from "./answers/surroundings.js";
import { Editor } from "./document/editor.js";
import { Form } from "./document/form.js";
import { tidy, withMember } from "./document/json_text.js";
import { keepDocument, keptDocument, packed, unpacked } from "./document/link.js";
import { byId, make } from "./dom.js";
import { duration, figure } from "./numbers.js";
import { BodyView } from "./pictures/body_view.js";
import { modelSolid } from "./pictures/model.js";
import { PolhodeView } from "./pictures/polhode_view.js";
import { solidsOf } from "./pictures/solid.js";
import { forgetCost, offerCost } from "./sections/cost.js";
import { offerDownloads } from "./sections/downloads.js";
import { PictureControls } from "./sections/picture_controls.js";
import { showPlan } from "./sections/plan.js";
import { Player } from "./sections/player.js";
import { Plots } from "./sections/plots.js";
import { Quantities } from "./sections/quantities.js";
import { Readouts } from "./sections/readouts.js";
import { installTheme } from "./sections/theme.js";
import { WindowsSection } from "./sections/windows.js";

const FIRST = "dzhanibekov";
const CLOSER_TURN = 0.15; // rad from sample to sample, looked at closely
const CLOSER_SAMPLES = 1500;

// `shown` is of answers/scene.js, `reference` one of before; `whole` the document that was looked at closer.
const state = { shipped: "", shown: null, reference: null, running: null, whole: null, model: null };
const views = { body: viewIn("body-view", BodyView), polhode: viewIn("polhode-view", PolhodeView) };
const player = new Player(showTime);
const plots = new Plots(byId("plots"), (time) => player.seek(time), (column) => quantities.remove(column));
const quantities = new Quantities(() => showChosen().catch(fail));
const windows = new WindowsSection(shadeWindows, (time) => player.seek(time));
const readouts = new Readouts(byId("readouts"));
const controls = new PictureControls((change) => redraw(change));
const editor = new Editor({ onRun: run, onChange: edited, onText: () => form.show(editor.text), schema: () => api.get("openapi.json") });
const form = new Form((pointers, value) => editor.put(pointers, value), run);

/** A view in 3D; in words where the browser has no WebGL. */
function viewIn(id, View) {
  try {
    if (document.createElement("canvas").getContext("webgl2")) return new View(byId(id));
  } catch {
    // a context that was promised and is not given
  }
  const said = "This browser shows no 3D here (WebGL is absent or switched off). Plots, figures and files are all there.";
  byId(id).replaceChildren(make("p", { class: "no-3d" }, said));
  return null;
}

function showTime(time) {
  for (const part of [views.body, state.shown.course.bodyKnown ? views.polhode : null, plots]) part?.at(time);
  readouts.at(time);
}

// -- scenes ---------------------------------------------------------------------------------------

function start() {
  installTheme(repaint);
  listen();
  if (byId("answers")) return showWithin(JSON.parse(byId("answers").textContent));
  offerCost(() => editor.text);
  return begin();
}

/** What needs the service; again, when it has been given its token. */
async function begin() {
  try {
    await Promise.all([offerScenes(), offerDownloads(byId("downloads"), () => editor.text), showVersion()]);
    await open();
  } catch (error) {
    fail(error);
  }
}

/** A page that brought its answers with it has no service to ask. */
function showWithin(answers) {
  document.documentElement.dataset.standsAlone = "";
  quantities.names = answers.chosen;
  show(answersWithin(answers));
  say("");
}

async function offerScenes() {
  const { scenes } = await api.get("v1/scenes");
  byId("scene").replaceChildren(...scenes.map(({ name, title }) => make("option", { value: name }, title)));
}

async function showVersion() {
  const { attitude } = await api.get("version");
  byId("version").textContent = attitude;
}

/** What the address names or carries; else what was edited at the last visit; else the first scene. */
async function open() {
  const hash = location.hash.slice(1);
  const carried = (await unpacked(hash)) ?? (hash ? null : keptDocument());
  const names = [...byId("scene").options].map((option) => option.value);
  if (carried === null) return choose([decodeURIComponent(hash), FIRST, names[0]].find((name) => names.includes(name)));
  byId("scene").value = "";
  state.shipped = carried;
  editor.text = carried;
  return run();
}

async function choose(name) {
  byId("scene").value = name;
  history.replaceState(null, "", `#${name}`);
  state.shipped = tidy(await api.text(`v1/scenes/${name}`));
  state.whole = null;
  editor.text = state.shipped;
  keepDocument(null);
  await run();
}

/** Somebody has typed: the address and the browser keep the document as it stands. */
function edited() {
  state.whole = null;
  clearTimeout(state.keeping);
  state.keeping = setTimeout(keep, 400);
}

async function keep() {
  const { text } = editor;
  keepDocument(text);
  history.replaceState(null, "", `#${await packed(text)}`);
}

async function copyLink() {
  const address = new URL(`#${await packed(editor.text)}`, location.href);
  history.replaceState(null, "", address);
  try {
    await navigator.clipboard.writeText(address.href);
    say("The link is in the clipboard; it carries the document.");
  } catch {
    say("The link is in the address bar; it carries the document.");
  }
}

// -- running --------------------------------------------------------------------------------------

async function run() {
  state.running?.abort();
  const running = new AbortController();
  state.running = running;
  editor.forgive();
  say("Computing");
  try {
    const { text } = editor;
    show(await answersTo(text, quantities.columns(isUncertain(text)), running.signal));
    say("");
  } catch (error) {
    if (error.name !== "AbortError") fail(error);
  }
}

const isUncertain = (text) => /"uncertainty"\s*:/.test(text ?? "");

/** Attitudes of a file in any format that the library reads, or a model of the body. */
async function openFile(file) {
  if (/\.gl(b|tf)$/i.test(file.name)) return openModel(file);
  say("Computing");
  try {
    show(await answersAbout(file));
    say("");
  } catch (error) {
    fail(error);
  }
}

async function openModel(file) {
  try {
    state.model = await modelSolid(file);
    controls.wanted.solid = "model";
    showPicture();
    say("");
  } catch (error) {
    say(`Refused: ${file.name}: ${error.message}`, "bad");
  }
}

function fail(error) {
  const known = error instanceof api.Refusal;
  if (!known) console.error(error);
  say(known ? `Refused: ${error.message}` : "The page could not show this answer.", "bad");
  if (known && error.status === 401) byId("token-form").hidden = false;
  else if (known && (error.pointer !== undefined || error.line)) editor.refuse(error);
}

function say(text, kind = "") {
  byId("status").textContent = text;
  byId("status").className = kind;
  byId("stage").setAttribute("aria-busy", String(text === "Computing"));
}

function show(shown) {
  const { course, document, plan, motion } = shown;
  state.shown = shown;
  byId("stage-title").textContent = course.name || "Scene";
  byId("description").textContent = document.description ?? "";
  byId("polhode-figure").hidden = !course.bodyKnown;
  const turns = (effect) => effect.simulated && effect.acts_on !== "translation";
  readouts.show(course, motion, Boolean(plan?.effects.some(turns)));
  if (plan) showPlan(byId("plan"), plan);
  else byId("plan").replaceChildren(make("p", {}, "A file of attitudes: nothing is simulated."));
  for (const part of [views.body, views.polhode, plots]) if (part) part.time = course.start;
  showPicture();
  if (course.bodyKnown) views.polhode?.show(course);
  showPlots();
  caption();
  betweenSamples(course);
  forgetCost();
  player.show(course);
  if (!byId("answers")) windows.show(shown);
}

function showPlots() {
  plots.show(state.shown, quantities.chosen(isUncertain(state.shown.text)), state.reference);
}

/** The columns that were chosen, of the scene that is shown and of the reference. */
async function showChosen() {
  const { shown, reference } = state;
  if (!shown) return;
  if (byId("answers")) return void showPlots();
  for (const each of [shown, reference].filter((one) => one?.text)) {
    const uncertain = isUncertain(each.text);
    each.columns = { ...each.columns, ...(await columnsOf(each.text, quantities.columns(uncertain))) };
  }
  if (shown === state.shown) showPlots();
}

// -- the picture of the body ----------------------------------------------------------------------

function showPicture() {
  const { shown } = state;
  const solids = { ...solidsOf(shown.document, shown.course.inertia), ...(state.model && { model: state.model }) };
  state.solids = solids;
  Object.assign(views.body ?? {}, controls.show(shown, solids));
  views.body?.show(shown, drawnSolid(), state.reference);
  caption();
}

/** The chosen one; along a path it has to have a length. */
function drawnSolid() {
  const { solid, scenery } = controls.choices;
  const chosen = state.solids[solid];
  return scenery === "path" && !chosen.metres ? Object.values(state.solids)[0] : chosen;
}

function redraw(change) {
  if (!views.body || !state.shown) return;
  Object.assign(views.body, change, { solid: drawnSolid() });
  views.body.build();
  caption();
}

function caption() {
  const { body, polhode } = views;
  const { course } = state.shown;
  const shape = course.bodyKnown || controls.choices.solid === "model" ? body?.solid?.words : "a cube, for want of a body";
  const beside = state.reference ? `; outlined: ${state.reference.course.name || "the reference"}` : "";
  if (body?.solid) byId("body-caption").textContent = `Attitude in ${course.frame}: ${shape}${beside}`;
  if (!polhode?.scale) byId("polhode-note").textContent = polhode ? "at rest: no ellipsoid" : "";
  else byId("polhode-note").textContent = polhode.divided ? "dashed: separatrices" : "";
}

// -- two scenes laid over each other ----------------------------------------------------------------

/** The scene that is shown stays as the reference of those to come; once more, and it goes. */
function keepReference() {
  const { shown, reference } = state;
  state.reference = reference ? null : { ...shown, solid: drawnSolid() };
  byId("reference").textContent = reference ? "Keep as reference" : "Forget reference";
  byId("reference-note").textContent = reference ? "" : `Dashed: ${shown.course.name || "this scene"} as it is now, by seconds since its own epoch.`;
  showPicture();
  showPlots();
}

function shadeWindows(found) {
  plots.shade(found);
  player.mark(found);
}

// -- between samples ------------------------------------------------------------------------------

/** Says what is drawn between samples, and offers closer ones where that is nothing. */
function betweenSamples(course) {
  const apart = !course.connected;
  const turns = figure(course.turn / (2 * Math.PI), 3);
  const said = `Up to ${turns} turns from one sample to the next: the picture goes from sample to sample, nothing is drawn between.`;
  byId("between").textContent = apart ? said : "";
  byId("closer").hidden = !apart;
  byId("wider").hidden = state.whole === null;
}

/** The same scene with samples so close, from the time shown, that the motion can be seen. */
function lookCloser() {
  const { course } = state.shown;
  const from = player.time;
  const rate = Math.max(...course.omegaAt(course.index(from)).map(Math.abs), course.rate[course.index(from)]);
  const stop = from + (CLOSER_TURN * CLOSER_SAMPLES) / rate;
  const times = { start: from, stop: Number(stop.toPrecision(12)), count: CLOSER_SAMPLES + 1, unit: "s" };
  const whole = editor.text;
  editor.text = withMember(whole, "times", JSON.stringify(times));
  state.whole = whole;
  say(`${duration(stop - from, 3)} from here`);
  return run();
}

function lookWider() {
  editor.text = state.whole;
  state.whole = null;
  return run();
}

// -- listening ------------------------------------------------------------------------------------

function listen() {
  byId("scene").addEventListener("change", ({ target }) => choose(target.value).catch(fail));
  byId("run").addEventListener("click", run);
  byId("restore").addEventListener("click", () => {
    editor.text = state.shipped;
    run();
  });
  byId("open").addEventListener("click", () => byId("file").click());
  byId("file").addEventListener("change", ({ target }) => {
    if (target.files[0]) openFile(target.files[0]);
    target.value = ""; // the same file can be opened again
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) openFile(event.dataTransfer.files[0]);
  });
  byId("copy-link").addEventListener("click", copyLink);
  addEventListener("hashchange", () => open().catch(fail));
  byId("closer").addEventListener("click", lookCloser);
  byId("wider").addEventListener("click", lookWider);
  byId("reference").addEventListener("click", () => state.shown && keepReference());
  byId("body-reset").addEventListener("click", () => views.body?.stage.reset());
  byId("polhode-reset").addEventListener("click", () => views.polhode?.stage.reset());
  byId("keys-open").addEventListener("click", () => byId("keys").showModal());
  byId("token-form").addEventListener("submit", takeToken);
  byId("document-details").open = matchMedia("(min-width: 60rem)").matches;
  document.addEventListener("keydown", shortcut);
}

function repaint() {
  for (const part of [views.body, views.polhode, plots]) part?.build();
}

function takeToken(event) {
  event.preventDefault();
  api.useToken(byId("token").value);
  byId("token-form").hidden = true;
  return editor.text ? run() : begin();
}

const TYPING = "json-editor, select, input, dialog[open]";
const PRESSED = "button, summary, a";

/** Keys of the whole page; where somebody types, or presses what has the focus, they stay what they are. */
function shortcut(event) {
  if (event.target.closest(TYPING)) return;
  if (event.key === "?") byId("keys").showModal();
  else if (event.key !== " " || !event.target.closest(PRESSED)) player.key(event);
}

start();
