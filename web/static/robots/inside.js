// What goes on inside a robot, drawn: its behaviour synthesis, what it tells of itself, what its whiskers feel.

import { el, svg } from "../page/dom.js";
import { words } from "../page/format.js";

const ROSE_PX = 120;
const FAR_M = 2; // whiskers are drawn to this range

// Each active pattern's utility as a bar, the resultant of its degree of freedom beneath (MACTA §3, eqs 1 to 3).
export function synthesis(told) {
  const patterns = Object.entries(told.patterns ?? {});
  if (!patterns.length) return el("p", { class: "quiet small" }, told.packet_tag ? `${told.packet_tag}: no pattern is active` : "No packet is active.");
  const freedoms = [...new Set(patterns.map(([name]) => name.split("/")[0]))].sort();
  return [
    el("p", { class: "small" }, el("b", {}, told.packet_tag ?? ""), " ", el("span", { class: "quiet" }, words(told.packet_state))),
    freedoms.map((freedom) => el(
      "div",
      { class: "freedom" },
      el("p", { class: "quiet small" }, freedom),
      patterns.filter(([name]) => name.startsWith(`${freedom}/`)).map(([name, pair]) => meter(words(name.slice(freedom.length + 1)), pair, "")),
      told.resultants?.[freedom] ? meter("resultant", told.resultants[freedom], "resultant") : null,
    )),
  ];
}

function meter(name, [response, utility], kind) {
  return el(
    "div",
    { class: `meter ${kind}`, title: `response ${response.toFixed(2)}, utility ${utility.toFixed(2)}` },
    el("span", { class: "meter-name" }, name),
    svg(
      "svg",
      { viewBox: "0 0 100 8", preserveAspectRatio: "none", class: "utility", role: "img", "aria-label": `utility ${utility.toFixed(2)}` },
      svg("rect", { x: 0, y: 0, width: 100, height: 8, class: "utility-all" }),
      svg("rect", { x: 0, y: 0, width: 100 * Math.min(1, Math.abs(utility)), height: 8, class: "utility-now" }),
    ),
    el("span", { class: "number small" }, `${response >= 0 ? "+" : "−"}${Math.abs(response).toFixed(2)}`),
  );
}

export function tellings(told) {
  const facts = [
    ["holds", told.holding ?? "nothing"],
    ["sees", Object.keys(told.tags ?? {}).join(", ") || "no sample"],
    ["sensors on", (told.sensors ?? []).map(words).join(", ") || "none"],
    ["battery", `${Math.round((told.battery ?? 0) * 100)} %${told.charging ? ", charging" : ""}`],
    ["does without", (told.degraded ?? []).join(", ")],
  ];
  return el("dl", { class: "slots small" }, facts.filter(([, text]) => text).map(([name, text]) => [el("dt", {}, name), el("dd", {}, text)]));
}

// What the whiskers feel around the robot, ahead at the top.
export function rose(told) {
  const ranges = told.ranges_m ?? [];
  const middle = ROSE_PX / 2;
  const scale = (middle - 6) / FAR_M;
  const end = (range, index) => {
    const turn = (2 * Math.PI * index) / ranges.length;
    return [middle - range * scale * Math.sin(turn), middle - range * scale * Math.cos(turn)];
  };
  return svg(
    "svg",
    { viewBox: `0 0 ${ROSE_PX} ${ROSE_PX}`, class: "rose", role: "img", "aria-label": `Nearest thing ${nearest(ranges)}` },
    [0.5, 1, FAR_M].map((range) => svg("circle", { cx: middle, cy: middle, r: range * scale, class: "ring" })),
    ranges.map((range, index) => {
      const [x, y] = end(Math.min(range ?? FAR_M, FAR_M), index);
      return svg("line", { x1: middle, y1: middle, x2: x, y2: y, class: range === null || range > FAR_M ? "free" : "met" });
    }),
    svg("path", { d: `M${middle},${middle - 7} L${middle + 5},${middle + 5} L${middle - 5},${middle + 5} z`, class: "hull" }),
  );
}

function nearest(ranges) {
  const met = ranges.filter((range) => range !== null);
  return met.length ? `${Math.min(...met).toFixed(2)} m` : "out of reach";
}
