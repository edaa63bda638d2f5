// Strip charts of the telemetry of chosen robots, from when they were chosen.

import { el, quiet, replace, show } from "../page/dom.js";
import { stripChart, table, tableRow } from "./charts.js";

const MAX_SAMPLES = 3000; // five minutes of one robot's telemetry
const DRAW_EVERY_MS = matchMedia("(prefers-reduced-motion: reduce)").matches ? 1000 : 200;
const SPEED_OVER_S = 0.4; // speeds are measured over at least this long
const CURSOR_STEPS = 60;
/** @typedef {import("./charts.js").Sample} Sample */
/** @typedef {{label: string, series: Sample[][]}} Chart */

/** @param {number} angle */
const wrapped = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

/** By the newest telemetry and some from `SPEED_OVER_S` before. @type {Record<string, (now: RobotTelemetry, before?: RobotTelemetry) => number | null | undefined>} */
const QUANTITIES = {
  "speed m/s": (now, before) => before && Math.hypot(now.x_m - before.x_m, now.y_m - before.y_m) / (now.at_s - before.at_s),
  "turn rate rad/s": (now, before) => before && wrapped(now.heading_rad - before.heading_rad) / (now.at_s - before.at_s),
  "nearest thing m": ({ ranges_m: ranges }) => ranges && Math.min(...ranges.filter((range) => range !== null)),
  "to the goal m": (now) => now.goal_m,
  "battery %": (now) => now.battery && 100 * now.battery,
  "utility ahead": (now) => now.resultants?.translate?.[1],
  "utility turning": (now) => now.resultants?.rotate?.[1],
};

/** @param {Element} root @param {Store} _store @param {Telemetry} telemetry @returns {WorkbenchPart} */
export function mount(root, _store, telemetry) {
  /** By robot, oldest first. @type {Map<string, RobotTelemetry[]>} */
  const histories = new Map();
  /** @type {number | null} */
  let cursor = null;
  let drawnAt = 0;
  /** @type {[from: number, till: number]} */
  let times = [0, 1];
  const quantities = Object.keys(QUANTITIES).map((name, index) => checkbox(name, index < 3));
  /** @type {ReturnType<typeof checkbox>[]} */
  let robots = [];
  const robotChoice = el("fieldset", { "data-testid": "plot-robots" });
  const span = el("select", { "aria-label": "Time span", onchange: draw }, [15, 60, 300].map((time) => el("option", { value: time, selected: time === 60 }, `${time} s`)));
  const pause = checkbox("pause");
  const asTable = checkbox("table");
  const charts = el("div", { class: "charts", tabindex: 0, role: "group", "aria-label": "Charts: left and right arrow move the cursor", onpointermove: onPointer, onpointerleave: () => setCursor(null), onkeydown: onKey });
  replace(
    root,
    el("fieldset", {}, el("legend", { class: "small" }, "Quantities"), quantities.map(({ label }) => label)),
    robotChoice,
    el("div", { class: "head" }, span, pause.label, asTable.label),
    charts,
  );

  /** @param {string} name */
  function checkbox(name, checked = false) {
    const input = el("input", { type: "checkbox", value: name, checked, onchange: () => draw() });
    return { name, input, label: el("label", { class: "choice" }, input, ` ${name}`) };
  }

  /** @param {ReturnType<typeof checkbox>[]} boxes */
  const chosen = (boxes) => boxes.filter(({ input }) => input.checked).map(({ name }) => name);

  /** @param {TelemetryMessage} message */
  function onTelemetry(message) {
    if (pause.input.checked) return;
    for (const name of chosen(robots)) {
      const robot = message.robots[name];
      if (!robot) continue;
      const history = histories.get(name) ?? [];
      histories.set(name, history);
      const last = history.at(-1);
      if (last && last.at_s > robot.at_s) history.length = 0; // the world was restarted
      if (last?.at_s === robot.at_s) continue;
      history.push(robot);
      if (history.length > MAX_SAMPLES) history.shift();
    }
    if (performance.now() - drawnAt > DRAW_EVERY_MS) draw();
  }

  /** @param {string} name @param {string} quantity @returns {Sample[]} */
  function series(name, quantity) {
    const history = histories.get(name) ?? [];
    let before = -1; // the index of the last telemetry that is SPEED_OVER_S older
    return history.flatMap((robot) => {
      while (history[before + 1].at_s <= robot.at_s - SPEED_OVER_S) before += 1;
      if (robot.at_s < times[0]) return [];
      const value = QUANTITIES[quantity](robot, history[before]);
      return typeof value === "number" && Number.isFinite(value) ? [[robot.at_s, value]] : [];
    });
  }

  function draw() {
    drawnAt = performance.now();
    const names = chosen(robots).filter((name) => histories.get(name)?.length);
    const till = Math.max(0, ...names.map((name) => histories.get(name)?.at(-1)?.at_s ?? 0));
    times = [till - Number(span.value), till];
    const rows = chosen(quantities).map((label) => ({ label, series: names.map((name) => series(name, label)) }));
    if (!names.length) show(charts, el("p", { class: "quiet" }, "Choose a robot that is heard."));
    else show(charts, asTable.input.checked ? summary(names, rows) : rows.map((row) => figure(names, row)));
  }

  /** @param {string[]} names @param {Chart} chart */
  function figure(names, { label, series: lines }) {
    const values = lines.flat().map(([, value]) => value);
    const min = Math.min(0, ...values);
    const max = Math.max(0.1, ...values);
    const now = cursor ?? times[1];
    const keys = names.map((name, index) => el("span", { class: `key s${index % 4}` }, `${name} ${format(lines[index].findLast(([time]) => time <= now)?.[1])}`));
    const note = quiet(`${format(min)} to ${format(max)}${cursor === null ? "" : `, ${(times[1] - now).toFixed(1)} s ago`}`);
    return el("figure", {}, el("figcaption", { class: "small" }, el("b", {}, label), keys, note), stripChart(label, lines, times, [min, max], cursor));
  }

  /** @param {string[]} names @param {Chart[]} rows */
  function summary(names, rows) {
    return table("Telemetry", ["quantity", "robot", "now", "least", "most"], rows.flatMap(({ label, series: lines }) => names.map((name, index) => {
      const values = lines[index].map(([, value]) => value);
      return tableRow([label, name, format(values.at(-1)), format(Math.min(...values)), format(Math.max(...values))]);
    })));
  }

  /** @param {number | null} time */
  function setCursor(time) {
    cursor = time;
    draw();
  }

  /** @param {PointerEvent} event */
  function onPointer({ clientX }) {
    const box = charts.querySelector(".strip")?.getBoundingClientRect();
    if (box) setCursor(times[0] + ((clientX - box.left) / box.width) * (times[1] - times[0]));
  }

  /** @param {KeyboardEvent} event */
  function onKey(event) {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    const step = (times[1] - times[0]) / CURSOR_STEPS;
    setCursor(Math.min(times[1], Math.max(times[0], (cursor ?? times[1]) + (event.key === "ArrowRight" ? step : -step))));
    event.preventDefault();
  }

  const unfollow = telemetry.follow(onTelemetry);
  return {
    update(state) {
      const names = state.robots.filter((robot) => robot.world === state.world).map((robot) => robot.name);
      if (names.length === robots.length) return;
      robots = names.map((name) => checkbox(name, name === state.robot));
      replace(robotChoice, el("legend", { class: "small" }, "Robots"), robots.map(({ label }) => label));
    },
    close: unfollow,
  };
}

/** @param {number | undefined} value */
function format(value) {
  return value !== undefined && Number.isFinite(value) ? value.toFixed(Math.abs(value) < 10 ? 2 : 1) : "–";
}
