// Alternative plans: have them searched for, compare them, view one.

import { id } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { part } from "../page/part.js";
import { commandButton, problemBox } from "../page/problem.js";

const fetchComparison = part(() => import("./comparison.js"), "comparison");

/** @type {typeof import("./comparison.js") | null} */
let fetched = null;

/**
 * @param {Goal | null | undefined} goal @param {Plan} plan @param {Plan[]} plans
 * @param {{viewPlan: (planId: string) => void, refresh: () => void}} actions
 */
export function alternatives(goal, plan, plans, { viewPlan, refresh }) {
  if (goal?.state !== "planned" || plan.state !== "proposed") return null;
  const search = goal.alternatives;
  const isSearching = search?.state === "seeking";
  const box = el("div", { role: "alert" });
  const label = isSearching ? "Looking for alternatives …" : "Find alternatives";
  const button = commandButton(label, `/v1/goals/${id(goal.id)}:alternatives`, box, refresh, { disabled: isSearching, "data-testid": "seek-alternatives" });
  return el(
    "div",
    { class: "alternatives" },
    plans.length > 1 ? comparison(plan, plans, viewPlan) : null,
    search && !isSearching && plans.length < 2 ? el("p", { class: "quiet small" }, search.reason || "No plan differs from this one and is better at anything.") : null,
    button,
    box,
  );
}

/** Fetched when there are first plans to compare. @param {Plan} viewed @param {Plan[]} plans @param {(planId: string) => void} viewPlan */
function comparison(viewed, plans, viewPlan) {
  if (fetched) return fetched.comparison(viewed, plans, viewPlan);
  const place = el("div");
  fetchComparison().then((module) => {
    fetched = module;
    place.replaceWith(module.comparison(viewed, plans, viewPlan));
  }, (error) => show(place, problemBox(error)));
  return place;
}
