// Links to files that the page made or the service answered.

import { make } from "../dom.js";

let lastAddress = null; // the address of the last file

/** A download link. It stays valid until the next is made: a browser may read it long after the click. */
export function linkTo(blob, name) {
  if (lastAddress) URL.revokeObjectURL(lastAddress);
  lastAddress = URL.createObjectURL(blob);
  return make("a", { href: lastAddress, download: name }, name);
}

/** "Angle of body z to Sun" becomes "angle-of-body-z-to-sun". */
export const fileName = (title) => title.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");
