// Doors, hatches and lifts on the map: a bar where a panel is closed, its two ends where it is open.

import { svg } from "../page/dom.js";
import { contact, isHeard } from "../robots/contact.js";
import { movement, outOfUse, standing } from "../robots/standing.js";

const END_M = 0.14;
const CROSS_M = 0.14;
const LABEL_M = 0.16;

/** @param {Peripheral[]} peripherals of a world's layout */
export function createPeripherals(peripherals) {
  const marks = new Map(peripherals.map((one) => [one.name, createMark(one)]));
  return {
    nodes: [...marks.values()].map(({ node }) => node),
    /** @param {string} name */
    has: (name) => marks.has(name),
    /** @param {Robot[]} reports @param {number} now the world's time @param {string | null} selected */
    show(reports, now, selected) {
      for (const report of reports) marks.get(report.name)?.show(report, now, report.name === selected);
    },
  };
}

/** @param {Peripheral} peripheral */
function createMark({ name, kind, start, end, cabin, stops = [] }) {
  const panels = start && end ? [panel(start, end, "opened")] : stops.map((stop) => panel(stop.start, stop.end, stop.level));
  const at = cabin ? middle([cabin.x[0], cabin.y[1]], [cabin.x[1], cabin.y[1]]) : labelPoint(panels);
  const label = svg("text", { x: at[0], y: -at[1], dy: cabin ? "1.2em" : "0", class: "map-name" });
  const title = svg("title");
  const floor = cabin ? svg("rect", { x: cabin.x[0], y: -cabin.y[1], width: cabin.x[1] - cabin.x[0], height: cabin.y[1] - cabin.y[0], class: "cabin" }) : null;
  const node = svg("g", { "data-robot": name, role: "button", tabindex: 0 }, title, ...[floor, ...panels.map((one) => one.node), label].filter((one) => one !== null));
  let drawn = "";

  /** @param {Robot} report @param {number} now @param {boolean} isSelected */
  function show(report, now, isSelected) {
    const stands = standing(report);
    const fault = outOfUse(report) || (isHeard(report) ? "" : contact(report, now).word);
    const said = [stands, fault, report.out_of_service?.reason].filter(Boolean).join(", ");
    const key = `${said} ${report.state} ${isSelected}`;
    if (key === drawn) return;
    drawn = key;
    const isMoving = Boolean(movement(report));
    node.setAttribute("class", ["peripheral-mark", kind, fault && "faulty", isSelected && "chosen"].filter(Boolean).join(" "));
    for (const { node: line, openAt } of panels) {
      line.setAttribute("class", `panel ${isMoving ? "moving" : !report.state ? "unknown" : report.state === openAt ? "open" : "closed"}`);
    }
    label.textContent = `${name}: ${fault || stands}`;
    title.textContent = `${kind} ${name}: ${said}`;
    node.setAttribute("aria-label", title.textContent);
  }

  show({ name, kind, world: "", connection: "online", next_contact_s: 0 }, 0, false);
  return { node, show };
}

/** The distance between two points in metres, and lines on the way from one to the other. @param {Point} start @param {Point} end */
export function along(start, end) {
  return {
    length: Math.hypot(end[0] - start[0], end[1] - start[1]) || 1,
    /** @param {number} from a share of the way @param {number} to @param {string} kind */
    line(from, to, kind) {
      const [x1, y1, x2, y2] = [from, to].flatMap((at) => [0, 1].map((axis) => start[axis] + at * (end[axis] - start[axis])));
      return svg("line", { x1, y1: -y1, x2, y2: -y2, class: kind });
    },
  };
}

/** A panel in all its states; its class says which is seen. @param {Point} start @param {Point} end @param {string} openAt the state in which it is open */
function panel(start, end, openAt) {
  const { length, line } = along(start, end);
  const share = Math.min(END_M / length, 0.25);
  const [x, y] = middle(start, end);
  const cross = svg("path", { d: `M${x - CROSS_M},${-y - CROSS_M} l${2 * CROSS_M},${2 * CROSS_M} m0,${-2 * CROSS_M} l${-2 * CROSS_M},${2 * CROSS_M}`, class: "cross" });
  return { openAt, start, end, node: svg("g", {}, line(0, 1, "reach"), line(0, 1, "sill"), line(0, 1, "leaf"), line(0, share, "post"), line(1 - share, 1, "post"), cross) };
}

/** @param {Point} one @param {Point} other @returns {Point} */
function middle(one, other) {
  return [(one[0] + other[0]) / 2, (one[1] + other[1]) / 2];
}

/** Above the first panel. @param {{start: Point, end: Point}[]} panels @returns {Point} */
function labelPoint([{ start, end }]) {
  return [middle(start, end)[0], Math.max(start[1], end[1]) + LABEL_M];
}
