// The middle column's head: the goal, how its planning comes along, and what an operator can do about it.

import { id, post } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { facts, seconds, standing, tone, words } from "../page/format.js";
import { asking } from "../page/problem.js";
import { createPlanning } from "./planning.js";

const OPEN = ["submitted", "waiting", "planning", "planned"];

export function mountGoal(store, { refresh }) {
  const container = document.getElementById("goal");
  const [due, planning] = [el("div"), el("div", { role: "status" })];
  const progress = createPlanning();
  let drawn = null;
  store.subscribe((state) => {
    const { goal } = state;
    // What changes all the time is shown in boxes of its own: a button must not be replaced under the pointer.
    const key = JSON.stringify(goal && { ...goal, planning: null, updated_at: null });
    if (key !== drawn) {
      drawn = key;
      replace(container, goal ? head(goal, due, planning, refresh) : goal === null ? invitation() : null);
    }
    show(due, goal ? urgency(goal, state.worldTimes[goal.world]) : null);
    show(planning, goal && (goal.state === "planning" || goal.planning) ? progress(goal) : null);
  });
}

// What a new operator does first.
const STEPS = [
  ["State a goal", "A sentence such as “move sample_1 to bay_7”; as you type, the page says what it lacks. Or pick a sample and a place on the map."],
  ["Review the plan", "It is drawn here: who does what when, and why these robots."],
  ["Approve it", "No robot moves before that."],
  ["Watch the mission", "What happens is drawn beneath what was planned. What needs a decision stands at the top of the page."],
];

function invitation() {
  const begin = () => document.getElementById("goal-text").focus();
  return el(
    "div",
    { class: "empty", "data-testid": "invitation" },
    el("h2", {}, "No goal yet"),
    el("ol", {}, STEPS.map(([step, about]) => el("li", {}, el("b", {}, step), el("div", { class: "quiet" }, about)))),
    el("button", { type: "button", class: "primary", onclick: begin }, "State a goal"),
  );
}

function head(goal, due, planning, refresh) {
  const problem = el("div", { role: "alert" });
  const came = goal.outcome && goal.state !== "unsolvable";
  return [
    el(
      "div",
      { class: "head" },
      el("h2", {}, goal.text || facts(goal.goal)),
      el("span", { class: `badge ${tone(standing(goal))}`, "data-testid": "goal-state" }, words(standing(goal))),
    ),
    goal.goal?.length ? el("p", { class: "quiet small" }, facts(goal.goal)) : null,
    due,
    goal.reason ? el("p", { class: "note", "data-testid": "goal-reason" }, goal.reason) : null,
    came ? el("p", { class: "note", "data-testid": "goal-outcome" }, `Outcome: ${words(goal.outcome)}`) : null,
    planning,
    OPEN.includes(goal.state) ? el("div", { class: "row controls" }, controls(goal, problem, refresh)) : null,
    problem,
  ];
}

function controls(goal, problem, refresh) {
  const act = (verb, label, tone) => el(
    "button",
    {
      type: "button",
      class: tone,
      "data-testid": `goal-${verb}`,
      onclick: async (event) => {
        await asking([event.currentTarget], problem, () => post(`/v1/goals/${id(goal.id)}:${verb}`));
        refresh();
      },
    },
    label,
  );
  return [
    goal.state === "planning" ? act("stop", "Stop and take the best", "primary") : null,
    act("cancel", "Withdraw", "danger"),
  ];
}

// A world's clock may run faster than ours: what is left of it is told in its seconds.
function urgency(goal, worldTime) {
  const told = [];
  if (typeof goal.deadline_at_s === "number" && typeof worldTime === "number" && !goal.outcome) {
    const left = goal.deadline_at_s - worldTime;
    told.push(left >= 0 ? `due in ${seconds(left)}` : `due ${seconds(-left)} ago`);
  } else if (typeof goal.deadline_s === "number") {
    told.push(`due within ${seconds(goal.deadline_s)}`);
  }
  if (goal.priority) told.push(`priority ${goal.priority}`);
  return told.length ? el("p", { class: "small", "data-testid": "goal-due" }, told.join(", ")) : null;
}
