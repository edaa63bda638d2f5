// An error of the service, with the choices it offers.

import { el } from "./dom.js";

export function problemBox(problem, choose) {
  const choices = (problem.choices ?? []).map((choice) => {
    const label = typeof choice === "string" ? choice : JSON.stringify(choice);
    return choose
      ? el("button", { type: "button", class: "choice", onclick: () => choose(label) }, label)
      : el("span", { class: "choice" }, label);
  });
  return el(
    "div",
    { class: "problem" },
    problem.title && problem.title !== problem.message ? el("strong", {}, problem.title) : null,
    el("p", {}, problem.message),
    choices.length ? el("div", { class: "choices" }, choices) : null,
  );
}
