// Everything that the page shows of one document or one file, requested from the service.

import * as api from "./api.js";
import { columnsOf, columnsByName } from "./columns.js";
import { Ephemeris } from "./ephemeris.js";
import { surroundingColumns, Surroundings } from "./surroundings.js";

const MOMENTUM_EFFECTS = ["wheels", "dissipation"]; // effects with momentum that is not inertia times rate
const MAX_SAMPLES = 200_000; // that a page can hold and draw

/** {text, document, plan, ephemeris, motion, columns, surroundings} of a document; `chosen`: further columns. */
export async function answersForDocument(text, chosen, signal) {
  const plan = await api.post("v1/plan", text, signal);
  checkSize(plan);
  const written = JSON.parse(text);
  const [{ answer, columns }, motion, document] = await Promise.all([
    ephemerisWith(text, requiredColumns(plan, written), [...surroundingColumns(plan), ...chosen], signal),
    api.post("v1/motion", text, signal).catch(refusalText),
    withSceneMembers(written),
  ]);
  const ephemeris = new Ephemeris(answer, isTranslated(plan));
  return { text, document, plan, ephemeris, motion, columns, surroundings: new Surroundings(ephemeris, columns, plan) };
}

/** The ephemeris and further columns in one request; if a column is refused, the columns in requests of their own. */
async function ephemerisWith(text, required, names, signal) {
  const ask = (columns) => api.post(`v1/ephemeris?columns=${encodeURIComponent(columns.join(","))}`, text, signal);
  const further = [...new Set(names)].filter((name) => !required.includes(name));
  try {
    const answer = await ask([...required, ...further]);
    return { answer, columns: columnsByName(answer.columns, names) };
  } catch (error) {
    if (!(error instanceof api.Refusal) || !further.length) throw error;
    const [answer, columns] = await Promise.all([ask(required), columnsOf(text, names, signal)]);
    return { answer, columns };
  }
}

/** The columns that the page needs of every ephemeris. */
function requiredColumns(plan, document) {
  const holdsMomentum = plan.effects.some(({ simulated, type }) => simulated && MOMENTUM_EFFECTS.includes(type));
  return [
    ...["time", "elapsed", "quaternion", "angular_velocity"],
    ...(holdsMomentum ? ["angular_momentum"] : []),
    ...(isTranslated(plan) ? ["position", "velocity"] : []),
    ...(document.uncertainty ? ["attitude_covariance", "angular_velocity_covariance"] : []),
  ];
}

const isTranslated = (plan) => plan.effects.some((effect) => effect.simulated && effect.acts_on === "translation");

/** The same from answers that are embedded in the page. */
export function answersInPage({ document, plan, motion, answer, columns, names }) {
  const ephemeris = new Ephemeris(answer);
  const named = columnsByName(columns, names);
  return { text: JSON.stringify(document), document, plan, ephemeris, motion, columns: named, surroundings: new Surroundings(ephemeris, named, plan) };
}

/** The same of a file in any format that the library reads, with its attitudes unchanged. */
export async function answersForFile(file) {
  const answer = await api.postFile("v1/convert?format=json", file);
  answer.name ||= file.name;
  const ephemeris = new Ephemeris(answer);
  const surroundings = new Surroundings(ephemeris, {}, null);
  return { text: null, document: {}, plan: null, ephemeris, motion: `from ${file.name}`, columns: {}, surroundings };
}

/** The document, completed by the members of the built-in scene that it names. */
async function withSceneMembers(document) {
  if (typeof document.scene !== "string") return document;
  return { ...(await api.get(`v1/scenes/${encodeURIComponent(document.scene)}`)), ...document };
}

function checkSize({ samples }) {
  if (samples <= MAX_SAMPLES) return;
  const more = `${samples.toLocaleString("en")} samples: this page draws up to ${MAX_SAMPLES.toLocaleString("en")}; a file can hold them all`;
  throw new api.Refusal(0, { detail: more, pointer: "/times" });
}

/** A refusal as text: the page shows the rest without the constants of the motion. */
function refusalText(error) {
  if (error instanceof api.Refusal) return error.message;
  throw error;
}
