// The document in the URL, compressed, and in the local storage of the browser.

const PREFIX = "document=";
const STORAGE_KEY = "attitude-document";

/** The fragment of a URL that holds the document: deflated, base64url. */
export async function encodeDocument(text) {
  const bytes = await pipe(new Blob([text]), new CompressionStream("deflate-raw"));
  const characters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return PREFIX + btoa(characters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** The document in the fragment of a URL; null where there is none or it cannot be decoded. */
export async function decodeDocument(hash) {
  if (!hash.startsWith(PREFIX)) return null;
  try {
    const characters = atob(hash.slice(PREFIX.length).replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(characters, (character) => character.charCodeAt(0));
    return new TextDecoder("utf-8", { fatal: true }).decode(await pipe(new Blob([bytes]), new DecompressionStream("deflate-raw")));
  } catch {
    return null;
  }
}

async function pipe(blob, stream) {
  return new Uint8Array(await new Response(blob.stream().pipeThrough(stream)).arrayBuffer());
}

// A browser may deny storage; the document is then not stored.

export function storeDocument(text) {
  try {
    if (text === null) localStorage.removeItem(STORAGE_KEY);
    else localStorage.setItem(STORAGE_KEY, text);
  } catch {
    // not stored
  }
}

export function storedDocument() {
  try {
    return localStorage.getItem(STORAGE_KEY);
  } catch {
    return null;
  }
}
