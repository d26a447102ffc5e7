// A button for each format: asks the service for the document as it stands, and keeps the file.

import * as api from "../answers/api.js";
import { byId, make } from "../dom.js";
import { linkTo } from "./saving.js";

export async function offerDownloads(element, documentText) {
  const { formats } = await api.get("viewer/formats.json");
  element.replaceChildren(...formats.map((format) => make("li", {}, button(format, documentText))));
}

function button(format, documentText) {
  const made = make("button", { type: "button", title: format.media }, make("b", {}, format.name), ` ${format.endings.join(" ")}`);
  made.addEventListener("click", () => download(made, format, documentText()));
  return made;
}

async function download(pressed, format, text) {
  const status = byId("download-status");
  status.className = "";
  status.textContent = `${format.name}: asking`;
  pressed.setAttribute("aria-busy", "true");
  try {
    const path = `v1/ephemeris?format=${encodeURIComponent(format.name)}`;
    const { blob, name } = await api.file(path, text, `ephemeris${format.endings[0]}`);
    const link = linkTo(blob, name);
    link.dataset.format = format.name;
    status.replaceChildren(link, `, ${blob.size.toLocaleString("en")} bytes`);
    link.click();
  } catch (error) {
    status.className = "bad";
    status.textContent = `${format.name}: ${error.message}`;
  } finally {
    pressed.removeAttribute("aria-busy");
  }
}
