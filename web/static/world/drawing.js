// Draws a world from above: its layout once, samples and robots as often as they change.

import { el, replace, svg } from "../page/dom.js";
import { along, createPeripherals } from "./peripherals.js";

const MARGIN_M = 0.3;
const LETTERS_PX = 11;
const MAX_LETTERS_M = 0.3;
const ROBOT_M = 0.2;
const TRAIL_POINTS = 150;
const TRAIL_STEP_M = 0.1;
const BESIDE_M = 0.3; // from a place's middle to its name
const LETTER_M = [0.1, 0.2]; // width and height of letters as most maps are shown

/** @returns {WorldDrawing} */
export function createDrawing() {
  const node = el("div", { class: "map-holder" });
  /** @type {Map<string, {points: Point[], line: SVGPolylineElement}>} */
  const trails = new Map();
  /** @type {Map<string, ReturnType<typeof robotMark> & {pose: string}>} */
  const marks = new Map();
  const layers = { trails: svg("g"), samples: svg("g"), robots: svg("g") };
  let doors = createPeripherals([]);
  let width = 1;
  let height = 1;
  /** @type {Map<string, Point>} */
  let places = new Map();

  /** @param {WorldLayout} layout */
  function showLayout({ compartments: floors, locations = [], walls = [], obstacles = [], slopes = [], zones = [], peripherals = [] }) {
    const left = Math.min(...floors.map((floor) => floor.x[0])) - MARGIN_M;
    const top = Math.max(...floors.map((floor) => floor.y[1])) + MARGIN_M;
    width = Math.max(...floors.map((floor) => floor.x[1])) + MARGIN_M - left;
    height = top - Math.min(...floors.map((floor) => floor.y[0])) + MARGIN_M;
    places = new Map(locations.map((location) => [location.name, location.at]));
    doors = createPeripherals(peripherals);
    marks.clear();
    for (const layer of Object.values(layers)) replace(layer);
    clearTrails();
    // North is up: the y axis is mirrored by negating every y.
    replace(node, svg(
      "svg",
      { viewBox: `${left} ${-top} ${width} ${height}`, class: "map-drawing", role: "group", "aria-label": "The world from above" },
      floors.map((floor) => rectangle(floor, "floor")),
      floors.flatMap((floor) => (floor.aisles ?? []).map((aisle) => rectangle(aisle, "aisle"))),
      slopes.map((slope) => rectangle(slope, "slope")),
      zones.map(zoneMark),
      locations.map((place) => placeMark(place, walls)),
      walls.map(wall),
      obstacles.map((rock) => svg("circle", { cx: rock.at[0], cy: -rock.at[1], r: rock.radius_m, class: "rock" })),
      doors.nodes,
      layers.trails,
      layers.samples,
      layers.robots,
    ));
    fitLetters();
  }

  // Letters are as high as the page's, however small the map is.
  function fitLetters() {
    const pixels_m = Math.min(node.clientWidth / width, node.clientHeight / height);
    if (pixels_m > 0) node.style.setProperty("--letters", `${Math.min(MAX_LETTERS_M, LETTERS_PX / pixels_m)}px`);
  }

  /** Samples in grippers are drawn with their robots. @param {Map<string, string>} lying the place of each sample */
  function showSamples(lying) {
    replace(layers.samples, [...lying].map(([name, place]) => {
      const at = places.get(place);
      return at ? sampleMark(name, at) : null;
    }));
  }

  /** Marks stay and keep the focus. @param {Record<string, RobotTelemetry>} robots @param {string | null} selected */
  function showRobots(robots, selected = null) {
    for (const [name, mark] of marks) {
      if (robots[name]) continue;
      mark.node.remove();
      marks.delete(name);
    }
    for (const [name, robot] of Object.entries(robots)) {
      if (doors.has(name)) continue;
      const mark = marks.get(name) ?? addMark(name);
      const position = `translate(${robot.x_m} ${-robot.y_m})`;
      const pose = `${position} rotate(${(-robot.heading_rad * 180) / Math.PI})`;
      mark.node.setAttribute("class", name === selected ? "robot-mark chosen" : "robot-mark");
      if (robot.holding) mark.body.append(mark.held);
      else mark.held.remove();
      if (mark.pose === pose) continue;
      mark.pose = pose;
      mark.body.setAttribute("transform", pose);
      mark.label.setAttribute("transform", position);
      extendTrail(name, robot.x_m, robot.y_m);
    }
  }

  /** @param {Robot[]} reports @param {number} now the world's time @param {string | null} selected */
  function showPeripherals(reports, now = 0, selected = null) {
    doors.show(reports, now, selected);
  }

  /** @param {string} name */
  function addMark(name) {
    const mark = { ...robotMark(name), pose: "" };
    marks.set(name, mark);
    layers.robots.append(mark.node);
    return mark;
  }

  /** @param {string} name @param {number} x @param {number} y */
  function extendTrail(name, x, y) {
    const trail = trails.get(name) ?? { points: [], line: svg("polyline", { class: "trail" }) };
    if (!trails.has(name)) layers.trails.append(trail.line);
    trails.set(name, trail);
    const last = trail.points.at(-1);
    if (last && Math.hypot(last[0] - x, last[1] - y) <= TRAIL_STEP_M) return;
    trail.points = [...trail.points, /** @type {Point} */ ([x, y])].slice(-TRAIL_POINTS);
    trail.line.setAttribute("points", trail.points.map(([east, north]) => `${east},${-north}`).join(" "));
  }

  function clearTrails() {
    trails.clear();
    replace(layers.trails);
  }

  new ResizeObserver(fitLetters).observe(node);
  return { node, showLayout, showSamples, showRobots, showPeripherals, clearTrails };
}

/** @param {string} name */
function robotMark(name) {
  const held = svg("rect", { x: 0.24, y: -0.1, width: 0.2, height: 0.2, class: "held" });
  const nose = svg("path", { d: `M${ROBOT_M * 0.9},0 L-0.06,0.1 L-0.06,-0.1 z`, class: "nose" });
  const body = svg("g", {}, svg("circle", { r: ROBOT_M }), nose);
  const label = text(name, 0, -0.28);
  return { node: svg("g", { "data-robot": name, role: "button", tabindex: 0, "aria-label": `robot ${name}` }, body, label), body, label, held };
}

/** @param {string} name @param {Point} at */
function sampleMark(name, [x, y]) {
  return button("sample-mark", name, `sample ${name}`, svg("rect", { x: x - 0.12, y: -y - 0.12, width: 0.24, height: 0.24, rx: 0.04 }), text(name, x, -y - 0.16));
}

/** @param {Place} place @param {Wall[]} walls */
function placeMark({ name, kind, at: [x, y] }, walls) {
  const mark = svg("rect", { x: x - 0.24, y: -y - 0.24, width: 0.48, height: 0.48, rx: 0.05 });
  return button(`place-mark ${kind}`, name, `place ${name}`, mark, kind === "home" ? null : placeName(name, [x, y], walls));
}

/** Below the place or, if a wall is there, beside it. @param {string} name @param {Point} at @param {Wall[]} walls */
function placeName(name, [x, y], walls) {
  const half = [(name.length * LETTER_M[0]) / 2, LETTER_M[1] / 2];
  /** @param {number[]} middle of the name */
  const isFree = (middle) => !walls.some(({ start, end }) => [0, 1].every((axis) => Math.abs((start[axis] + end[axis]) / 2 - middle[axis]) < Math.abs(start[axis] - end[axis]) / 2 + half[axis]));
  if (isFree([x, y - BESIDE_M - half[1]])) return text(name, x, -y + BESIDE_M, "0.8em");
  const side = isFree([x + BESIDE_M + half[0], y]) ? 1 : -1;
  return text(name, x + side * BESIDE_M, -y, "0.35em", side === 1 ? "right" : "left");
}

/** @param {string} kind @param {string} name @param {string} label @param {...Child} marks */
function button(kind, name, label, ...marks) {
  return svg("g", { class: kind, "data-name": name, role: "button", tabindex: 0, "aria-label": label }, svg("title", {}, label), marks);
}

/** @param {Floor} floor @param {string} kind */
function rectangle({ name, x, y }, kind) {
  return svg("rect", { "data-name": name, x: x[0], y: -y[1], width: x[1] - x[0], height: y[1] - y[0], class: kind });
}

/** What a zone's rule asks of robots, in words. @param {Zone} zone */
export function ruleInWords({ rule, max_speed_m_s: speed }) {
  if (rule === "slow") return `at most ${speed} m/s`;
  return { keep_out: "keep out", one_robot: "one robot" }[rule] ?? "";
}

/** A zone with its name and rule in its upper left corner. @param {Zone} zone */
function zoneMark(zone) {
  const said = [zone.name, ruleInWords(zone)].filter(Boolean).join(": ");
  return svg(
    "g",
    { class: `zone ${zone.rule}`, "data-name": zone.name },
    rectangle(zone, "zone-area"),
    svg("text", { x: zone.x[0] + 0.06, y: -zone.y[1], dy: "1.1em", class: "map-name zone-name" }, said),
  );
}

/** @param {string} content @param {number} x @param {number} y @param {string | null} dy @param {string} side of that point */
function text(content, x, y, dy = null, side = "") {
  return svg("text", { x, y, dy, class: `map-name ${side}` }, content);
}

/** The wall, and over it its openings, each in its kind's colour. @param {Wall} wall */
function wall({ start, end, openings = [] }) {
  const { length, line } = along(start, end);
  return [line(0, 1, "wall"), openings.map(({ kind, at_m, width_m }) => line((at_m - width_m / 2) / length, (at_m + width_m / 2) / length, `opening ${kind}`))];
}
