// Where a plan falls short of what was asked: goals that come late, optional ones left out, preferences not kept.

import { el } from "../page/dom.js";
import { fact, seconds } from "../page/format.js";

/** @param {Plan} plan */
export function shortfalls(plan) {
  return [lateGoals(plan), leftOut(plan), preferences(plan)];
}

/** @param {Plan} plan */
function lateGoals({ late }) {
  return late?.length ? el("ul", { class: "problem", "data-testid": "late" }, late.map(({ goal, late_s }) => el("li", {}, `${fact(goal)} comes ${seconds(late_s)} after its deadline`))) : null;
}

/** @param {Plan} plan */
function leftOut({ left_out: goals, value, value_bound: bound }) {
  if (!goals?.length) return null;
  const doubt = (bound ?? 0) > (value ?? 0) ? ` (at most ${bound} with more time)` : "";
  return el("div", { class: "note", "data-testid": "left-out" }, `Optional goals worth ${value}${doubt}; left out:`, el("ul", {}, goals.map((one) => el("li", {}, `${fact(one.goal)}, worth ${one.value}: ${one.reason}`))));
}

/** Which preferences are kept, and why the others are not. @param {Plan} plan */
function preferences({ preferences: chosen, makespan_s: makespan }) {
  if (!chosen?.outcomes.length) return null;
  const total = chosen.cost_s ? ` Makespan and costs are ${seconds(makespan + chosen.cost_s)} together${chosen.bound_s ? `; no plan has less than ${seconds(chosen.bound_s)}` : ""}.` : "";
  const doubt = chosen.cut_short ? " Not every promising choice was tried." : "";
  return el(
    "div",
    { class: "note", "data-testid": "preferences" },
    `Preferences:${total}${doubt}`,
    el("ul", {}, chosen.outcomes.map((one) => el("li", {}, one.kept ? `kept: ${one.preference}` : `not kept, at a cost of ${seconds(one.cost_s)}: ${one.preference} (${one.reason})`))),
  );
}
