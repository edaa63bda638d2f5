// Draws the elements of a plan's picture: a lane per robot, a bar per action, causal links, and the actual times beneath.

import { planStart } from "../mission/timing.js";
import { svg } from "../page/dom.js";
import { byNumber, fact, seconds } from "../page/format.js";

export const LANE_PX = 44;
export const TOP_PX = 34; // the time axis, above it the marks of now and of the deadline
export const BAR_PX = 20;
export const ABOVE_PX = 6;
const ACTUAL_PX = 7;
const SIDE_PX = 10;
export const LETTER_PX = 6.9;
const LINE_PX = 12;
const BENEATH_PX = 46; // from a lane's top to the labels between its bars and those of the next
const MAX_LABELLED_LINKS = 14; // of more links only those of the selected action are labelled
const MAX_LINKS = 400;
const MIN_TICK_PX = 64;
const TICKS_S = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400];

/**
 * @param {Plan} plan @param {number} width pixels @param {number | null} elapsed seconds since the plan's start
 * @param {PreviousAction[]} previous @param {number | null} deadline seconds after the plan's start
 * @returns {PictureScale}
 */
export function pictureScale(plan, width, elapsed, previous, deadline) {
  const robots = [...new Set([...plan.actions, ...previous].flatMap(({ agents }) => agents))].sort(byNumber);
  const planned = Math.max(plan.makespan_s, ...previous.map(({ to }) => to), ...plan.actions.map((action) => action.latest_start_s + action.duration_s), elapsed ?? 0, 1);
  const isNear = deadline !== null && deadline > planned && deadline < 2 * planned; // a distant deadline would compress the plan
  const end = isNear ? deadline : planned;
  const lanes = new Map(robots.map((robot, index) => [robot, TOP_PX + index * LANE_PX]));
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

/** @param {PictureScale} scale */
export function background(scale) {
  const step = TICKS_S.find((size) => (scale.width / scale.end) * size >= MIN_TICK_PX) ?? TICKS_S[TICKS_S.length - 1];
  const times = Array.from({ length: Math.floor(scale.end / step) + 1 }, (_, index) => index * step);
  return [
    scale.robots.map((robot, index) => (index % 2 ? null : svg("rect", { x: 0, y: scale.y(robot), width: scale.width, height: LANE_PX, class: "lane" }))),
    times.map((time) => [
      svg("line", { x1: scale.x(time), x2: scale.x(time), y1: TOP_PX - 6, y2: scale.height, class: "grid" }),
      svg("text", { x: scale.x(time), y: TOP_PX - 11, class: "tick", "text-anchor": time === 0 ? "start" : "middle" }, tickText(time, step)),
    ]),
  ];
}

/** @param {number} time @param {number} step */
function tickText(time, step) {
  if (step < 60 && time < 100) return `${time} s`;
  const rest = Math.round(time % 60);
  return rest ? `${Math.floor(time / 60)}:${String(rest).padStart(2, "0")}` : `${Math.round(time / 60)} min`;
}

/**
 * One action: its time window as a track, its bar at its earliest time; a bar in each lane if several robots perform it.
 * @param {PlannedAction} action @param {PictureScale} scale @param {ActionChange} [change]
 */
export function actionBar(action, scale, change) {
  const left = scale.x(action.earliest_start_s);
  const width = Math.max(4, scale.x(action.earliest_start_s + action.duration_s) - left);
  const latest = scale.x(action.latest_start_s + action.duration_s);
  const name = change?.kind === "new" ? `+ ${action.tag}` : action.tag;
  const label = width > LETTER_PX * name.length + 6 ? name : width > 24 ? name.slice(0, change ? 3 : 2) : "";
  const bars = action.agents.map((robot) => {
    const top = scale.y(robot) + ABOVE_PX;
    return [
      latest - left - width > 1 ? svg("rect", { x: left, y: top + BAR_PX / 2 - 3, width: latest - left, height: 6, rx: 3, class: "window" }) : null,
      svg("rect", { x: left, y: top, width, height: BAR_PX, rx: 3, class: "bar" }),
      action.critical ? svg("rect", { x: left, y: top - 3, width, height: 2, class: "critical-mark" }) : null,
      label ? svg("text", { x: left + width / 2, y: top + BAR_PX / 2 + 3.8, class: "bar-name" }, label) : null,
    ];
  });
  return svg(
    "g",
    {
      class: `action ${kind(action.tag)}${action.critical ? " critical" : ""} ${change?.kind ?? ""}`,
      "data-action": action.id,
      role: "button",
      tabindex: -1,
      "aria-pressed": "false",
      "aria-label": [spokenName(action), change?.words].filter(Boolean).join(", "),
    },
    bars,
  );
}

/** The CSS class of an action's kind. @param {string} tag */
export function kind(tag) {
  return `tag-${tag.toLowerCase().replace(/[^a-z0-9]/g, "")}`;
}

/** @param {PlannedAction} action */
function spokenName(action) {
  const span = `${seconds(action.earliest_start_s)} to ${seconds(action.earliest_start_s + action.duration_s)}`;
  return `${action.id} ${action.tag} by ${action.agents.join(" and ")}, ${span}, ${action.critical ? "critical" : `slack ${seconds(action.slack_s)}`}`;
}

/** @typedef {{x: number, y: number, half: number}} LabelBox */

/**
 * The causal links between robots, or all those of a selected action with their facts.
 * @param {Plan} plan @param {PictureScale} scale @param {string | null} selected
 */
export function causalLinks(plan, scale, selected = null) {
  const ends = (plan.causal_links ?? []).flatMap((link) => {
    const from = scale.actions.get(link.producer);
    const to = scale.actions.get(link.consumer);
    if (!from || !to) return [];
    const isShown = selected ? [from.id, to.id].includes(selected) : !from.agents.some((robot) => to.agents.includes(robot));
    return isShown ? [{ link, from, to }] : [];
  });
  if (!selected && ends.length > MAX_LINKS) return [];
  /** @type {LabelBox[] | null} */
  const labels = selected || ends.length <= MAX_LABELLED_LINKS ? [] : null;
  return ends.map(({ link, from, to }) => arrow(link, from, to, scale, labels));
}

/** @param {CausalLink} link @param {PlannedAction} from @param {PlannedAction} to @param {PictureScale} scale @param {LabelBox[] | null} labels the labels placed so far */
function arrow(link, from, to, scale, labels) {
  const x1 = scale.x(from.earliest_start_s + from.duration_s);
  const x2 = scale.x(to.earliest_start_s);
  const y1 = scale.y(from.agents[0]) + ABOVE_PX + BAR_PX / 2;
  const y2 = scale.y(to.agents[0]) + ABOVE_PX + BAR_PX / 2;
  const isSameLane = y1 === y2;
  const under = y1 + BAR_PX / 2; // in one lane the link hangs beneath the bars
  const bend = Math.max(18, Math.abs(x2 - x1) / 2);
  const hanging = `M${x1 - 4},${under} C${x1 - 4},${under + 16} ${x2 + 6},${under + 16} ${x2 + 6},${under + 2}`;
  const path = isSameLane ? hanging : `M${x1},${y1} C${x1 + bend},${y1} ${x2 - bend},${y2} ${x2},${y2}`;
  const text = fact(link.fact);
  return svg(
    "g",
    { class: "link" },
    svg("title", {}, `${link.producer} → ${text} → ${link.consumer}`),
    svg("path", { d: path, "marker-end": "url(#arrow)" }),
    labels ? linkLabel(text, (x1 + x2) / 2, isSameLane ? under + 16 : (y1 + y2) / 2, scale, labels) : null,
  );
}

/**
 * A label between the bars of two lanes, as near to its place as the labels placed before leave room.
 * @param {string} text @param {number} x @param {number} y @param {PictureScale} scale @param {LabelBox[]} labels
 */
function linkLabel(text, x, y, scale, labels) {
  const half = text.length * LETTER_PX * 0.46 + 3;
  const left = Math.min(Math.max(x, half), Math.max(half, scale.width - half));
  /** @param {number} candidate */
  const isFree = (candidate) => labels.every((other) => Math.abs(other.x - left) >= other.half + half || Math.abs(other.y - candidate) >= LINE_PX);
  const candidates = scale.robots.flatMap((robot) => [BENEATH_PX, BENEATH_PX - LINE_PX].map((line) => scale.y(robot) + line));
  candidates.sort((one, other) => Math.abs(one - y) - Math.abs(other - y));
  const free = candidates.find(isFree) ?? candidates[0];
  labels.push({ x: left, y: free, half });
  return svg("text", { x: left, y: free, class: "link-name" }, text);
}

export function definitions() {
  const stripe = svg("rect", { width: 3, height: 8, class: "stripe" });
  const head = svg("path", { d: "M0,0 L8,4 L0,8 z", class: "arrow-head" });
  return svg(
    "defs",
    {},
    svg("pattern", { id: "hatch", width: 8, height: 8, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" }, stripe),
    svg("marker", { id: "arrow", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto-start-reverse" }, head),
  );
}

/**
 * The lanes of silent robots, hatched from when each was last heard up to now.
 * @param {Silence[]} silences @param {PictureScale} scale @param {number} elapsed
 */
export function silentLanes(silences, scale, elapsed) {
  return silences.filter(({ robot }) => scale.robots.includes(robot)).map(({ robot, since, tone, word, note }) => {
    const from = scale.x(Math.max(0, since));
    const to = Math.max(from + 6, scale.x(elapsed));
    const isLeft = from < scale.width / 2;
    const y = scale.y(robot);
    return {
      hatch: svg(
        "g",
        { class: `unheard ${tone}`, role: "img", "aria-label": `${robot} ${word}, ${note}` },
        svg("rect", { x: from, y: y + 1, width: to - from, height: LANE_PX - 2, fill: "url(#hatch)" }),
        svg("line", { x1: from, x2: from, y1: y + 1, y2: y + LANE_PX - 1 }),
      ),
      words: svg("text", { x: isLeft ? from + 4 : to, y: y + LANE_PX - 2, "text-anchor": isLeft ? "start" : "end", class: "unheard-words", "aria-hidden": "true" }, `${word}: ${note}`),
    };
  });
}

/**
 * Beneath each planned bar when its packet was executed, red where it took longer; the lines of now and of the deadline.
 * @param {Mission} mission @param {PictureScale} scale @param {number | null} elapsed @param {Silence[]} silences
 */
export function actualTimes(mission, scale, elapsed, silences) {
  const start = planStart(mission);
  if (typeof start !== "number") return [];
  const bars = (mission.progress ?? []).flatMap((script) => {
    const known = silences.find(({ robot }) => robot === script.robot)?.since ?? elapsed;
    return (script.packets ?? []).map((packet) => actualBar(script.robot, packet, start, scale, known));
  });
  const lines = [];
  if (typeof mission.deadline_s === "number") lines.push(verticalLine(scale, mission.deadline_s - start, "deadline", "due"));
  if (typeof mission.ended_at_s !== "number" && elapsed !== null) lines.push(verticalLine(scale, elapsed, "now", "now"));
  return [bars, lines];
}

/** @param {string} robot @param {PacketProgress} packet @param {number} start @param {PictureScale} scale @param {number | null} known until when the robot was heard */
function actualBar(robot, packet, start, scale, known) {
  if (typeof packet.started_at_s !== "number" || !scale.robots.includes(robot)) return null;
  const from = packet.started_at_s - start;
  const to = typeof packet.finished_at_s === "number" ? packet.finished_at_s - start : Math.max(from, known ?? from);
  const due = from + packet.expected_duration_s;
  const y = scale.y(robot) + ABOVE_PX + BAR_PX + 3;
  /** @param {number} begin @param {number} end @param {string} name */
  const piece = (begin, end, name) => svg("rect", { x: scale.x(begin), y, width: Math.max(2, scale.x(end) - scale.x(begin)), height: ACTUAL_PX, rx: 2, class: `actual ${name}` });
  return svg(
    "g",
    {},
    svg("title", {}, `${packet.delegated_to ?? robot} ${packet.tag}: ${packet.state}, ${seconds(to - from)} of ${seconds(packet.expected_duration_s)} planned`),
    piece(from, Math.min(to, due), packet.state),
    to > due + 0.05 ? piece(due, to, "overrun") : null,
  );
}

/** @param {PictureScale} scale @param {number} time @param {string} name @param {string} label */
function verticalLine(scale, time, name, label) {
  if (time < 0 || time > scale.end) return null;
  const x = scale.x(time);
  const isRight = x > scale.width - 30;
  return svg(
    "g",
    { class: `upright ${name}` },
    svg("line", { x1: x, x2: x, y1: TOP_PX - 10, y2: scale.height }),
    svg("text", { x: isRight ? x - 3 : x + 3, y: 10, "text-anchor": isRight ? "end" : "start" }, label),
  );
}
