// The left pane's lists: goals and missions, the newest first, a page at a time.

import { el } from "../page/dom.js";
import { facts, standing, tone, words } from "../page/format.js";

export function mountLists(store, { select, older }) {
  const lists = { goals: mountList("goals", goalItem), missions: mountList("missions", missionItem) };
  for (const [name, { node }] of Object.entries(lists)) {
    node.addEventListener("click", (event) => {
      const item = event.target.closest("[data-goal]");
      if (item) select(item.dataset.goal);
      else if (event.target.closest("[data-older]")) older(name);
    });
  }
  let drawn = [];
  store.subscribe((state) => {
    const now = [state.goals, state.missions, state.selected, state.more.goals, state.more.missions];
    if (now.every((one, at) => one === drawn[at])) return; // the clock ticks each second
    drawn = now;
    const texts = new Map(state.goals.map((goal) => [goal.id, goal.text]));
    const goals = newestFirst(state.goals).map((goal) => ({ id: goal.id, text: goal.text || facts(goal.goal), standing: standing(goal), reason: goal.reason, isChosen: goal.id === state.selected }));
    const missions = newestFirst(state.missions).map((mission) => ({ id: mission.id, goal: mission.goal_id, text: texts.get(mission.goal_id) || mission.id, standing: mission.state }));
    lists.goals.show(goals, state.more.goals);
    lists.missions.show(missions, state.more.missions);
  });
}

// A list in which an item keeps its node as long as it looks the same: a thousand are not built anew for one.
function mountList(name, draw) {
  const node = document.getElementById(name);
  const more = el("li", {}, el("button", { type: "button", class: "older", "data-older": true }, "Show older"));
  let known = new Map();

  function drawnOf(item) {
    const looks = JSON.stringify(item);
    const was = known.get(item.id);
    return was?.looks === looks ? was : { looks, item: draw(item) };
  }

  return {
    node,
    show(items, hasMore) {
      known = new Map(items.map((item) => [item.id, drawnOf(item)]));
      const wanted = [...known.values()].map((drawn) => drawn.item);
      if (hasMore) wanted.push(more);
      const staying = new Set(wanted);
      for (const child of [...node.children]) if (!staying.has(child)) child.remove();
      let at = node.firstChild;
      for (const child of wanted) {
        if (child === at) at = at.nextSibling;
        else node.insertBefore(child, at);
      }
    },
  };
}

function goalItem({ id, text, standing, reason, isChosen }) {
  return el(
    "li",
    {},
    el(
      "button",
      { type: "button", class: isChosen ? "item chosen" : "item", "data-testid": "goal-item", "data-goal": id, "aria-pressed": isChosen ? "true" : "false" },
      el("span", { class: "item-text" }, text),
      el("span", { class: `badge ${tone(standing)}` }, words(standing)),
      reason ? el("span", { class: "quiet small whole" }, reason) : null,
    ),
  );
}

function missionItem({ goal, text, standing }) {
  return el(
    "li",
    {},
    el(
      "button",
      { type: "button", class: "item", "data-goal": goal, "data-testid": "mission-item" },
      el("span", { class: "item-text" }, text),
      el("span", { class: `badge ${tone(standing)}` }, words(standing)),
    ),
  );
}

export function newestFirst(list) {
  return [...list].sort((one, other) => String(other.created_at ?? "").localeCompare(String(one.created_at ?? "")));
}
