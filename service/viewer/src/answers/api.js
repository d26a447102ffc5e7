// The service's answers; a refusal is thrown in the service's own words.

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

/** The response; Refusal where it is not one of success. */
async function ask(path, options = {}) {
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
    // not a problem document: a proxy's page, say
  }
  return { detail: `the service answers ${response.status} ${response.statusText}`.trim() };
}

export async function get(path) {
  return (await ask(path)).json();
}

/** As it was sent: every number as it is written there. */
export async function text(path) {
  return (await ask(path)).text();
}

const posted = (text, signal, accept) => ({
  method: "POST",
  body: text,
  signal,
  headers: { "content-type": "application/json", ...(accept && { accept }) },
});

export async function post(path, text, signal) {
  return (await ask(path, posted(text, signal, "application/json"))).json();
}

/** The answer about a file of the user's. */
export async function given(path, file) {
  const body = new FormData();
  body.append("file", file);
  return (await ask(path, { method: "POST", body, headers: { accept: "application/json" } })).json();
}

/** {blob, name}: a file as the service names it. */
export async function file(path, text, otherwise) {
  const response = await ask(path, posted(text));
  const said = response.headers.get("content-disposition") ?? "";
  return { blob: await response.blob(), name: /filename="([^"]+)"/.exec(said)?.[1] ?? otherwise };
}
