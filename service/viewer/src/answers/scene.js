// All that the service answers about one document, or about one file: what every part of the page shows.

import * as api from "./api.js";
import { columnsOf, picked } from "./columns.js";
import { Course } from "./course.js";
import { columnsAbout, Surroundings } from "./surroundings.js";

const HOLDING_MOMENTUM = ["wheels", "dissipation"]; // effects with momentum that is not inertia times rate
const MOST_SAMPLES = 200_000; // that a page can hold and draw

/** {text, document, plan, course, motion, columns, about} of a document; `chosen` columns besides. */
export async function answersTo(text, chosen, signal) {
  const plan = await api.post("v1/plan", text, signal);
  checkSize(plan);
  const written = JSON.parse(text);
  const [{ answer, columns }, motion, document] = await Promise.all([
    ephemerisWith(text, partsOf(plan, written), [...columnsAbout(plan), ...chosen], signal),
    api.post("v1/motion", text, signal).catch(inWords),
    whole(written),
  ]);
  const course = new Course(answer, isFollowed(plan));
  return { text, document, plan, course, motion, columns, about: new Surroundings(course, columns, plan) };
}

/** The ephemeris and columns besides, simulated once; only where a column is refused, that one is asked for alone. */
async function ephemerisWith(text, parts, names, signal) {
  const ask = (columns) => api.post(`v1/ephemeris?columns=${encodeURIComponent(columns.join(","))}`, text, signal);
  const further = [...new Set(names)].filter((name) => !parts.includes(name));
  try {
    const answer = await ask([...parts, ...further]);
    return { answer, columns: picked(answer.columns, names) };
  } catch (error) {
    if (!(error instanceof api.Refusal) || !further.length) throw error;
    const [answer, columns] = await Promise.all([ask(parts), columnsOf(text, names, signal)]);
    return { answer, columns };
  }
}

/** What the page needs of every ephemeris. */
function partsOf(plan, document) {
  const holdsMomentum = plan.effects.some(({ simulated, type }) => simulated && HOLDING_MOMENTUM.includes(type));
  return [
    ...["time", "elapsed", "quaternion", "angular_velocity"],
    ...(holdsMomentum ? ["angular_momentum"] : []),
    ...(isFollowed(plan) ? ["position", "velocity"] : []),
    ...(document.uncertainty ? ["attitude_covariance", "angular_velocity_covariance"] : []),
  ];
}

const isFollowed = (plan) => plan.effects.some((effect) => effect.simulated && effect.acts_on === "translation");

/** The same of answers that the page brought with it. */
export function answersWithin({ document, plan, motion, answer, columns, names }) {
  const course = new Course(answer);
  const found = picked(columns, names);
  return { text: JSON.stringify(document), document, plan, course, motion, columns: found, about: new Surroundings(course, found, plan) };
}

/** The same of a file in any format that the library reads: attitudes as they stand in it. */
export async function answersAbout(file) {
  const answer = await api.given("v1/convert?format=json", file);
  answer.name ||= file.name;
  const course = new Course(answer);
  const about = new Surroundings(course, {}, null);
  return { text: null, document: {}, plan: null, course, motion: `from ${file.name}`, columns: {}, about };
}

/** A document that builds on a shipped scene, with the members of that one. */
async function whole(document) {
  if (typeof document.scene !== "string") return document;
  return { ...(await api.get(`v1/scenes/${encodeURIComponent(document.scene)}`)), ...document };
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
