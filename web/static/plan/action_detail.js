// The action under the pointer or selected: its conditions and effects, and why this robot performs it.

import { get, id } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { fact, seconds } from "../page/format.js";

const MAX_REASONS = 2;
const MAX_ORDERINGS = 3;

export function createActionDetail() {
  const node = el("div", { class: "detail", "data-testid": "action-detail", role: "status" });
  /** @type {Map<string, Promise<ActionExplanation | null>>} */
  const explanations = new Map();
  /** @type {string | null} */
  let shown = null;

  /** @param {Plan} plan @param {PlannedAction} action */
  function explanation(plan, action) {
    const path = `/v1/plans/${id(plan.id)}/actions/${id(action.id)}/explanation`;
    const known = explanations.get(path) ?? get(path).catch(() => null);
    explanations.set(path, known);
    return known;
  }

  return {
    node,
    /** @param {Plan} plan @param {PlannedAction | null} action @param {ActionChange} [change] */
    async show(plan, action, change) {
      shown = action?.id ?? null;
      show(node, action ? description(action, change) : hint());
      if (!action) return;
      const reasons = await explanation(plan, action);
      if (shown === action.id) show(node, description(action, change), reasons ? reasonList(reasons) : null);
    },
  };
}

function hint() {
  return el("p", { class: "quiet small" }, "Point at an action, or go there with the arrow keys, to see what it needs and why it is there.");
}

/** @param {PlannedAction} action @param {ActionChange} [change] */
function description(action, change) {
  const latest = action.slack_s > 0.05 ? `, at latest ${seconds(action.latest_start_s)}` : "";
  return [
    el(
      "div",
      { class: "head" },
      el("b", {}, `${action.id} ${action.tag}`),
      el("span", {}, action.agents.join(" and ")),
      el("span", { class: "quiet" }, `starts ${seconds(action.earliest_start_s)}${latest}, takes ${seconds(action.duration_s)}`),
      action.critical ? el("span", { class: "badge warn" }, "critical") : null,
      change ? el("span", { class: "badge busy" }, change.words) : null,
    ),
    el("p", {}, action.description ?? ""),
    el("dl", { class: "slots" }, slot("needs", action.preconditions), slot("brings about", action.intended_effects), slot("and also", action.other_effects), slot("ends", action.deletes)),
  ];
}

/** @param {ActionExplanation} explanation */
function reasonList({ because, robots, order }) {
  const lines = [...because.slice(0, MAX_REASONS), ...Object.entries(robots).map((pair) => pair.join(": ")), ...order.slice(0, MAX_ORDERINGS)];
  return el("ul", { class: "links" }, lines.map((line) => el("li", {}, line)));
}

/** @param {string} name @param {Fact[]} [facts] */
function slot(name, facts) {
  return facts?.length ? [el("dt", {}, name), el("dd", {}, facts.map((one) => el("code", {}, fact(one))))] : null;
}
