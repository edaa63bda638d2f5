// The state of a robot's link: its tone (colour and shape), the word for it, and when the robot was and will be heard.

import { roughly, words } from "../page/format.js";

/**
 * Silence alone means no failure: a robot out of contact carries on.
 * @param {Robot} robot @param {number} now the time of the robot's world
 */
export function contact(robot, now) {
  if (robot.lost) return { tone: "bad", word: "lost", note: lastHeard(robot, now) };
  if (robot.world_stands) return { tone: "unknown", word: "at a breakpoint", note: "its world stands at a breakpoint" };
  if (robot.silent) return { tone: "unknown", word: "silent", note: contactTimes(robot, now) };
  if (robot.connection === "online") return { tone: "good", word: "online", note: "" };
  if (robot.connection === "connection_broken") return { tone: "bad", word: "link broken", note: lastHeard(robot, now) };
  return { tone: "warn", word: robot.connection === "offline" ? "out of contact" : words(robot.connection), note: contactTimes(robot, now) };
}

/** @param {Robot} robot */
export function isHeard(robot) {
  return robot.connection === "online" && !robot.silent && !robot.lost;
}

/** @param {Robot} robot @param {number} now */
function contactTimes(robot, now) {
  const next = robot.next_contact_s > 0 ? `next contact in ${roughly(robot.next_contact_s)}` : "";
  return [lastHeard(robot, now), next].filter(Boolean).join(", ");
}

/** By the wall clock or the world's, whichever gives the longer time: a world may run fast or stand still. @param {Robot} robot @param {number} now */
function lastHeard({ last_heard_s: byWallClock, heard_at_s: heardAt }, now) {
  const spans = [byWallClock, typeof heardAt === "number" ? now - heardAt : null].filter((span) => typeof span === "number");
  return spans.length ? `last heard ${roughly(Math.max(...spans))} ago` : "never heard";
}
