// Shows an error of the service, with the choices it offers.

import { post, problemOf } from "./api.js";
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

/**
 * A button that posts a command of the API. `done` is called after the answer, whether it succeeded or not.
 * @param {string} label @param {string} path @param {Element} box shows an error @param {(button: HTMLButtonElement) => void} done
 * @param {Attributes} [attributes]
 */
export function commandButton(label, path, box, done, attributes = {}) {
  const send = async () => {
    await attempt([button], box, () => post(path));
    done(button);
  };
  const button = el("button", { ...attributes, onclick: send }, label);
  return button;
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
