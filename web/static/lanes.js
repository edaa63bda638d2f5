// The plan drawn: a lane a robot, a bar an action, its slack as a thin tail, causal links between lanes as curves.

import { svg } from "./dom.js";

const LEFT = 74;
const WIDTH = 560;
const LANE = 34;
const BAR = 20;
const TOP = 20;

export function lanes(plan) {
  const robots = [...new Set(plan.actions.flatMap((action) => action.agents))].sort();
  const end = Math.max(plan.makespan_s, ...plan.actions.map((action) => action.latest_start_s + action.duration_s), 1);
  const x = (time) => LEFT + (time / end) * (WIDTH - LEFT - 8);
  const y = (robot) => TOP + robots.indexOf(robot) * LANE;
  const height = TOP + robots.length * LANE + 4;
  return svg(
    "svg",
    { viewBox: `0 0 ${WIDTH} ${height}`, class: "lanes", role: "img", "aria-label": "The plan's actions over time, a lane a robot" },
    axis(end, x, height),
    robots.map((robot) => svg("text", { x: 0, y: y(robot) + BAR / 2 + 4, class: "lane-name" }, robot)),
    plan.actions.flatMap((action) => action.agents.map((robot) => bar(action, x, y(robot)))),
    handovers(plan, x, y),
  );
}

function bar(action, x, top) {
  const left = x(action.earliest_start_s);
  const width = Math.max(3, x(action.earliest_start_s + action.duration_s) - left);
  const tail = x(action.latest_start_s + action.duration_s) - left - width;
  const label = width > 6.6 * action.tag.length ? action.tag : width > 22 ? action.tag.slice(0, 2) : "";
  return svg(
    "g",
    { class: `action tag-${action.tag.toLowerCase().replace(/[^a-z0-9]/g, "")}${action.critical ? " critical" : ""}` },
    svg("title", {}, action.description || action.tag),
    tail > 1 ? svg("rect", { x: left + width, y: top + BAR / 2 - 2, width: tail, height: 4, class: "slack" }) : null,
    svg("rect", { x: left, y: top, width, height: BAR, rx: 3, class: "bar" }),
    svg("text", { x: left + width / 2, y: top + BAR / 2 + 3.5, class: "bar-name" }, label),
  );
}

function axis(end, x, height) {
  const step = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600].find((size) => end / size <= 8) ?? end / 6;
  const ticks = Array.from({ length: Math.floor(end / step) + 1 }, (_, index) => index * step);
  return ticks.flatMap((time) => [
    svg("line", { x1: x(time), x2: x(time), y1: TOP - 6, y2: height, class: "grid" }),
    svg("text", { x: x(time), y: TOP - 9, class: "tick" }, `${Math.round(time)} s`),
  ]);
}

// Only the links from one robot's action to another's: where robots depend on one another.
function handovers(plan, x, y) {
  const actions = new Map(plan.actions.map((action) => [action.id, action]));
  return (plan.causal_links ?? []).flatMap(({ producer, consumer }) => {
    const from = actions.get(producer);
    const to = actions.get(consumer);
    if (!from || !to || from.agents.some((robot) => to.agents.includes(robot))) return [];
    const [x1, x2] = [x(from.earliest_start_s + from.duration_s), x(to.earliest_start_s)];
    const [y1, y2] = [y(from.agents[0]) + BAR / 2, y(to.agents[0]) + BAR / 2];
    const bend = Math.abs(x2 - x1) / 2;
    return [svg("path", { d: `M${x1},${y1} C${x1 + bend},${y1} ${x2 - bend},${y2} ${x2},${y2}`, class: "handover" })];
  });
}
