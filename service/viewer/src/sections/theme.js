// The colour theme: light, dark, or that of the system.

import { byId } from "../dom.js";

const STORAGE_KEY = "attitude-theme";

export function installTheme(onChange) {
  const select = byId("theme");
  select.value = storedTheme() ?? "auto";
  apply(select.value);
  select.addEventListener("change", () => {
    apply(select.value);
    storeTheme(select.value);
    onChange();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", onChange);
}

function apply(theme) {
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
}

// A browser may deny storage; the choice then holds for this visit.
function storedTheme() {
  try {
    return localStorage.getItem(STORAGE_KEY);
  } catch {
    return null;
  }
}

function storeTheme(theme) {
  try {
    localStorage.setItem(STORAGE_KEY, theme);
  } catch {
    // holds for this visit
  }
}
