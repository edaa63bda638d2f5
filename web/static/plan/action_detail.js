// An action that is looked at, in words: when it is, what it needs and brings about, and why it is in the plan and this robot's.

import { get, id } from "../page/api.js";
import { badge, el, quiet, show } from "../page/dom.js";
import { fact, seconds } from "../page/format.js";

/** By path. @type {Map<string, Promise<ActionExplanation | null>>} */
const explanations = new Map();
const MAX_REASONS = 2;
const MAX_ORDERINGS = 3;

/**
 * @param {Element} node @param {Plan} plan @param {PlannedAction} action @param {ActionChange | undefined} change
 * @param {() => boolean} isShown whether it is still looked at
 */
export async function showAction(node, plan, action, change, isShown) {
  const path = `/v1/plans/${id(plan.id)}/actions/${id(action.id)}/explanation`;
  const known = explanations.get(path) ?? get(path).catch(() => {
    explanations.delete(path); // requested again the next time
    return null;
  });
  explanations.set(path, known);
  show(node, description(action, change));
  const reasons = await known;
  if (reasons && isShown()) show(node, description(action, change), reasonList(reasons));
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
      quiet(`starts ${seconds(action.earliest_start_s)}${latest}, takes ${seconds(action.duration_s)}`),
      action.critical ? badge("warn", "critical") : null,
      change ? badge("busy", change.words) : null,
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
