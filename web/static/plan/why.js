// Why a plan is as it is, fetched when an operator asks.

import { get, id } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { problemBox } from "../page/problem.js";

const WAITS = 5;

export function why(plan) {
  const box = el("div", {}, el("p", { class: "quiet small" }, "Asking …"));
  const node = el("details", { "data-testid": "why" }, el("summary", {}, "Why this plan"), box);
  node.addEventListener("toggle", () => node.open && fetched(), { once: true });
  async function fetched() {
    try {
      show(box, explained(await get(`/v1/plans/${id(plan.id)}/explanation`)));
    } catch (problem) {
      show(box, problemBox(problem));
    }
  }
  return node;
}

function explained(explanation) {
  return el(
    "dl",
    {},
    el("dt", {}, "What makes the time"),
    explanation.makespan.map((words) => el("dd", {}, words)),
    explanation.waits.slice(0, WAITS).map((wait) => el("dd", {}, wait.words)),
    Object.entries(explanation.robots).map(([robot, words]) => [el("dt", {}, robot), el("dd", {}, words)]),
    explanation.actions.map((action) => [
      el("dt", {}, action.action),
      action.because.slice(0, 1).map((words) => el("dd", {}, words)),
      Object.entries(action.robots).map(([robot, words]) => el("dd", {}, `${robot}: ${words}`)),
      action.order.map((words) => el("dd", {}, words)),
    ]),
  );
}
