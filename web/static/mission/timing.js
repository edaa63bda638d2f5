// A mission's times, by its world's clock.

import { contact, isHeard } from "../robots/contact.js";

export const ENDED = ["completed", "partially_completed", "failed", "cancelled"];
const SCRIPT_ENDED = ["finished", "failed", "cancelled"];

/** When the plan that the mission executes now began: a repaired plan begins after its mission. @param {Mission} mission */
export function planStart(mission) {
  return mission.revised_at_s ?? mission.started_at_s;
}

/**
 * Seconds from `start` to `time`, at most to the mission's end; null before it has started.
 * @param {Mission} mission @param {number | null | undefined} time
 */
export function elapsed(mission, time, start = mission.started_at_s) {
  const end = mission.ended_at_s ?? time;
  return typeof start === "number" && typeof end === "number" ? Math.max(0, end - start) : null;
}

/**
 * The mission's robots that still work and are not heard.
 * @param {Mission} mission @param {Robot[]} robots @param {number} now @returns {Silence[]}
 */
export function silences(mission, robots, now) {
  if (typeof mission.ended_at_s === "number") return [];
  const working = (mission.progress ?? []).filter(({ state }) => !SCRIPT_ENDED.includes(state)).map(({ robot }) => robot);
  return robots.flatMap((robot) => {
    if (!working.includes(robot.name) || isHeard(robot) || typeof robot.heard_at_s !== "number") return [];
    return [{ robot: robot.name, since: robot.heard_at_s, ...contact(robot, now) }];
  });
}
