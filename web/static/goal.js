// The middle column's head: the goal, how its planning comes along, and what an operator can do about it.

import { id, post } from "./api.js";
import { el, replace, show } from "./dom.js";
import { facts, gap, seconds, standing, tone, words } from "./format.js";
import { problemBox } from "./problem.js";

const OPEN = ["submitted", "planning", "planned"];

export function mountGoal(store, { refresh }) {
  const container = document.getElementById("goal");
  const [due, planning] = [el("div"), el("div", { role: "status" })];
  let drawn = null;
  store.subscribe((state) => {
    const goal = state.goals.find((candidate) => candidate.id === state.selected);
    // What changes all the time is shown in boxes of its own: a button must not be replaced under the pointer.
    const key = JSON.stringify(goal && { ...goal, planning: null, updated_at: null });
    if (key !== drawn) {
      drawn = key;
      replace(container, goal ? head(goal, due, planning, refresh) : invitation());
    }
    show(due, goal ? urgency(goal, state.worldTimes[goal.world]) : null);
    show(planning, goal?.state === "planning" ? progress(goal.planning) : null);
  });
}

function invitation() {
  return el("p", { class: "quiet empty" }, "State a goal, or choose one, to see its plan here.");
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
        const button = event.currentTarget;
        button.disabled = true;
        show(problem);
        try {
          await post(`/v1/goals/${id(goal.id)}:${verb}`);
        } catch (error) {
          show(problem, problemBox(error));
          button.disabled = false;
        }
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

function progress(planning) {
  if (!planning) return el("p", { class: "note" }, "Waits for a planner …");
  const { engine, elapsed_s, makespan_s, lower_bound_s } = planning;
  const found = typeof makespan_s === "number";
  return el(
    "div",
    { class: "note", "data-testid": "planning" },
    el("b", {}, found ? `Best plan so far: ${seconds(makespan_s)}` : "No plan yet"),
    el("span", { class: "quiet" }, ` after ${seconds(elapsed_s)}, ${engine}`),
    found && gap(makespan_s, lower_bound_s) ? el("div", { class: "small" }, gap(makespan_s, lower_bound_s)) : null,
  );
}
