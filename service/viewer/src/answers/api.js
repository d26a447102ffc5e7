// Requests to the service; a response that is not a success is thrown as a Refusal with the service's own text.

let token = "";

export function useToken(value) {
  token = value;
}

export class Refusal extends Error {
  constructor(status, problem) {
    super(problem.detail);
    this.status = status;
    this.pointer = problem.pointer;
    this.line = problem.line;
  }
}

/** The response; throws Refusal unless its status is one of success. */
async function request(path, options = {}) {
  const headers = { ...options.headers, ...(token && { authorization: `Bearer ${token}` }) };
  let response;
  try {
    response = await fetch(path, { ...options, headers });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refusal(0, { detail: "the service does not answer" });
  }
  if (!response.ok) throw new Refusal(response.status, await problemOf(response));
  return response;
}

async function problemOf(response) {
  try {
    const problem = await response.json();
    if (typeof problem.detail === "string") return problem;
  } catch {
    // not a problem document, but perhaps the page of a proxy
  }
  return { detail: `the service answers ${response.status} ${response.statusText}`.trim() };
}

export async function get(path) {
  return (await request(path)).json();
}

/** The body as text, with every digit as the service wrote it. */
export async function text(path) {
  return (await request(path)).text();
}

const jsonRequest = (text, signal, accept) => ({
  method: "POST",
  body: text,
  signal,
  headers: { "content-type": "application/json", ...(accept && { accept }) },
});

export async function post(path, text, signal) {
  return (await request(path, jsonRequest(text, signal, "application/json"))).json();
}

/** The JSON answer to a file that is posted. */
export async function postFile(path, file) {
  const body = new FormData();
  body.append("file", file);
  return (await request(path, { method: "POST", body, headers: { accept: "application/json" } })).json();
}

/** {blob, name} of a response that is a file, with the name that the service gives it. */
export async function download(path, text, defaultName) {
  const response = await request(path, jsonRequest(text));
  const disposition = response.headers.get("content-disposition") ?? "";
  return { blob: await response.blob(), name: /filename="([^"]+)"/.exec(disposition)?.[1] ?? defaultName };
}
