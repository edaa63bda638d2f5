// Draws a plan-net: a lane a robot, a bar an action, causal links with their facts; what truly happened beneath.

import { svg } from "../page/dom.js";
import { begun } from "../mission/elapsed.js";
import { fact, seconds } from "../page/format.js";

export const LANE_PX = 44;
export const TOP_PX = 34; // times, and above them now and the deadline
const BAR_PX = 20;
const ABOVE_PX = 6;
const ACTUAL_PX = 7;
const GHOST_PX = 12;
const SIDE_PX = 10;
const LETTER_PX = 6.9;
const LINE_PX = 12;
const LABELLED = 14; // more links than these are labelled only where an action is chosen
const DRAWN = 400;
const STEPS_S = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400];

// yard_2 before yard_10.
export const inNumbers = (one, other) => one.localeCompare(other, undefined, { numeric: true });

// What is where: robots' lanes in order, and the time axis over `width` pixels up to `end` seconds.
export function layout(plan, width, elapsed, ghosts, due) {
  const robots = [...new Set([...plan.actions, ...ghosts].flatMap(({ agents }) => agents))].sort(inNumbers);
  const planned = Math.max(plan.makespan_s, ...ghosts.map(({ to }) => to), ...plan.actions.map((action) => action.latest_start_s + action.duration_s), elapsed ?? 0, 1);
  const end = due > planned && due < 2 * planned ? due : planned; // a deadline that is far away would leave little room
  const lanes = new Map(robots.map((robot, at) => [robot, TOP_PX + at * LANE_PX]));
  return {
    robots,
    end,
    width,
    height: TOP_PX + robots.length * LANE_PX + 8,
    x: (time) => SIDE_PX + (time / end) * (width - 2 * SIDE_PX),
    y: (robot) => lanes.get(robot) ?? TOP_PX,
    actions: new Map(plan.actions.map((action) => [action.id, action])),
  };
}

export function backdrop(at) {
  const step = STEPS_S.find((size) => (at.width / at.end) * size >= 64) ?? STEPS_S.at(-1);
  const ticks = Array.from({ length: Math.floor(at.end / step) + 1 }, (_, index) => index * step);
  return [
    at.robots.map((robot, index) => (index % 2 ? null : svg("rect", { x: 0, y: at.y(robot), width: at.width, height: LANE_PX, class: "lane" }))),
    ticks.map((time) => [
      svg("line", { x1: at.x(time), x2: at.x(time), y1: TOP_PX - 6, y2: at.height, class: "grid" }),
      svg("text", { x: at.x(time), y: TOP_PX - 11, class: "tick", "text-anchor": time === 0 ? "start" : "middle" }, clock(time, step)),
    ]),
  ];
}

function clock(time, step) {
  if (step < 60 && time < 100) return `${time} s`;
  const rest = Math.round(time % 60);
  return rest ? `${Math.floor(time / 60)}:${String(rest).padStart(2, "0")}` : `${Math.round(time / 60)} min`;
}

// One action: its window as a track, its bar at its earliest time; a bar in each lane if several robots do it.
export function bar(action, at, change) {
  const left = at.x(action.earliest_start_s);
  const width = Math.max(4, at.x(action.earliest_start_s + action.duration_s) - left);
  const latest = at.x(action.latest_start_s + action.duration_s);
  const name = change?.kind === "new" ? `+ ${action.tag}` : action.tag;
  const label = width > LETTER_PX * name.length + 6 ? name : width > 24 ? name.slice(0, change ? 3 : 2) : "";
  return svg(
    "g",
    {
      class: `action ${kind(action.tag)}${action.critical ? " critical" : ""} ${change?.kind ?? ""}`,
      "data-action": action.id,
      role: "button",
      tabindex: -1,
      "aria-pressed": "false",
      "aria-label": [spoken(action), change?.words].filter(Boolean).join(", "),
    },
    action.agents.map((robot) => {
      const top = at.y(robot) + ABOVE_PX;
      return [
        latest - left - width > 1 ? svg("rect", { x: left, y: top + BAR_PX / 2 - 3, width: latest - left, height: 6, rx: 3, class: "window" }) : null,
        svg("rect", { x: left, y: top, width, height: BAR_PX, rx: 3, class: "bar" }),
        action.critical ? svg("rect", { x: left, y: top - 3, width, height: 2, class: "critical-mark" }) : null,
        label ? svg("text", { x: left + width / 2, y: top + BAR_PX / 2 + 3.8, class: "bar-name" }, label) : null,
      ];
    }),
  );
}

// What an action is drawn as.
export function kind(tag) {
  return `tag-${tag.toLowerCase().replace(/[^a-z0-9]/g, "")}`;
}

function spoken(action) {
  const window = `${seconds(action.earliest_start_s)} to ${seconds(action.earliest_start_s + action.duration_s)}`;
  return `${action.id} ${action.tag} by ${action.agents.join(" and ")}, ${window}${action.critical ? ", critical" : `, slack ${seconds(action.slack_s)}`}`;
}

// What the plan before had: beneath the bars, struck out where it is dropped, led to its new time where that moved.
export function ghost({ kind: change, words, agents, tag, from, to, heir }, at) {
  const [left, right] = [at.x(from), at.x(to)];
  return agents.map((robot) => {
    const top = at.y(robot) + ABOVE_PX + BAR_PX + 3;
    return svg(
      "g",
      { class: `ghost ${change}` },
      svg("title", {}, `${tag} by ${robot}: ${words}`),
      heir ? svg("line", { x1: left, y1: top, x2: at.x(heir.earliest_start_s), y2: top - 3 }) : null,
      svg("rect", { x: left, y: top, width: Math.max(3, right - left), height: GHOST_PX, rx: 2 }),
      svg("text", { x: left + 3, y: top + 9 }, fitting([`${tag}: ${words}`, words, tag], right - left)),
    );
  });
}

// The first that there is room for.
function fitting(texts, width) {
  return texts.find((text) => text.length * LETTER_PX * 0.85 < width) ?? "";
}

// Links between robots always; all those of a chosen action, with their facts.
export function links(plan, at, chosen = null) {
  const drawn = (plan.causal_links ?? []).filter(({ producer, consumer }) => {
    const [from, to] = [at.actions.get(producer), at.actions.get(consumer)];
    if (!from || !to) return false;
    if (chosen) return producer === chosen || consumer === chosen;
    return !from.agents.some((robot) => to.agents.includes(robot));
  });
  if (!chosen && drawn.length > DRAWN) return [];
  const taken = [];
  return drawn.map((link) => arrow(link, at, chosen || drawn.length <= LABELLED ? taken : null));
}

// `taken`: where labels stand already; none is drawn without.
function arrow({ producer, consumer, fact: carried }, at, taken) {
  const [from, to] = [at.actions.get(producer), at.actions.get(consumer)];
  const [x1, x2] = [at.x(from.earliest_start_s + from.duration_s), at.x(to.earliest_start_s)];
  const middle = (robot) => at.y(robot) + ABOVE_PX + BAR_PX / 2;
  const [y1, y2] = [middle(from.agents[0]), middle(to.agents[0])];
  const under = y1 + BAR_PX / 2; // in one lane the link hangs beneath the bars
  const bend = Math.max(18, Math.abs(x2 - x1) / 2);
  const path = y1 === y2 ? `M${x1 - 4},${under} C${x1 - 4},${under + 16} ${x2 + 6},${under + 16} ${x2 + 6},${under + 2}` : `M${x1},${y1} C${x1 + bend},${y1} ${x2 - bend},${y2} ${x2},${y2}`;
  const label = fact(carried);
  return svg(
    "g",
    { class: "link" },
    svg("title", {}, `${producer} → ${label} → ${consumer}`),
    svg("path", { d: path, "marker-end": "url(#arrow)" }),
    taken ? named(label, (x1 + x2) / 2, y1 === y2 ? under + 16 : (y1 + y2) / 2 + 4, at, taken) : null,
  );
}

// A label as near to its place as the others leave room.
function named(label, x, y, at, taken) {
  const half = label.length * LETTER_PX * 0.46 + 3;
  const left = Math.min(Math.max(x, half), Math.max(half, at.width - half));
  const free = (candidate) => taken.every((other) => Math.abs(other.x - left) >= other.half + half || Math.abs(other.y - candidate) >= LINE_PX);
  const y1 = [0, 1, -1, 2, -2, 3].map((lines) => y + lines * LINE_PX).find((candidate) => candidate > TOP_PX && candidate < at.height && free(candidate)) ?? y;
  taken.push({ x: left, y: y1, half });
  return svg("text", { x: left, y: y1, class: "link-name" }, label);
}

export function definitions() {
  const stripes = svg("pattern", { id: "hatch", width: 8, height: 8, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" }, svg("rect", { width: 3, height: 8, class: "stripe" }));
  return svg("defs", {}, stripes, svg("marker", { id: "arrow", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto-start-reverse" }, svg("path", { d: "M0,0 L8,4 L0,8 z", class: "arrow-head" })));
}

// From the instant that a robot was last heard nothing is known of it: its lane is hatched up to now, and says so.
export function unheard(silent, at, elapsed) {
  return silent.filter(({ robot }) => at.robots.includes(robot)).map(({ robot, since, tone, word, note }) => {
    const from = at.x(Math.max(0, since));
    const to = Math.max(from + 6, at.x(elapsed));
    const isLeft = from < at.width / 2;
    const y = at.y(robot);
    const told = { x: isLeft ? from + 4 : to, y: y + LANE_PX - 2, "text-anchor": isLeft ? "start" : "end" };
    return {
      hatch: svg("g", { class: `unheard ${tone}`, role: "img", "aria-label": `${robot} ${word}, ${note}` }, svg("rect", { x: from, y: y + 1, width: to - from, height: LANE_PX - 2, fill: "url(#hatch)" }), svg("line", { x1: from, x2: from, y1: y + 1, y2: y + LANE_PX - 1 })),
      words: svg("text", { ...told, class: "unheard-words", "aria-hidden": "true" }, `${word}: ${note}`),
    };
  });
}

// What has happened: beneath each planned bar when it truly ran, red where it took longer; the line of now.
export function actual(mission, at, elapsed, silent) {
  const start = begun(mission);
  if (typeof start !== "number") return [];
  const bars = (mission.progress ?? []).flatMap((script) => (script.packets ?? []).map((packet) => happened(script.robot, packet, start, at, silent.find(({ robot }) => robot === script.robot)?.since ?? elapsed)));
  const lines = [];
  if (typeof mission.deadline_s === "number") lines.push(upright(at, mission.deadline_s - start, "deadline", "due"));
  if (typeof mission.ended_at_s !== "number" && elapsed !== null) lines.push(upright(at, elapsed, "now", "now"));
  return [bars, lines];
}

function happened(robot, packet, start, at, elapsed) {
  if (typeof packet.started_at_s !== "number" || !at.robots.includes(robot)) return null;
  const from = packet.started_at_s - start;
  const to = typeof packet.finished_at_s === "number" ? packet.finished_at_s - start : Math.max(from, elapsed ?? from);
  const due = from + packet.expected_duration_s;
  const top = at.y(robot) + ABOVE_PX + BAR_PX + 3;
  const piece = (begin, end, name) => svg("rect", { x: at.x(begin), y: top, width: Math.max(2, at.x(end) - at.x(begin)), height: ACTUAL_PX, rx: 2, class: `actual ${name}` });
  return svg(
    "g",
    {},
    svg("title", {}, `${robot} ${packet.tag}: ${packet.state}, ${seconds(to - from)} of ${seconds(packet.expected_duration_s)} planned`),
    piece(from, Math.min(to, due), packet.state),
    to > due + 0.05 ? piece(due, to, "overrun") : null,
  );
}

function upright(at, time, name, label) {
  if (time < 0 || time > at.end) return null;
  const x = at.x(time);
  const anchor = x > at.width - 30 ? "end" : "start";
  return svg("g", { class: `upright ${name}` }, svg("line", { x1: x, x2: x, y1: TOP_PX - 10, y2: at.height }), svg("text", { x: anchor === "end" ? x - 3 : x + 3, y: 10, "text-anchor": anchor }, label));
}
