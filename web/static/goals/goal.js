// The head of the middle pane: the goal, its planning progress, and what an operator can do about it.

import { id } from "../page/api.js";
import { badge, byId, el, replace, show } from "../page/dom.js";
import { displayState, facts, seconds, tone, words } from "../page/format.js";
import { part } from "../page/part.js";
import { commandButton, problemBox } from "../page/problem.js";
import { termItems } from "./terms.js";

const OPEN = ["submitted", "waiting", "planning", "planned"];
const SERVICE = ["low_battery", "waiting_goals"];
const fetchConflict = part(() => import("./conflict.js"));
const fetchProgress = part(() => import("./planning_progress.js"));

/** @param {Store} store @param {() => void} refresh */
export function mountGoal(store, refresh) {
  const container = byId("goal", HTMLElement);
  const due = el("div");
  const planning = el("div", { role: "status" });
  /** @type {((goal: Goal) => Element) | undefined} */
  let progress; // fetched when a goal is first planned
  let drawn = "";
  /** @param {typeof import("./planning_progress.js")} module */
  const started = (module) => {
    progress ??= module.createPlanningProgress();
    store.update({});
  };
  store.subscribe(({ goal, worldTimes }) => {
    // What changes all the time has elements of its own: a button must not be replaced under the pointer.
    const key = JSON.stringify(goal ? { ...goal, planning: null, updated_at: null } : goal) ?? "";
    if (key !== drawn) {
      drawn = key;
      replace(container, goal ? head(goal, due, planning, refresh) : null);
    }
    show(due, goal ? dueText(goal, worldTimes[goal.world]) : null);
    const isPlanning = goal && (goal.state === "planning" || goal.planning);
    if (isPlanning && !progress) fetchProgress().then(started, (error) => show(planning, problemBox(error)));
    else show(planning, isPlanning ? progress?.(goal) : null);
  });
}

/** @param {Goal} goal @param {Element} due @param {Element} planning @param {() => void} refresh */
function head(goal, due, planning, refresh) {
  const problem = el("div", { role: "alert" });
  const hasOutcome = goal.outcome && goal.state !== "unsolvable";
  const state = displayState(goal);
  const terms = termItems(goal);
  return [
    el(
      "div",
      { class: "head" },
      el("h2", {}, goal.text || facts(goal.goal)),
      badge(tone(state), words(state), { "data-testid": "goal-state" }),
    ),
    goal.goal?.length ? el("p", { class: "quiet small" }, facts(goal.goal)) : null,
    SERVICE.includes(goal.created_by) ? el("p", { class: "quiet small" }, `stated by the service: ${words(goal.created_by)}`) : null,
    terms.length ? el("ul", { class: "terms", "data-testid": "goal-terms-kept" }, terms) : null,
    due,
    goal.reason ? el("p", { class: "note", "data-testid": "goal-reason" }, goal.reason) : null,
    goal.conflict ? conflict(goal.conflict) : null,
    hasOutcome ? el("p", { class: "note", "data-testid": "goal-outcome" }, `Outcome: ${words(goal.outcome)}`) : null,
    planning,
    OPEN.includes(goal.state) ? el("div", { class: "row controls" }, controls(goal, problem, refresh)) : null,
    problem,
  ];
}

/** Which constraints cannot be kept together, once the part that says so is there. @param {Conflict} found */
function conflict(found) {
  const box = el("div");
  fetchConflict().then(({ conflictNote }) => show(box, conflictNote(found)), (error) => show(box, problemBox(error)));
  return box;
}

/** @param {Goal} goal @param {Element} problem @param {() => void} refresh */
function controls(goal, problem, refresh) {
  /** @param {string} verb @param {string} label @param {string} kind */
  const command = (verb, label, kind) => commandButton(label, `/v1/goals/${id(goal.id)}:${verb}`, problem, refresh, { class: kind, "data-testid": `goal-${verb}` });
  return [
    goal.state === "planning" ? command("stop", "Stop and take the best", "primary") : null,
    command("cancel", "Withdraw", "danger"),
  ];
}

/** The deadline in seconds of the world's clock, which may run faster than ours. @param {Goal} goal @param {number | undefined} worldTime */
function dueText(goal, worldTime) {
  const parts = [];
  if (typeof goal.deadline_at_s === "number" && typeof worldTime === "number" && !goal.outcome) {
    const left = goal.deadline_at_s - worldTime;
    parts.push(left >= 0 ? `due in ${seconds(left)}` : `due ${seconds(-left)} ago`);
  } else if (typeof goal.deadline_s === "number") {
    parts.push(`due within ${seconds(goal.deadline_s)}`);
  }
  if (typeof goal.not_before_at_s === "number" && typeof worldTime === "number" && goal.not_before_at_s > worldTime && !goal.outcome) {
    parts.push(`not before ${seconds(goal.not_before_at_s - worldTime)} from now`);
  }
  if (goal.priority) parts.push(`priority ${goal.priority}`);
  return parts.length ? el("p", { class: "small", "data-testid": "goal-due" }, parts.join(", ")) : null;
}
