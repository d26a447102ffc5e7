// Light, dark, or as the system has it.

import { byId } from "../dom.js";

const KEY = "attitude-theme";

export function installTheme(onChange) {
  const select = byId("theme");
  select.value = kept() ?? "auto";
  apply(select.value);
  select.addEventListener("change", () => {
    apply(select.value);
    keep(select.value);
    onChange();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", onChange);
}

function apply(theme) {
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
}

// Storage may be refused to a page; the choice then holds for this visit.
function kept() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}

function keep(theme) {
  try {
    localStorage.setItem(KEY, theme);
  } catch {
    // for this visit, then
  }
}
