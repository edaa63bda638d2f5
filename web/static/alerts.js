// The alerts at the top of the page: what needs an operator's decision, with buttons for it.

import { id, post } from "./page/api.js";
import { byId, closest, el, replace, show } from "./page/dom.js";
import { attempt } from "./page/problem.js";
import { contact, isHeard } from "./robots/contact.js";

const MAX_ALERTS = 4;

/** @param {Store} store @param {{select: (goalId: string) => void, refresh: () => void}} actions */
export function mountAlerts(store, { select, refresh }) {
  const strip = el("div");
  const problem = el("div", { role: "alert" });
  replace(byId("alerts", HTMLElement), strip, problem);
  strip.addEventListener("click", async (event) => {
    const button = closest(event, "button");
    if (!(button instanceof HTMLButtonElement)) return;
    const { goal, path } = button.dataset;
    if (goal) select(goal);
    if (!path) return;
    await attempt([button], problem, () => post(path));
    refresh();
  });
  store.subscribe((state) => {
    const alerts = [...missionAlerts(state), ...robotAlerts(state), ...planAlerts(state)];
    const rest = alerts.length - MAX_ALERTS;
    if (!alerts.length) show(problem);
    show(strip, alerts.slice(0, MAX_ALERTS), rest > 0 ? el("p", { class: "quiet small" }, `and ${rest} more`) : null);
  });
}

/** @param {string} tone @param {string} text @param {...Child} buttons */
function alert(tone, text, ...buttons) {
  return el("p", { class: `alert ${tone}`, "data-testid": "alert" }, el("span", {}, text), buttons);
}

/** @param {string} goal */
const review = (goal) => el("button", { "data-goal": goal }, "Review");

/** @param {Mission} mission @param {string} verb @param {string} label */
function command(mission, verb, label) {
  return el("button", { "data-path": `/v1/missions/${id(mission.id)}:${verb}`, "data-goal": mission.goal_id }, label);
}

/** @param {State} state */
function planAlerts({ goals, selected }) {
  const waiting = goals.filter((goal) => goal.state === "planned" && goal.id !== selected);
  return waiting.map((goal) => alert("warn", `A plan waits for your decision: ${goal.text}`, review(goal.id)));
}

/** @param {State} state */
function missionAlerts({ goals, missions, selected }) {
  return missions.flatMap((mission) => {
    const name = goals.find((goal) => goal.id === mission.goal_id)?.text ?? mission.id;
    const step = mission.recovery?.step;
    if (step === "stuck") return [alert("bad", `${name}: no repair was found`, review(mission.goal_id), command(mission, "resume", "Try again"), command(mission, "cancel", "Cancel"))];
    if (step === "deciding" && mission.goal_id !== selected) return [alert("warn", `${name}: a repaired plan waits for your decision`, review(mission.goal_id))];
    if (mission.state === "unknown") return [alert("unknown", `${name}: it is not known how it stands. ${mission.reason ?? ""}`, review(mission.goal_id))];
    return [];
  });
}

/** @param {State} state */
function robotAlerts({ robots, worldTimes }) {
  const silent = robots.filter((robot) => robot.mission_id && !robot.lost && robot.connection !== "hibernating" && !isHeard(robot));
  return silent.map((robot) => {
    const { tone, word, note } = contact(robot, worldTimes[robot.world]);
    return alert(tone, `${robot.name} is on a mission and ${word}: ${note}; it goes on by itself`);
  });
}
