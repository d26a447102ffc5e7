// Columns of the ephemeris, computed by the service: {name: {labels, data}}, sorted by time.

import * as api from "./api.js";
import { words } from "../numbers.js";

/** Requests the columns of a document; one that the service refuses is {refused: text}. */
export async function columnsOf(text, names, signal) {
  const unique = [...new Set(names)];
  if (!unique.length) return {};
  try {
    return await requestColumns(text, unique, signal);
  } catch (error) {
    if (!(error instanceof api.Refusal)) throw error;
    if (unique.length === 1) return { [unique[0]]: { refused: error.message } };
    const separate = await Promise.all(unique.map((name) => columnsOf(text, [name], signal)));
    return Object.assign({}, ...separate);
  }
}

async function requestColumns(text, names, signal) {
  const path = `v1/ephemeris?columns=${encodeURIComponent(["elapsed", ...names].join(","))}`;
  return columnsByName((await api.post(path, text, signal)).columns, names);
}

/** The columns of an answer, grouped by the names that they were requested by. */
export function columnsByName(columns, names) {
  const order = timeOrder(columns.elapsed_s);
  const entries = names.map((name) => {
    const stem = name.toLowerCase().replaceAll(":-", ":minus_").replaceAll(":", "_");
    const starts = stem.startsWith("radec_") ? ["ra_", "dec_"].map((start) => stem.replace("radec_", start)) : [stem];
    const labels = Object.keys(columns).filter((label) => starts.some((start) => label.startsWith(`${start}_`)));
    return [name, { labels: labels.map(words), data: labels.map((label) => order.map((i) => columns[label][i])) }];
  });
  return Object.fromEntries(entries);
}

/** Indices of the samples in ascending time. */
export function timeOrder(elapsed) {
  const order = Array.from(elapsed.keys());
  return order.sort((i, j) => elapsed[i] - elapsed[j]);
}
