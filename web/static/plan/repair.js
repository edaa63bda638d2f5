// How a repaired plan differs from the one it replaces: in words, and for picture and table.

import { el, svg } from "../page/dom.js";
import { roughly, words } from "../page/format.js";
import { ABOVE_PX, BAR_PX, LETTER_PX } from "./drawing.js";

const PREVIOUS_PX = 12;

/** @param {Plan} plan @param {Plan | null} previous */
export function repairNote(plan, previous) {
  if (!plan.repairs) return null;
  const [summary, ...details] = plan.repairs.difference.words;
  return el(
    "details",
    { class: "note", "data-testid": "repairs", open: plan.state === "proposed" },
    el("summary", {}, `${plan.repairs.course === "edited" ? "Edited" : `Repaired (${words(plan.repairs.course)})`}: ${summary ?? "nothing is different"}`),
    previous?.reason ? el("p", { class: "small" }, `The plan before was overtaken: ${previous.reason}`) : null,
    details.length ? el("ul", { class: "links" }, details.map((line) => el("li", {}, line))) : null,
  );
}

/** @param {Plan} plan @param {Plan | null} previousPlan @returns {PlanChanges} */
export function planChanges(plan, previousPlan) {
  const { kept = {}, reassigned = {}, dropped = [], added = [], shifted = {}, elapsed_s = 0 } = plan.repairs?.difference ?? {};
  const old = new Map((previousPlan?.actions ?? []).map((action) => [action.id, action]));
  const actions = new Map(plan.actions.map((action) => [action.id, action]));
  /** @type {PlanChanges["byAction"]} */
  const byAction = new Map(added.map((action) => [action, { kind: "new", words: "new" }]));
  /** @type {PreviousAction[]} */
  const previous = [];
  /** @param {string} name @param {PreviousAction["kind"]} kind @param {string} text @param {PlannedAction} [successor] */
  const addPrevious = (name, kind, text, successor) => {
    const action = old.get(name);
    if (!action || plan.state === "approved") return; // the actual times are drawn in their place
    const from = action.earliest_start_s - elapsed_s;
    const to = from + action.duration_s;
    if (to > 0) previous.push({ kind, words: text, agents: action.agents, tag: action.tag, from: Math.max(0, from), to, successor });
  };
  for (const name of dropped) addPrevious(name, "dropped", "dropped");
  for (const [name, successor] of Object.entries(reassigned)) {
    byAction.set(successor, { kind: "new", words: `instead of ${(old.get(name)?.agents ?? ["another"]).join(" and ")}` });
    addPrevious(name, "dropped", `now by ${actions.get(successor)?.agents.join(" and ")}`);
  }
  for (const [name, successor] of Object.entries(kept)) {
    if (!(successor in shifted)) continue;
    const shift = `${roughly(Math.abs(shifted[successor]))} ${shifted[successor] > 0 ? "later" : "earlier"}`;
    byAction.set(successor, { kind: "moved", words: `${shift} than before` });
    addPrevious(name, "moved", shift, actions.get(successor));
  }
  return { byAction, previous, draw: (scale) => previous.map((action) => previousAction(action, scale)) };
}

/**
 * An action of the previous plan: beneath the bars, struck out if dropped, with a line to its new time if moved.
 * @param {PreviousAction} action @param {PictureScale} scale
 */
function previousAction({ kind: change, words: text, agents, tag, from, to, successor }, scale) {
  const left = scale.x(from);
  const width = scale.x(to) - left;
  return agents.map((robot) => {
    const top = scale.y(robot) + ABOVE_PX + BAR_PX + 3;
    const label = [`${tag}: ${text}`, text, tag].find((one) => one.length * LETTER_PX * 0.85 < width) ?? "";
    return svg(
      "g",
      { class: `ghost ${change}` },
      svg("title", {}, `${tag} by ${robot}: ${text}`),
      successor ? svg("line", { x1: left, y1: top, x2: scale.x(successor.earliest_start_s), y2: top - 3 }) : null,
      svg("rect", { x: left, y: top, width: Math.max(3, width), height: PREVIOUS_PX, rx: 2 }),
      svg("text", { x: left + 3, y: top + 9 }, label),
    );
  });
}
