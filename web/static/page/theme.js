// Light, dark, or as the system has it.

import { recall, remember } from "./remembered.js";

const listeners = [];

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

export function onTheme(listener) {
  listeners.push(listener);
}

export function mountTheme() {
  const choice = document.getElementById("theme");
  const apply = (theme) => {
    if (theme) document.documentElement.dataset.theme = theme;
    else delete document.documentElement.dataset.theme;
    for (const listener of listeners) listener();
  };
  choice.value = recall("theme", "");
  apply(choice.value);
  choice.addEventListener("change", () => {
    remember("theme", choice.value);
    apply(choice.value);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => apply(choice.value));
}
