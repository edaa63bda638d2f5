// The plans of a goal beside each other.

import { badge, closest, el, quiet, svg } from "../page/dom.js";
import { byNumber, seconds } from "../page/format.js";
import { kind } from "./drawing.js";
import { percent } from "./percent.js";

/** @type {[name: string, value: (plan: Plan) => number, format: (value: number) => string][]} */
const FIGURES = [
  ["takes", (plan) => plan.makespan_s, seconds],
  ["drives", (plan) => plan.distance_m, (value) => `${value.toFixed(1)} m`],
  ["uses", (plan) => plan.energy_j, (value) => `${Math.round(value)} J`],
  ["robots", (plan) => plan.robots.length, String],
  ["to clear", (plan) => plan.clearances, String],
];
/** @type {typeof FIGURES} */
const WITH_DEADLINE = [...FIGURES, ["may be late", (plan) => 1 - (plan.on_time ?? 1), percent]];

/**
 * The plans side by side on one scale: a small picture of each, and bars for its figures.
 * @param {Plan} viewed @param {Plan[]} plans @param {(planId: string) => void} viewPlan
 */
export function comparison(viewed, plans, viewPlan) {
  const end = Math.max(...plans.map((plan) => plan.makespan_s));
  const robots = [...new Set(plans.flatMap((plan) => plan.robots))].sort(byNumber);
  const shown = plans.some((plan) => typeof plan.on_time === "number") ? WITH_DEADLINE : FIGURES;
  const cards = plans.map((plan) => {
    const isViewed = plan.id === viewed.id;
    return el(
      "button",
      { class: "choice-card", "data-keep": plan.id, "aria-pressed": String(isViewed), onclick: () => viewPlan(plan.id) },
      el("span", { class: "choice-head" }, el("b", {}, plan.label || "the plan"), isViewed ? badge("busy", "shown below") : null),
      miniature(plan, robots, end),
      el("span", { class: "quiet small" }, [plan.robots.join(", "), plan.comparison].filter(Boolean).join(": ")),
      shown.map(([name, value, format]) => figure(name, value(plan), plans.map(value), format)),
    );
  });
  return el("div", { class: "beside", role: "group", "aria-label": "Plans to choose from; arrow keys go from one to the next", "data-testid": "alternatives", onkeydown: moveFocus }, cards);
}

/** @param {KeyboardEvent} event */
function moveFocus(event) {
  const card = closest(event, "[data-keep]");
  const isForward = ["ArrowRight", "ArrowDown"].includes(event.key);
  if (!card || !(isForward || ["ArrowLeft", "ArrowUp"].includes(event.key))) return;
  event.preventDefault();
  const next = isForward ? card.nextElementSibling : card.previousElementSibling;
  if (next instanceof HTMLElement) next.focus();
}

/** @param {string} name @param {number} value @param {number[]} all @param {(value: number) => string} format */
function figure(name, value, all, format) {
  const min = Math.min(...all);
  const max = Math.max(...all);
  const isBest = value === min && min < max;
  const share = max > 0 ? (100 * value) / max : 0;
  return el(
    "span",
    { class: isBest ? "figure best" : "figure" },
    quiet(name),
    svg(
      "svg",
      { viewBox: "0 0 100 8", preserveAspectRatio: "none", class: "utility", "aria-hidden": "true" },
      svg("rect", { width: 100, height: 8, class: "utility-all" }),
      svg("rect", { width: share, height: 8, class: "utility-now" }),
    ),
    el("span", { class: "number" }, format(value), isBest ? el("span", { class: "best-mark" }, " best") : null),
  );
}

/** One lane per robot; those of robots that this plan does not use stay empty. @param {Plan} plan @param {string[]} robots @param {number} end */
function miniature(plan, robots, end) {
  const bars = robots.flatMap((robot, lane) => (plan.lanes[robot] ?? []).map(([from, to, tag]) => svg("rect", { x: (100 * from) / end, y: lane * 8 + 1, width: Math.max(0.6, (100 * (to - from)) / end), height: 6, class: `bar ${kind(tag)}` })));
  const lanes = robots.map((_, lane) => (lane % 2 ? null : svg("rect", { y: lane * 8, width: 100, height: 8, class: "lane" })));
  return svg("svg", { viewBox: `0 0 100 ${robots.length * 8}`, preserveAspectRatio: "none", class: "lanes miniature", "aria-hidden": "true" }, lanes, bars);
}
