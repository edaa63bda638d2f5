// The left pane's lists: goals and missions, newest first, a page at a time.

import { badge, byId, closest, el } from "../page/dom.js";
import { displayState, facts, newestFirst, tone, words } from "../page/format.js";

/** @typedef {{id: string, goal: string, text: string, state: string, reason?: string | null, isSelected?: boolean}} Item */

/** @param {Store} store @param {{select: (goalId: string) => void, loadOlder: (name: "goals" | "missions") => void}} actions */
export function mountLists(store, { select, loadOlder }) {
  const goalList = mountList("goals", "goal-item", select, loadOlder);
  const missionList = mountList("missions", "mission-item", select, loadOlder);
  /** @type {unknown[]} */
  let drawn = [];
  store.subscribe(({ goals, missions, selected, hasOlder }) => {
    const shown = [goals, missions, selected, hasOlder.goals, hasOlder.missions];
    if (shown.every((one, index) => one === drawn[index])) return; // the clock updates the state each second
    drawn = shown;
    const texts = new Map(goals.map((goal) => [goal.id, goal.text]));
    goalList(newestFirst(goals).map((goal) => ({ id: goal.id, goal: goal.id, text: goal.text || facts(goal.goal), state: displayState(goal), reason: goal.reason, isSelected: goal.id === selected })), hasOlder.goals);
    missionList(newestFirst(missions).map((mission) => ({ id: mission.id, goal: mission.goal_id, text: texts.get(mission.goal_id) || mission.id, state: mission.state })), hasOlder.missions);
  });
}

/**
 * A list in which an item keeps its node as long as it looks the same, so that one change does not rebuild a thousand nodes.
 * @param {"goals" | "missions"} name @param {string} testId
 * @param {(goalId: string) => void} select @param {(name: "goals" | "missions") => void} loadOlder
 */
function mountList(name, testId, select, loadOlder) {
  const list = byId(name, HTMLElement);
  const older = el("li", {}, el("button", { class: "older", onclick: () => loadOlder(name) }, "Show older"));
  /** @type {Map<string, {looks: string, node: HTMLElement}>} */
  let known = new Map();
  list.addEventListener("click", (event) => {
    const goal = closest(event, "[data-goal]")?.dataset.goal;
    if (goal) select(goal);
  });

  /** @param {Item} item @returns {[string, {looks: string, node: HTMLElement}]} */
  function drawn(item) {
    const looks = JSON.stringify(item);
    const last = known.get(item.id);
    return [item.id, last?.looks === looks ? last : { looks, node: drawItem(item, testId) }];
  }

  /** @param {Item[]} items @param {boolean} hasOlder */
  return (items, hasOlder) => {
    known = new Map(items.map(drawn));
    const wanted = [...known.values()].map(({ node }) => node);
    if (hasOlder) wanted.push(older);
    const staying = new Set(wanted);
    for (const child of [...list.children]) if (!(child instanceof HTMLElement && staying.has(child))) child.remove();
    let next = list.firstChild;
    for (const child of wanted) {
      if (child === next) next = next.nextSibling;
      else list.insertBefore(child, next);
    }
  };
}

/** @param {Item} item @param {string} testId @returns {HTMLElement} */
function drawItem({ goal, text, state, reason, isSelected }, testId) {
  return el(
    "li",
    {},
    el(
      "button",
      { class: isSelected ? "item chosen" : "item", "data-testid": testId, "data-goal": goal, "aria-pressed": isSelected === undefined ? null : String(isSelected) },
      el("span", { class: "item-text" }, text),
      badge(tone(state), words(state)),
      reason ? el("span", { class: "quiet small whole" }, reason) : null,
    ),
  );
}
