// Beside a mission's state: the goals that it carries out, too, and what planning it again would save.

import { id } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { seconds } from "../page/format.js";
import { commandButton } from "../page/problem.js";

/** @param {Element} node @param {Mission} mission @param {Element} problem @param {() => void} refresh */
export function showBeside(node, mission, problem, refresh) {
  const { joined_goals: goals = [], better_plan: better } = mission;
  show(
    node,
    goals.length > 0 && el("p", { class: "small", "data-testid": "joined-goals" }, `also carries out ${goals.join(", ")}`),
    better && el(
      "div",
      { class: "note", "data-testid": "better-plan" },
      el("p", { class: "small" }, `Planned again it would end about ${seconds(better.saves_s)} sooner, with ${better.robots.join(", ")}. Its robots stop for it.`),
      commandButton("Plan again", `/v1/missions/${id(mission.id)}:replan`, problem, refresh, { "data-testid": "take-better-plan" }),
    ),
  );
}
