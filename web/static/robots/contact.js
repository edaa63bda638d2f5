// How a robot's link stands: its tone (colour and shape), the word for it, and when it was and will be heard.

import { roughly, words } from "../page/format.js";

// `now` by the world's clock. Silence is nothing but silence: a robot out of contact goes on by itself.
export function contact(robot, now) {
  if (robot.lost) return { tone: "bad", word: "lost", note: ago(robot, now) };
  if (robot.silent) return { tone: "unknown", word: "silent", note: notes(robot, now) };
  if (robot.connection === "online") return { tone: "good", word: "online", note: "" };
  if (robot.connection === "connection_broken") return { tone: "bad", word: "link broken", note: ago(robot, now) };
  return { tone: "warn", word: robot.connection === "offline" ? "out of contact" : words(robot.connection), note: notes(robot, now) };
}

// The robots at work on a mission of which nothing is known since an instant, by the world's clock.
export function unheardOn(mission, robots, now) {
  const isOpen = ({ state }) => !["finished", "failed", "cancelled"].includes(state);
  const atWork = typeof mission.ended_at_s === "number" ? [] : (mission.progress ?? []).filter(isOpen).map(({ robot }) => robot);
  return robots.filter((robot) => atWork.includes(robot.name) && !isHeard(robot) && typeof robot.heard_at_s === "number").map((robot) => ({ robot: robot.name, since: robot.heard_at_s, ...contact(robot, now) }));
}

function isHeard(robot) {
  return robot.connection === "online" && !robot.silent && !robot.lost;
}

function notes(robot, now) {
  const next = robot.next_contact_s > 0 ? `next contact in ${roughly(robot.next_contact_s)}` : "";
  return [ago(robot, now), next].filter(Boolean).join(", ");
}

// By the clock that says more: a world may run fast, and it may stand.
function ago(robot, now) {
  const spans = [robot.last_heard_s, now - robot.heard_at_s].filter(Number.isFinite);
  return spans.length ? `last heard ${roughly(Math.max(...spans))} ago` : "never heard";
}
