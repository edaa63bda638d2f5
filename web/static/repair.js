// What a repaired plan differs in from the one it takes the place of.

import { el } from "./dom.js";
import { words } from "./format.js";

export function repair(plan) {
  if (!plan.repairs) return null;
  const [summary, ...details] = plan.repairs.difference.words;
  return el(
    "details",
    { class: "note", "data-testid": "repairs" },
    el("summary", {}, `Repaired (${words(plan.repairs.course)}): ${summary ?? "nothing is different"}`),
    details.length ? el("ul", { class: "links" }, details.map((line) => el("li", {}, line))) : null,
    el("p", { class: "quiet small" }, `in the place of ${plan.repairs.plan_id}, which the world had overtaken`),
  );
}
