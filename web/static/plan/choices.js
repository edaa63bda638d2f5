// Plans to choose from: have alternatives found, see them side by side, look at one.

import { id, post } from "../page/api.js";
import { el, svg } from "../page/dom.js";
import { seconds } from "../page/format.js";
import { asking } from "../page/problem.js";
import { inNumbers, kind } from "./drawing.js";

export function choices(goal, plan, plans, { look, refresh }) {
  if (goal?.state !== "planned" || plan.state !== "proposed") return null;
  const search = goal.alternatives;
  const seeking = search?.state === "seeking";
  const box = el("div", { role: "alert" });
  const button = el(
    "button",
    { type: "button", disabled: seeking, "data-testid": "seek-alternatives", onclick: seek },
    seeking ? "Looking for alternatives …" : "Find alternatives",
  );
  async function seek() {
    await asking([button], box, () => post(`/v1/goals/${id(goal.id)}:alternatives`));
    refresh();
  }
  return el(
    "div",
    { class: "alternatives" },
    plans.length > 1 ? comparison(plan, plans, look) : null,
    search && !seeking && plans.length < 2 ? el("p", { class: "quiet small" }, search.reason || "No plan differs from this one and is better at anything.") : null,
    button,
    box,
  );
}

const FIGURES = [
  ["takes", (one) => one.makespan_s, seconds],
  ["drives", (one) => one.distance_m, (value) => `${value.toFixed(1)} m`],
  ["uses", (one) => one.energy_j, (value) => `${Math.round(value)} J`],
  ["robots", (one) => one.robots.length, String],
  ["to clear", (one) => one.clearances, String],
];

// The plans beside each other on one scale: a small picture of each, and bars for what it takes.
function comparison(plan, plans, look) {
  const end = Math.max(...plans.map((one) => one.makespan_s));
  const robots = [...new Set(plans.flatMap((one) => one.robots))].sort(inNumbers);
  return el("div", { class: "beside", role: "group", "aria-label": "Plans to choose from; arrow keys go from one to the next", "data-testid": "alternatives", onkeydown: along }, plans.map((one) => {
    const isChosen = one.id === plan.id;
    return el(
      "button",
      { type: "button", class: "choice-card", "data-keep": one.id, "aria-pressed": String(isChosen), onclick: () => look(one.id) },
      el("span", { class: "choice-head" }, el("b", {}, one.label || "the plan"), isChosen ? el("span", { class: "badge busy" }, "shown below") : null),
      miniature(one, robots, end),
      el("span", { class: "quiet small" }, [one.robots.join(", "), one.comparison].filter(Boolean).join(": ")),
      FIGURES.map(([name, of, told]) => figure(name, of(one), plans.map(of), told)),
    );
  }));
}

function along(event) {
  const step = { ArrowRight: "nextElementSibling", ArrowDown: "nextElementSibling", ArrowLeft: "previousElementSibling", ArrowUp: "previousElementSibling" }[event.key];
  if (!step) return;
  event.preventDefault();
  event.target.closest("[data-keep]")?.[step]?.focus();
}

function figure(name, value, all, told) {
  const [least, most] = [Math.min(...all), Math.max(...all)];
  const isBest = value === least && least < most;
  const share = most > 0 ? (100 * value) / most : 0;
  return el(
    "span",
    { class: isBest ? "figure best" : "figure" },
    el("span", { class: "quiet" }, name),
    svg("svg", { viewBox: "0 0 100 8", preserveAspectRatio: "none", class: "utility", "aria-hidden": "true" }, svg("rect", { width: 100, height: 8, class: "utility-all" }), svg("rect", { width: share, height: 8, class: "utility-now" })),
    el("span", { class: "number" }, told(value), isBest ? el("span", { class: "best-mark" }, " best") : null),
  );
}

// A lane a robot, those that this plan does without left empty.
function miniature(one, robots, end) {
  const bars = robots.flatMap((robot, lane) => (one.lanes[robot] ?? []).map(([from, to, tag]) => svg("rect", { x: (100 * from) / end, y: lane * 8 + 1, width: Math.max(0.6, (100 * (to - from)) / end), height: 6, class: `bar ${kind(tag)}` })));
  return svg("svg", { viewBox: `0 0 100 ${robots.length * 8}`, preserveAspectRatio: "none", class: "lanes miniature", "aria-hidden": "true" }, robots.map((_, lane) => (lane % 2 ? null : svg("rect", { y: lane * 8, width: 100, height: 8, class: "lane" }))), bars);
}
