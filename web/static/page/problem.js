// Shows an error of the service, with the choices it offers.

import { problemOf } from "./api.js";
import { el, show } from "./dom.js";

/**
 * Send a request with its buttons disabled. After an error it is shown in `box` and they are enabled again; after success
 * the refreshed state draws them again.
 * @param {(HTMLButtonElement | HTMLInputElement)[]} buttons @param {Element} box @param {() => Promise<unknown>} request
 */
export async function attempt(buttons, box, request) {
  for (const button of buttons) button.disabled = true;
  show(box);
  try {
    await request();
  } catch (error) {
    show(box, problemBox(error));
    for (const button of buttons) button.disabled = false;
  }
}

/** @param {unknown} error */
export function problemBox(error) {
  const { title, message, choices } = problemOf(error);
  const offers = choices.map((choice) => el("span", { class: "choice" }, typeof choice === "string" ? choice : JSON.stringify(choice)));
  return el(
    "div",
    { class: "problem" },
    title && title !== message ? el("strong", {}, title) : null,
    el("p", {}, message),
    offers.length ? el("div", { class: "choices" }, offers) : null,
  );
}
