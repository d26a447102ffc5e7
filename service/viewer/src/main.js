// Wiring: the document is asked about, and what comes back goes to every part of the page.

import * as api from "./api.js";
import { BodyView } from "./body_view.js";
import { forgetCost, offerCost } from "./cost.js";
import { Course } from "./course.js";
import { byId, make } from "./dom.js";
import { offerDownloads } from "./downloads.js";
import { Editor } from "./editor.js";
import { tidy, withMember } from "./json_text.js";
import { keepDocument, keptDocument, packed, unpacked } from "./link.js";
import { duration, figure } from "./numbers.js";
import { showPlan } from "./plan.js";
import { Player } from "./player.js";
import { Plots } from "./plots.js";
import { Quantities } from "./quantities.js";
import { PolhodeView } from "./polhode_view.js";
import { Readouts } from "./readouts.js";
import { installTheme } from "./theme.js";

const FIRST = "dzhanibekov";
const MOST_SAMPLES = 200_000; // that a page can hold and draw
const CLOSER_TURN = 0.15; // rad from sample to sample, looked at closely
const CLOSER_SAMPLES = 1500;

const state = { shipped: "", course: null, running: null, whole: null };
const views = { body: viewIn("body-view", BodyView), polhode: viewIn("polhode-view", PolhodeView) };
const plots = new Plots(byId("plots"), (time) => player.seek(time));
const quantities = new Quantities(() => showChosen().catch(fail));
const readouts = new Readouts(byId("readouts"));
const player = new Player(showTime);
const editor = new Editor({ onRun: run, onChange: edited, schema: () => api.get("openapi.json") });

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
  for (const part of [views.body, state.course.bodyKnown ? views.polhode : null, plots]) part?.at(time);
  readouts.at(time);
}

// -- scenes ---------------------------------------------------------------------------------------

function start() {
  installTheme(repaint);
  listen();
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
    const text = editor.text;
    const plan = await api.post("v1/plan", text, running.signal);
    checkSize(plan);
    const [answer, motion, chosen] = await Promise.all([
      api.post("v1/ephemeris", text, running.signal),
      api.post("v1/motion", text, running.signal).catch(inWords),
      quantities.curves(text, running.signal),
    ]);
    show(JSON.parse(text), answer, motion, plan, chosen);
    say("");
  } catch (error) {
    if (error.name !== "AbortError") fail(error);
  }
}

/** Attitudes of a file in any format that the library reads, as they stand in it. */
async function openFile(file) {
  say("Computing");
  try {
    const answer = await api.given("v1/convert?format=json", file);
    answer.name ||= file.name;
    show({}, answer, `from ${file.name}`, null, []);
    state.text = null;
    say("");
  } catch (error) {
    fail(error);
  }
}

function checkSize({ samples }) {
  if (samples <= MOST_SAMPLES) return;
  const more = `${samples.toLocaleString("en")} samples: this page draws up to ${MOST_SAMPLES.toLocaleString("en")}; a file can hold them all`;
  throw new api.Refusal(0, { detail: more, pointer: "/times" });
}

/** A motion without constants is no reason to show nothing. */
function inWords(error) {
  if (error instanceof api.Refusal) return error.message;
  throw error;
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

function show(document, answer, motion, plan, chosen) {
  const course = new Course(answer);
  Object.assign(state, { course, document, text: editor.text });
  byId("stage-title").textContent = course.name || "Scene";
  byId("description").textContent = document.description ?? "";
  byId("polhode-figure").hidden = !course.bodyKnown;
  const turns = (effect) => effect.simulated && effect.acts_on !== "translation";
  readouts.show(course, motion, Boolean(plan?.effects.some(turns)));
  if (plan) showPlan(byId("plan"), plan);
  else byId("plan").replaceChildren(make("p", {}, "A file of attitudes: nothing is simulated."));
  offerTravel(course, document);
  for (const part of [views.body, views.polhode, plots]) if (part) part.time = course.start;
  views.body?.show(course, document);
  if (course.bodyKnown) views.polhode?.show(course);
  plots.show(course, chosen);
  caption();
  betweenSamples(course);
  forgetCost();
  player.show(course);
}

/** The plots that were chosen, of the scene that is shown. */
async function showChosen() {
  if (!state.course || state.text === null) return;
  const { course, text } = state;
  const chosen = await quantities.curves(text);
  if (course === state.course) plots.show(course, chosen);
}

function offerTravel(course, document) {
  const can = Boolean(views.body) && BodyView.canTravel(course, document);
  byId("travel-label").hidden = !can;
  byId("travel").checked &&= can;
  if (views.body) views.body.travels = byId("travel").checked;
}

function caption() {
  const { body, polhode } = views;
  const shape = state.course.bodyKnown ? body?.solid?.words : "a cube, for want of a body";
  if (body?.solid) byId("body-caption").textContent = `Attitude in ${state.course.frame}: ${shape}`;
  if (!polhode?.scale) byId("polhode-note").textContent = polhode ? "at rest: no ellipsoid" : "";
  else byId("polhode-note").textContent = polhode.divided ? "dashed: separatrices" : "";
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
  const { course } = state;
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
  byId("scene").addEventListener("change", (event) => choose(event.target.value).catch(fail));
  byId("run").addEventListener("click", run);
  byId("restore").addEventListener("click", () => {
    editor.text = state.shipped;
    run();
  });
  byId("open").addEventListener("click", () => byId("file").click());
  byId("file").addEventListener("change", ({ target }) => target.files[0] && openFile(target.files[0]));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) openFile(event.dataTransfer.files[0]);
  });
  byId("copy-link").addEventListener("click", copyLink);
  addEventListener("hashchange", () => open().catch(fail));
  byId("closer").addEventListener("click", lookCloser);
  byId("wider").addEventListener("click", lookWider);
  byId("axis").value = "2";
  byId("axis").addEventListener("change", (event) => rebuild({ axis: Number(event.target.value) }));
  byId("travel").addEventListener("change", (event) => rebuild({ travels: event.target.checked }));
  byId("body-reset").addEventListener("click", () => views.body?.stage.reset());
  byId("polhode-reset").addEventListener("click", () => views.polhode?.stage.reset());
  byId("keys-open").addEventListener("click", () => byId("keys").showModal());
  byId("token-form").addEventListener("submit", takeToken);
  byId("document-details").open = matchMedia("(min-width: 60rem)").matches;
  document.addEventListener("keydown", shortcut);
}

function rebuild(changes) {
  if (!views.body) return;
  Object.assign(views.body, changes);
  views.body.build();
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
