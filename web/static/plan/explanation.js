// Why a plan is as it is, requested when an operator opens it.

import { get, id } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { problemBox } from "../page/problem.js";

/** @param {Plan} plan */
export function explanation(plan) {
  const box = el("div", {}, el("p", { class: "quiet small" }, "Asking …"));
  const node = el("details", { "data-testid": "why" }, el("summary", {}, "Why this plan"), box);
  const load = async () => {
    try {
      const explained = await get(`/v1/plans/${id(plan.id)}/explanation`);
      show(box, (await import("./details.js")).reasons(explained));
    } catch (error) {
      show(box, problemBox(error));
    }
  };
  node.addEventListener("toggle", () => node.open && load(), { once: true });
  return node;
}
