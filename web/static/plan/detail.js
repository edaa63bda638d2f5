// The action that is looked at: what it needs, what it brings about, and why it is there by this robot.

import { get, id } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { fact, seconds } from "../page/format.js";

export function createDetail() {
  const node = el("div", { class: "detail", "data-testid": "action-detail", role: "status" });
  const known = new Map();
  let now = null;

  async function reasons(plan, action) {
    const key = `${plan.id}/${action.id}`;
    if (!known.has(key)) known.set(key, get(`/v1/plans/${id(plan.id)}/actions/${id(action.id)}/explanation`).catch(() => null));
    return known.get(key);
  }

  return {
    node,
    async look(plan, action, change) {
      now = action?.id ?? null;
      show(node, action ? described(action, change, null) : hint());
      if (!action) return;
      const told = await reasons(plan, action);
      if (now === action.id) show(node, described(action, change, told));
    },
  };
}

function hint() {
  return el("p", { class: "quiet small" }, "Point at an action, or go there with the arrow keys, to see what it needs and why it is there.");
}

function described(action, change, told) {
  const latest = action.slack_s > 0.05 ? `, at latest ${seconds(action.latest_start_s)}` : "";
  return [
    el("div", { class: "head" }, el("b", {}, `${action.id} ${action.tag}`), el("span", {}, action.agents.join(" and ")), el("span", { class: "quiet" }, `starts ${seconds(action.earliest_start_s)}${latest}, takes ${seconds(action.duration_s)}`), action.critical ? el("span", { class: "badge warn" }, "critical") : null, change ? el("span", { class: "badge busy" }, change.words) : null),
    el("p", {}, action.description ?? ""),
    el("dl", { class: "slots" }, slot("needs", action.preconditions), slot("brings about", action.intended_effects), slot("and also", action.other_effects), slot("ends", action.deletes)),
    told ? el("ul", { class: "links" }, told.because.slice(0, 2).map((line) => el("li", {}, line)), Object.entries(told.robots).map(([robot, why]) => el("li", {}, `${robot}: ${why}`)), told.order.slice(0, 3).map((line) => el("li", {}, line))) : null,
  ];
}

function slot(name, facts) {
  return facts?.length ? [el("dt", {}, name), el("dd", {}, facts.map((one) => el("code", {}, fact(one))))] : null;
}
