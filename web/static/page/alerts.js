// What asks for an operator's decision, with the answers on it, above everything else.

import { id, post } from "./api.js";
import { el, replace, show } from "./dom.js";
import { asking } from "./problem.js";
import { contact } from "../robots/contact.js";

const MOST = 4;
const STUCK = { deciding: "a repaired plan waits for your decision", stuck: "no repair was found" };

export function mountAlerts(store, { select, refresh }) {
  const [strip, problem] = [el("div"), el("div", { role: "alert" })];
  replace(document.getElementById("alerts"), strip, problem);
  strip.addEventListener("click", async (event) => {
    const button = event.target.closest("button");
    const { goal, path } = button?.dataset ?? {};
    if (goal) select(goal);
    if (!path) return;
    await asking([button], problem, () => post(path));
    refresh();
  });
  store.subscribe((state) => {
    const alerts = [...missionAlerts(state), ...robotAlerts(state), ...planAlerts(state)];
    const rest = alerts.length - MOST;
    if (!alerts.length) show(problem);
    show(strip, alerts.slice(0, MOST), rest > 0 ? el("p", { class: "quiet small" }, `and ${rest} more`) : null);
  });
}

function alert(tone, text, ...answers) {
  return el("p", { class: `alert ${tone}`, "data-testid": "alert" }, el("span", {}, text), answers);
}

const review = (goal) => el("button", { type: "button", "data-goal": goal }, "Review");
const answer = (label, path, goal) => el("button", { type: "button", "data-path": path, "data-goal": goal }, label);

function planAlerts(state) {
  const waiting = state.goals.filter((goal) => goal.state === "planned" && goal.id !== state.selected);
  return waiting.map((goal) => alert("warn", `A plan waits for your decision: ${goal.text}`, review(goal.id)));
}

function missionAlerts(state) {
  const named = (mission) => state.goals.find((goal) => goal.id === mission.goal_id)?.text ?? mission.id;
  return state.missions.flatMap((mission) => {
    const path = `/v1/missions/${id(mission.id)}`;
    const step = mission.recovery?.step;
    if (step === "stuck") return [alert("bad", `${named(mission)}: ${STUCK.stuck}`, review(mission.goal_id), answer("Try again", `${path}:resume`, mission.goal_id), answer("Cancel", `${path}:cancel`, mission.goal_id))];
    if (step === "deciding" && mission.goal_id !== state.selected) return [alert("warn", `${named(mission)}: ${STUCK.deciding}`, review(mission.goal_id))];
    if (mission.state === "unknown") return [alert("unknown", `${named(mission)}: it is not known how it stands. ${mission.reason ?? ""}`, review(mission.goal_id))];
    return [];
  });
}

function robotAlerts(state) {
  return state.robots.filter((robot) => robot.mission_id && !robot.lost && robot.connection !== "hibernating").flatMap((robot) => {
    const { tone, word, note } = contact(robot, state.worldTimes[robot.world]);
    return word === "online" ? [] : [alert(tone, `${robot.name} is on a mission and ${word}: ${note}; it goes on by itself`)];
  });
}
