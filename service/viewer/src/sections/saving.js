// Files that the page itself makes, and those it was given.

import { make } from "../dom.js";

let kept = null; // the address of the last file

/** A link to a file. It stays valid until the next: a browser may take it long after the click. */
export function linkTo(blob, name) {
  if (kept) URL.revokeObjectURL(kept);
  kept = URL.createObjectURL(blob);
  return make("a", { href: kept, download: name }, name);
}

/** "Angle of body z to Sun" becomes "angle-of-body-z-to-sun". */
export const fileName = (title) => title.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");
