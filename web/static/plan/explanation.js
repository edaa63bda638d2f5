// Why a plan is as it is, requested when an operator opens it.

import { get, id } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { problemBox } from "../page/problem.js";

const MAX_WAITS = 5;

/** @param {Plan} plan */
export function explanation(plan) {
  const box = el("div", {}, el("p", { class: "quiet small" }, "Asking …"));
  const node = el("details", { "data-testid": "why" }, el("summary", {}, "Why this plan"), box);
  const load = async () => {
    try {
      show(box, reasons(await get(`/v1/plans/${id(plan.id)}/explanation`)));
    } catch (error) {
      show(box, problemBox(error));
    }
  };
  node.addEventListener("toggle", () => node.open && load(), { once: true });
  return node;
}

/** @param {PlanExplanation} explained */
function reasons({ makespan, waits, robots, actions }) {
  return el(
    "dl",
    {},
    el("dt", {}, "What determines the duration"),
    [...makespan, ...waits.slice(0, MAX_WAITS).map((wait) => wait.words)].map((words) => el("dd", {}, words)),
    Object.entries(robots).map(([robot, words]) => [el("dt", {}, robot), el("dd", {}, words)]),
    actions.map((action) => [
      el("dt", {}, action.action),
      [...action.because.slice(0, 1), ...Object.entries(action.robots).map((pair) => pair.join(": ")), ...action.order].map((words) => el("dd", {}, words)),
    ]),
  );
}
