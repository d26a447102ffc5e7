// A button for each format, which downloads the ephemeris of the current document.

import * as api from "../answers/api.js";
import { byId, make } from "../dom.js";
import { linkTo } from "./saving.js";

export async function offerDownloads(element, documentText) {
  const { formats } = await api.get("viewer/formats.json");
  element.replaceChildren(...formats.map((format) => make("li", {}, formatButton(format, documentText))));
}

function formatButton(format, documentText) {
  const element = make("button", { type: "button", title: format.media }, make("b", {}, format.name), ` ${format.endings.join(" ")}`);
  element.addEventListener("click", () => download(element, format, documentText()));
  return element;
}

async function download(button, format, text) {
  const status = byId("download-status");
  status.className = "";
  status.textContent = `${format.name}: requesting`;
  button.setAttribute("aria-busy", "true");
  try {
    const path = `v1/ephemeris?format=${encodeURIComponent(format.name)}`;
    const { blob, name } = await api.download(path, text, `ephemeris${format.endings[0]}`);
    const link = linkTo(blob, name);
    link.dataset.format = format.name;
    status.replaceChildren(link, `, ${blob.size.toLocaleString("en")} bytes`);
    link.click();
  } catch (error) {
    status.className = "bad";
    status.textContent = `${format.name}: ${error.message}`;
  } finally {
    button.removeAttribute("aria-busy");
  }
}
