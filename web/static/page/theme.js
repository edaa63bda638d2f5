// Light, dark, or as the system has it.

import { byId } from "./dom.js";
import { loadPreference, savePreference } from "./preferences.js";

const systemIsDark = matchMedia("(prefers-color-scheme: dark)");
/** @type {(() => void)[]} */
const listeners = [];

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : systemIsDark.matches;
}

/** @param {() => void} listener */
export function onTheme(listener) {
  listeners.push(listener);
}

export function mountTheme() {
  const choice = byId("theme", HTMLSelectElement);
  const apply = () => {
    if (choice.value) document.documentElement.dataset.theme = choice.value;
    else delete document.documentElement.dataset.theme;
    for (const listener of listeners) listener();
  };
  choice.value = loadPreference("theme", "");
  apply();
  choice.addEventListener("change", () => {
    savePreference("theme", choice.value);
    apply();
  });
  systemIsDark.addEventListener("change", apply);
}
