// Entry point: requests the answers about the document and passes them to every part of the page.

import * as api from "./answers/api.js";
import { columnsOf } from "./answers/columns.js";
import { answersForFile, answersForDocument, answersInPage } from "./answers/scene.js";
import { Editor } from "./document/editor.js";
import { Form } from "./document/form.js";
import { tidy, withMember } from "./document/json_text.js";
import { storeDocument, storedDocument, encodeDocument, decodeDocument } from "./document/link.js";
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

const DEFAULT_SCENE = "dzhanibekov";
const CLOSE_TURN = 0.15; // rad between samples of the closer view
const CLOSE_SAMPLES = 1500;

// `shown`: answers of answers/scene.js; `reference`: earlier ones; `whole`: the document before a closer view.
const state = { original: "", shown: null, reference: null, running: null, whole: null, model: null };
const views = { body: viewIn("body-view", BodyView), polhode: viewIn("polhode-view", PolhodeView) };
const player = new Player(showTime);
const plots = new Plots(byId("plots"), (time) => player.seek(time), (column) => quantities.remove(column));
const quantities = new Quantities(() => showChosen().catch(showError));
const windows = new WindowsSection(shadeWindows, (time) => player.seek(time));
const readouts = new Readouts(byId("readouts"));
const controls = new PictureControls((change) => redraw(change));
const editor = new Editor({ onRun: run, onChange: edited, onText: () => form.show(editor.text), schema: () => api.get("openapi.json") });
const form = new Form((pointers, value) => editor.put(pointers, value), run);

/** A 3D view; a message and null where the browser has no WebGL. */
function viewIn(id, View) {
  try {
    if (document.createElement("canvas").getContext("webgl2")) return new View(byId(id));
  } catch {
    // WebGL is announced, but no context can be created
  }
  const message = "This browser offers no WebGL, which the 3D views need. Plots, figures and files are available.";
  byId(id).replaceChildren(make("p", { class: "no-3d" }, message));
  return null;
}

function showTime(time) {
  for (const part of [views.body, state.shown.ephemeris.bodyKnown ? views.polhode : null, plots]) part?.at(time);
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

/** Loads what comes from the service; called again once the user has entered a token. */
async function begin() {
  try {
    await Promise.all([offerScenes(), offerDownloads(byId("downloads"), () => editor.text), showVersion()]);
    await open();
  } catch (error) {
    showError(error);
  }
}

/** Shows the answers embedded in a page that has no service. */
function showWithin(answers) {
  document.documentElement.dataset.standsAlone = "";
  quantities.names = answers.chosen;
  show(answersInPage(answers));
  setStatus("");
}

async function offerScenes() {
  const { scenes } = await api.get("v1/scenes");
  byId("scene").replaceChildren(...scenes.map(({ name, title }) => make("option", { value: name }, title)));
}

async function showVersion() {
  const { attitude } = await api.get("version");
  byId("version").textContent = attitude;
}

/** Opens the scene or document of the URL, else the document edited last, else the default scene. */
async function open() {
  const hash = location.hash.slice(1);
  const linked = (await decodeDocument(hash)) ?? (hash ? null : storedDocument());
  const names = [...byId("scene").options].map((option) => option.value);
  if (linked === null) return choose([decodeURIComponent(hash), DEFAULT_SCENE, names[0]].find((name) => names.includes(name)));
  byId("scene").value = "";
  state.original = linked;
  editor.text = linked;
  return run();
}

async function choose(name) {
  byId("scene").value = name;
  history.replaceState(null, "", `#${name}`);
  state.original = tidy(await api.text(`v1/scenes/${name}`));
  state.whole = null;
  editor.text = state.original;
  storeDocument(null);
  await run();
}

/** Stores the edited document in the URL and in the browser. */
function edited() {
  state.whole = null;
  clearTimeout(state.storing);
  state.storing = setTimeout(store, 400);
}

async function store() {
  const { text } = editor;
  storeDocument(text);
  history.replaceState(null, "", `#${await encodeDocument(text)}`);
}

async function copyLink() {
  const address = new URL(`#${await encodeDocument(editor.text)}`, location.href);
  history.replaceState(null, "", address);
  try {
    await navigator.clipboard.writeText(address.href);
    setStatus("The link is in the clipboard; it contains the document.");
  } catch {
    setStatus("The link is in the address bar; it contains the document.");
  }
}

// -- running --------------------------------------------------------------------------------------

async function run() {
  state.running?.abort();
  const running = new AbortController();
  state.running = running;
  editor.clearError();
  setStatus("Computing");
  try {
    const { text } = editor;
    show(await answersForDocument(text, quantities.columns(isUncertain(text)), running.signal));
    setStatus("");
  } catch (error) {
    if (error.name !== "AbortError") showError(error);
  }
}

const isUncertain = (text) => /"uncertainty"\s*:/.test(text ?? "");

/** Opens a file of attitudes in any format that the library reads, or a model of the body. */
async function openFile(file) {
  if (/\.gl(b|tf)$/i.test(file.name)) return openModel(file);
  setStatus("Computing");
  try {
    show(await answersForFile(file));
    setStatus("");
  } catch (error) {
    showError(error);
  }
}

async function openModel(file) {
  try {
    state.model = await modelSolid(file);
    controls.wanted.solid = "model";
    showPicture();
    setStatus("");
  } catch (error) {
    setStatus(`Refused: ${file.name}: ${error.message}`, "bad");
  }
}

function showError(error) {
  const isRefusal = error instanceof api.Refusal;
  if (!isRefusal) console.error(error);
  setStatus(isRefusal ? `Refused: ${error.message}` : "The page could not show this answer.", "bad");
  if (isRefusal && error.status === 401) byId("token-form").hidden = false;
  else if (isRefusal && (error.pointer !== undefined || error.line)) editor.showError(error);
}

function setStatus(text, kind = "") {
  byId("status").textContent = text;
  byId("status").className = kind;
  byId("stage").setAttribute("aria-busy", String(text === "Computing"));
}

function show(shown) {
  const { ephemeris, document, plan, motion } = shown;
  state.shown = shown;
  byId("stage-title").textContent = ephemeris.name || "Scene";
  byId("description").textContent = document.description ?? "";
  byId("polhode-figure").hidden = !ephemeris.bodyKnown;
  const turnsBody = (effect) => effect.simulated && effect.acts_on !== "translation";
  readouts.show(ephemeris, motion, Boolean(plan?.effects.some(turnsBody)));
  if (plan) showPlan(byId("plan"), plan);
  else byId("plan").replaceChildren(make("p", {}, "A file of attitudes: nothing is simulated."));
  for (const part of [views.body, views.polhode, plots]) if (part) part.time = ephemeris.start;
  showPicture();
  if (ephemeris.bodyKnown) views.polhode?.show(ephemeris);
  showPlots();
  caption();
  betweenSamples(ephemeris);
  forgetCost();
  player.show(ephemeris);
  if (!byId("answers")) windows.show(shown);
}

function showPlots() {
  plots.show(state.shown, quantities.chosen(isUncertain(state.shown.text)), state.reference);
}

/** Requests the chosen columns of the scene and of the reference, and plots them. */
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
  const solids = { ...solidsOf(shown.document, shown.ephemeris.inertia), ...(state.model && { model: state.model }) };
  state.solids = solids;
  Object.assign(views.body ?? {}, controls.show(shown, solids));
  views.body?.show(shown, drawnSolid(), state.reference);
  caption();
}

/** The chosen solid; on a path the first one where the chosen one has no unit of length. */
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
  const { ephemeris } = state.shown;
  const shape = ephemeris.bodyKnown || controls.choices.solid === "model" ? body?.solid?.description : "a cube, because the file states no body";
  const beside = state.reference ? `; outlined: ${state.reference.ephemeris.name || "the reference"}` : "";
  if (body?.solid) byId("body-caption").textContent = `Attitude in ${ephemeris.frame}: ${shape}${beside}`;
  if (!polhode?.scale) byId("polhode-note").textContent = polhode ? "at rest: no ellipsoid" : "";
  else byId("polhode-note").textContent = polhode.divided ? "dashed: separatrices" : "";
}

// -- comparison with a reference scene ----------------------------------------------------------------

/** Keeps the current scene as the reference for later ones, or forgets the reference. */
function keepReference() {
  const { shown, reference } = state;
  state.reference = reference ? null : { ...shown, solid: drawnSolid() };
  byId("reference").textContent = reference ? "Keep as reference" : "Forget reference";
  byId("reference-note").textContent = reference ? "" : `Dashed: ${shown.ephemeris.name || "this scene"} as it is now, by seconds since its own epoch.`;
  showPicture();
  showPlots();
}

function shadeWindows(found) {
  plots.shade(found);
  player.mark(found);
}

// -- between samples ------------------------------------------------------------------------------

/** Where samples are too far apart to interpolate, says so and offers a closer view. */
function betweenSamples(ephemeris) {
  const apart = !ephemeris.connected;
  const turns = figure(ephemeris.turn / (2 * Math.PI), 3);
  const message = `Up to ${turns} turns between neighbouring samples: each sample is shown as it is, nothing is interpolated.`;
  byId("between").textContent = apart ? message : "";
  byId("closer").hidden = !apart;
  byId("wider").hidden = state.whole === null;
}

/** Runs the scene with closely spaced samples from the current time on. */
function showCloser() {
  const { ephemeris } = state.shown;
  const from = player.time;
  const rate = Math.max(...ephemeris.omegaAt(ephemeris.index(from)).map(Math.abs), ephemeris.rate[ephemeris.index(from)]);
  const stop = from + (CLOSE_TURN * CLOSE_SAMPLES) / rate;
  const times = { start: from, stop: Number(stop.toPrecision(12)), count: CLOSE_SAMPLES + 1, unit: "s" };
  const whole = editor.text;
  editor.text = withMember(whole, "times", JSON.stringify(times));
  state.whole = whole;
  setStatus(`${duration(stop - from, 3)} from here`);
  return run();
}

function showWhole() {
  editor.text = state.whole;
  state.whole = null;
  return run();
}

// -- listening ------------------------------------------------------------------------------------

function listen() {
  byId("scene").addEventListener("change", ({ target }) => choose(target.value).catch(showError));
  byId("run").addEventListener("click", run);
  byId("restore").addEventListener("click", () => {
    editor.text = state.original;
    run();
  });
  byId("open").addEventListener("click", () => byId("file").click());
  byId("file").addEventListener("change", ({ target }) => {
    if (target.files[0]) openFile(target.files[0]);
    target.value = ""; // so that the same file can be opened again
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) openFile(event.dataTransfer.files[0]);
  });
  byId("copy-link").addEventListener("click", copyLink);
  addEventListener("hashchange", () => open().catch(showError));
  byId("closer").addEventListener("click", showCloser);
  byId("wider").addEventListener("click", showWhole);
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
const PRESSABLE = "button, summary, a";

/** Keys of the whole page, except in input fields and on focused buttons. */
function shortcut(event) {
  if (event.target.closest(TYPING)) return;
  if (event.key === "?") byId("keys").showModal();
  else if (event.key !== " " || !event.target.closest(PRESSABLE)) player.key(event);
}

start();
