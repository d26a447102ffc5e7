// Columns of the ephemeris by name, as the service computes them: {name: {labels, data}}, in time order.

import * as api from "./api.js";
import { words } from "../numbers.js";

/** Of a document; a column that it cannot have is {refused: words}. */
export async function columnsOf(text, names, signal) {
  const wanted = [...new Set(names)];
  if (!wanted.length) return {};
  try {
    return await asked(text, wanted, signal);
  } catch (error) {
    if (!(error instanceof api.Refusal)) throw error;
    if (wanted.length === 1) return { [wanted[0]]: { refused: error.message } };
    const alone = await Promise.all(wanted.map((name) => columnsOf(text, [name], signal)));
    return Object.assign({}, ...alone);
  }
}

async function asked(text, names, signal) {
  const path = `v1/ephemeris?columns=${encodeURIComponent(["elapsed", ...names].join(","))}`;
  return picked((await api.post(path, text, signal)).columns, names);
}

/** Columns of an answer by the names that they were asked for by. */
export function picked(columns, names) {
  const order = inOrder(columns.elapsed_s);
  const entries = names.map((name) => {
    const stem = name.toLowerCase().replaceAll(":-", ":minus_").replaceAll(":", "_");
    const starts = stem.startsWith("radec_") ? ["ra_", "dec_"].map((start) => stem.replace("radec_", start)) : [stem];
    const labels = Object.keys(columns).filter((label) => starts.some((start) => label.startsWith(`${start}_`)));
    return [name, { labels: labels.map(words), data: labels.map((label) => order.map((i) => columns[label][i])) }];
  });
  return Object.fromEntries(entries);
}

/** Places of the samples in the order of time. */
export function inOrder(elapsed) {
  const order = Array.from(elapsed.keys());
  return order.sort((i, j) => elapsed[i] - elapsed[j]);
}
