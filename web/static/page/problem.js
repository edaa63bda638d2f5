// An error of the service, with the choices it offers.

import { el, show } from "./dom.js";

// Asks the service for something while the buttons are out of reach. What stands against it is told in `box`, and they
// can be pressed again; otherwise what has changed draws them anew.
export async function asking(buttons, box, question) {
  for (const button of buttons) button.disabled = true;
  show(box);
  try {
    await question();
  } catch (problem) {
    show(box, problemBox(problem));
    for (const button of buttons) button.disabled = false;
  }
}

export function problemBox(problem) {
  const choices = (problem.choices ?? []).map((choice) => {
    const label = typeof choice === "string" ? choice : JSON.stringify(choice);
    return el("span", { class: "choice" }, label);
  });
  return el(
    "div",
    { class: "problem" },
    problem.title && problem.title !== problem.message ? el("strong", {}, problem.title) : null,
    el("p", {}, problem.message),
    choices.length ? el("div", { class: "choices" }, choices) : null,
  );
}
