// Draws a robot's telemetry: its behaviour synthesis, its state, its range readings.

import { el, quiet, svg } from "../page/dom.js";
import { words } from "../page/format.js";

const ROSE_PX = 120;
const MAX_RANGE_M = 2; // readings are drawn up to this range

/**
 * Each active pattern's utility as a bar, beneath them the resultant of their degree of freedom (MACTA §3, eqs 1 to 3).
 * @param {RobotTelemetry} robot
 */
export function synthesis({ patterns = {}, resultants = {}, packet_tag: packet, packet_state: state }) {
  const active = Object.entries(patterns);
  if (!active.length) return el("p", { class: "quiet small" }, packet ? `${packet}: no pattern is active` : "No packet is active.");
  const freedoms = [...new Set(active.map(([name]) => name.split("/")[0]))].sort();
  return [
    el("p", { class: "small" }, el("b", {}, packet ?? ""), " ", quiet(words(state))),
    freedoms.map((freedom) => el(
      "div",
      { class: "freedom" },
      el("p", { class: "quiet small" }, freedom),
      active.filter(([name]) => name.startsWith(`${freedom}/`)).map(([name, pair]) => meter(words(name.slice(freedom.length + 1)), pair, "")),
      resultants[freedom] ? meter("resultant", resultants[freedom], "resultant") : null,
    )),
  ];
}

/** @param {string} name @param {Utilitor} utilitor @param {string} kind */
function meter(name, [response, utility], kind) {
  return el(
    "div",
    { class: `meter ${kind}`, title: `response ${response.toFixed(2)}, utility ${utility.toFixed(2)}` },
    el("span", { class: "meter-name" }, name),
    svg(
      "svg",
      { viewBox: "0 0 100 8", preserveAspectRatio: "none", class: "utility", role: "img", "aria-label": `utility ${utility.toFixed(2)}` },
      svg("rect", { width: 100, height: 8, class: "utility-all" }),
      svg("rect", { width: 100 * Math.min(1, Math.abs(utility)), height: 8, class: "utility-now" }),
    ),
    el("span", { class: "number small" }, `${response >= 0 ? "+" : "−"}${Math.abs(response).toFixed(2)}`),
  );
}

/** @param {RobotTelemetry} robot */
export function robotState(robot) {
  const facts = [
    ["holds", robot.holding ?? "nothing"],
    ["sees", Object.keys(robot.tags ?? {}).join(", ") || "no sample"],
    ["sensors on", (robot.sensors ?? []).map(words).join(", ") || "none"],
    ["battery", `${Math.round((robot.battery ?? 0) * 100)} %${robot.charging ? ", charging" : ""}`],
    ["troubles", (robot.degraded ?? []).join(", ")],
  ];
  return el("dl", { class: "slots small" }, facts.filter(([, text]) => text).map(([name, text]) => [el("dt", {}, name), el("dd", {}, text)]));
}

/** The range readings around the robot, ahead at the top. @param {RobotTelemetry} robot */
export function rangeRose({ ranges_m: ranges = [] }) {
  const centre = ROSE_PX / 2;
  const scale = (centre - 6) / MAX_RANGE_M;
  /** @param {number} range @param {number} index */
  const end = (range, index) => {
    const angle = (2 * Math.PI * index) / ranges.length;
    return { x2: centre - range * scale * Math.sin(angle), y2: centre - range * scale * Math.cos(angle) };
  };
  return svg(
    "svg",
    { viewBox: `0 0 ${ROSE_PX} ${ROSE_PX}`, class: "rose", role: "img", "aria-label": `Nearest thing ${nearest(ranges)}` },
    [0.5, 1, MAX_RANGE_M].map((range) => svg("circle", { cx: centre, cy: centre, r: range * scale, class: "ring" })),
    ranges.map((range, index) => {
      const isFree = range === null || range > MAX_RANGE_M;
      return svg("line", { x1: centre, y1: centre, ...end(isFree ? MAX_RANGE_M : range, index), class: isFree ? "free" : "met" });
    }),
    svg("path", { d: `M${centre},${centre - 7} L${centre + 5},${centre + 5} L${centre - 5},${centre + 5} z`, class: "hull" }),
  );
}

/** @param {(number | null)[]} ranges */
function nearest(ranges) {
  const finite = ranges.filter((range) => range !== null);
  return finite.length ? `${Math.min(...finite).toFixed(2)} m` : "out of reach";
}
