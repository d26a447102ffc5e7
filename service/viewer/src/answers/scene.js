// All that the service answers about one document, or about one file: what every part of the page shows.

import * as api from "./api.js";
import { columnsOf, picked } from "./columns.js";
import { Course } from "./course.js";
import { columnsAbout, Surroundings } from "./surroundings.js";

const MOST_SAMPLES = 200_000; // that a page can hold and draw

/** {text, document, plan, course, motion, columns, about} of a document; `chosen` columns besides. */
export async function answersTo(text, chosen, signal) {
  const plan = await api.post("v1/plan", text, signal);
  checkSize(plan);
  const [answer, motion, columns, document] = await Promise.all([
    api.post("v1/ephemeris", text, signal),
    api.post("v1/motion", text, signal).catch(inWords),
    columnsOf(text, [...columnsAbout(plan), ...chosen], signal),
    whole(JSON.parse(text)),
  ]);
  const course = new Course(answer);
  return { text, document, plan, course, motion, columns, about: new Surroundings(course, columns, plan) };
}

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
