// The document in the address, compressed, and in the browser's own storage.

const PREFIX = "document=";
const KEY = "attitude-document";

/** What follows # in a link that carries a document: deflated, in base64 of the kind for addresses. */
export async function packed(text) {
  const bytes = await through(new Blob([text]), new CompressionStream("deflate-raw"));
  const characters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return PREFIX + btoa(characters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** The document that an address carries; null where it carries none, or what is none. */
export async function unpacked(hash) {
  if (!hash.startsWith(PREFIX)) return null;
  try {
    const characters = atob(hash.slice(PREFIX.length).replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(characters, (character) => character.charCodeAt(0));
    return new TextDecoder("utf-8", { fatal: true }).decode(await through(new Blob([bytes]), new DecompressionStream("deflate-raw")));
  } catch {
    return null;
  }
}

async function through(blob, stream) {
  return new Uint8Array(await new Response(blob.stream().pipeThrough(stream)).arrayBuffer());
}

// Storage may be refused to a page; nothing is kept then.

export function keepDocument(text) {
  try {
    if (text === null) localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, text);
  } catch {
    // for this visit, then
  }
}

export function keptDocument() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}
