// A sequence diagram of what was said: a lifeline for each speaker, an arrow for each saying, in order of time downwards.

import { svg } from "../page/dom.js";
import { byNumber } from "../page/format.js";
import { SERVICE, fate } from "./sayings.js";

const HEAD_PX = 34;
const ROW_PX = 34;
const TIME_PX = 58; // left of the first lifeline
const MIN_LANE_PX = 96;
const MAX_LANE_PX = 210;
const LETTER_PX = 5.9;
const SLANT_PX = 9;
const SLANT_FROM_S = 1; // what arrives later is drawn as a falling arrow
const HEAD_WORDS = 14;

/** yard_2 before yard_10, robots before the service, persons last. @param {Saying[]} sayings @param {Set<string>} robots */
export function speakers(sayings, robots) {
  /** @param {string} name */
  const rank = (name) => (name === SERVICE ? 1 : robots.has(name) ? 0 : 2);
  const names = [...new Set(sayings.flatMap(({ from, to }) => [from, to]))];
  return names.sort((one, other) => rank(one) - rank(other) || byNumber(one, other));
}

/**
 * @param {Saying[]} sayings in order of time @param {string[]} names of the lifelines, in order
 * @param {object} shown
 * @param {number} shown.width pixels there are @param {Set<string>} shown.robots those names that are robots
 * @param {string | null} shown.conversation the one that is looked at: the others are faint
 * @param {number | null} shown.chosen the index of the saying that is looked at
 */
export function drawDiagram(sayings, names, { width, robots, conversation, chosen }) {
  const lane = Math.min(MAX_LANE_PX, Math.max(MIN_LANE_PX, (width - TIME_PX) / Math.max(1, names.length)));
  const height = HEAD_PX + ROW_PX * sayings.length + 16;
  /** @param {string} name */
  const x = (name) => TIME_PX + lane * (names.indexOf(name) + 0.5);
  return svg(
    "svg",
    { class: "sequence", width: TIME_PX + lane * names.length, height, role: "group", "aria-label": "Messages in order of time" },
    names.map((name) => lifeline(name, x(name), lane, height, name === SERVICE ? "of-service" : robots.has(name) ? "of-robot" : "of-person")),
    sayings.map((one, index) => arrow(one, index, HEAD_PX + ROW_PX * (index + 0.7), x(one.from), x(one.to), {
      isFaint: conversation !== null && one.conversation !== conversation,
      isChosen: index === chosen,
      isTabStop: index === (chosen ?? sayings.length - 1),
    })),
  );
}

/** @param {string} name @param {number} at @param {number} lane @param {number} height @param {string} kind */
function lifeline(name, at, lane, height, kind) {
  const width = Math.min(lane - 8, LETTER_PX * Math.min(name.length, HEAD_WORDS) * 1.15 + 18);
  return svg(
    "g",
    { class: `lifeline ${kind}` },
    svg("line", { x1: at, x2: at, y1: HEAD_PX - 6, y2: height }),
    svg("rect", { x: at - width / 2, y: 4, width, height: HEAD_PX - 10, rx: kind === "of-person" ? 11 : 3 }),
    svg("text", { x: at, y: 20.5, "text-anchor": "middle" }, clipped(name, (width - 10) / LETTER_PX / 1.1), svg("title", {}, name)),
  );
}

/**
 * @param {Saying} one @param {number} index @param {number} y @param {number} from @param {number} to
 * @param {{isFaint: boolean, isChosen: boolean, isTabStop: boolean}} look
 */
function arrow(one, index, y, from, to, { isFaint, isChosen, isTabStop }) {
  const wasLost = one.attempt > 1;
  const side = Math.sign(to - from);
  const below = one.heard_s !== null && one.heard_s - one.said_s >= SLANT_FROM_S ? y + SLANT_PX : y;
  const span = Math.abs(to - from);
  const lostAt = from + (to - from) * 0.25;
  const words = clipped(`${one.performative} ${one.content}`, Math.max(span, MIN_LANE_PX * 0.9) / LETTER_PX - (wasLost ? 4 : 1));
  const classes = ["saying", wasLost && "repeated", one.heard_s === null && !one.isAnswered && "unreported", isFaint && "faint", isChosen && "chosen"];
  return svg(
    "g",
    { class: classes.filter(Boolean).join(" "), "data-saying": index, role: "button", tabindex: isTabStop ? 0 : -1, "aria-pressed": String(isChosen), "aria-label": spoken(one) },
    svg("rect", { class: "reach", x: 0, y: y - 20, width: "100%", height: ROW_PX - 2 }),
    svg("text", { class: "tick", x: 4, y: y + 3.5 }, one.said_s.toFixed(1)),
    from === to ? svg("path", { d: `M${from},${y - 6} h26 v10 h-26` }) : svg("line", { x1: from, y1: y, x2: to, y2: below }),
    svg("path", { class: "head", d: from === to ? `M${to},${y + 4} l7,-4 v8 z` : `M${to},${below} l${-8 * side},-4.2 v8.4 z` }),
    wasLost ? svg("path", { class: "cross", d: `M${lostAt - 4},${y - 4} l8,8 m0,-8 l-8,8` }) : null,
    svg("text", { class: "words", x: from === to ? from + 32 : (from + to) / 2, y: y - 5, "text-anchor": from === to ? "start" : "middle" },
      words, wasLost ? svg("tspan", { class: "copies" }, ` ×${one.attempt}`) : null, svg("title", {}, spoken(one))),
  );
}

/** One saying in words. @param {Saying} one */
export function spoken(one) {
  const how = fate(one);
  return `${one.said_s.toFixed(1)} s: ${one.from} to ${one.to}, ${one.performative} ${one.content}${how ? `; ${how}` : ""}`;
}

/** @param {string} text @param {number} length */
const clipped = (text, length) => (text.length <= length ? text : `${text.slice(0, Math.max(1, Math.floor(length) - 1))}…`);
