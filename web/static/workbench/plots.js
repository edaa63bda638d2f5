// What chosen robots tell of themselves, as strip charts; kept from when they were chosen.

import { el, replace, show } from "../page/dom.js";
import { grid, row, strip, valueAt } from "./strip.js";

const KEPT = 3000; // five minutes of a robot
const DRAWN_MS = matchMedia("(prefers-reduced-motion: reduce)").matches ? 1000 : 200;
const OVER_S = 0.4; // speeds are told over at least this long
const turned = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
const QUANTITIES = {
  "speed m/s": (now, was) => (was ? Math.hypot(now.x_m - was.x_m, now.y_m - was.y_m) / (now.at_s - was.at_s) : null),
  "turn rate rad/s": (now, was) => (was ? turned(now.heading_rad - was.heading_rad) / (now.at_s - was.at_s) : null),
  "nearest thing m": (now) => now.ranges_m?.reduce((least, range) => (range === null || range > least ? least : range), Infinity),
  "to the goal m": (now) => now.goal_m,
  "battery %": (now) => 100 * now.battery,
  "utility ahead": (now) => now.resultants?.translate?.[1],
  "utility turning": (now) => now.resultants?.rotate?.[1],
};

export function mountPlots(root, store, telemetry) {
  const tapes = new Map(); // by robot, what it told, oldest first
  let [cursor, drawnAt, range] = [null, 0, [0, 1]];
  const wanted = (name, checked) => el("label", { class: "choice" }, el("input", { type: "checkbox", value: name, checked, onchange: () => draw() }), ` ${name}`);
  const what = el("fieldset", {}, el("legend", { class: "small" }, "Quantities"), Object.keys(QUANTITIES).map((name, at) => wanted(name, at < 3)));
  const who = el("fieldset", { "data-testid": "plot-robots" });
  const span = el("select", { "aria-label": "Time span", onchange: () => draw() }, [15, 60, 300].map((time) => el("option", { value: time, selected: time === 60 }, `${time} s`)));
  const [pause, table] = [wanted("pause"), wanted("table")];
  const isOn = (choice) => choice.control.checked;
  const charts = el("div", { class: "charts", tabindex: 0, role: "group", "aria-label": "Charts: left and right arrow move the cursor", onpointermove: point, onpointerleave: () => { cursor = null; draw(); }, onkeydown: step });
  replace(root, what, who, el("div", { class: "head" }, span, pause, table), charts);

  const chosen = (group) => [...group.querySelectorAll("input:checked")].map((box) => box.value);

  function take({ robots }) {
    if (isOn(pause)) return;
    for (const name of chosen(who)) {
      const told = robots[name];
      if (!told) continue;
      const tape = tapes.get(name) ?? tapes.set(name, []).get(name);
      if (tape.at(-1)?.at_s > told.at_s) tape.length = 0; // a world begun afresh
      if (tape.at(-1)?.at_s === told.at_s) continue;
      const was = tape.findLast((one) => one.at_s <= told.at_s - OVER_S);
      tape.push({ at_s: told.at_s, x_m: told.x_m, y_m: told.y_m, heading_rad: told.heading_rad, of: Object.values(QUANTITIES).map((quantity) => quantity(told, was)) });
      if (tape.length > KEPT) tape.shift();
    }
    if (performance.now() - drawnAt > DRAWN_MS) draw();
  }

  function draw() {
    drawnAt = performance.now();
    const names = chosen(who).filter((name) => tapes.get(name)?.length);
    const till = Math.max(0, ...names.map((name) => tapes.get(name).at(-1).at_s));
    range = [till - Number(span.value), till];
    const rows = chosen(what).map((label) => {
      const at = Object.keys(QUANTITIES).indexOf(label);
      return { label, series: names.map((name) => tapes.get(name).filter((one) => one.at_s >= range[0] && Number.isFinite(one.of[at])).map((one) => [one.at_s, one.of[at]])) };
    });
    show(charts, names.length ? (isOn(table) ? inTable : inCharts)(names, rows) : el("p", { class: "quiet" }, "Choose a robot that is heard."));
  }

  const inCharts = (names, rows) => rows.map(({ label, series }) => {
    const values = series.flat().map(([, value]) => value);
    const bounds = [Math.min(0, ...values), Math.max(0.1, ...values)];
    const now = cursor ?? range[1];
    return el("figure", {},
      el("figcaption", { class: "small" }, el("b", {}, label), names.map((name, index) => el("span", { class: `key s${index % 4}` }, `${name} ${worded(valueAt(series[index], now))}`)), el("span", { class: "quiet" }, `${worded(bounds[0])} to ${worded(bounds[1])}${cursor === null ? "" : `, ${(range[1] - now).toFixed(1)} s ago`}`)),
      strip(label, series, range, bounds, cursor));
  });

  const inTable = (names, rows) => grid("Telemetry", ["quantity", "robot", "now", "least", "most"], rows.flatMap(({ label, series }) => names.map((name, index) => {
    const values = series[index].map(([, value]) => value);
    return row([label, name, ...[values.at(-1), Math.min(...values), Math.max(...values)].map(worded)]);
  })));

  function point({ clientX }) {
    const box = charts.querySelector(".strip")?.getBoundingClientRect();
    if (!box) return;
    cursor = range[0] + ((clientX - box.left) / box.width) * (range[1] - range[0]);
    draw();
  }

  function step(event) {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    cursor = Math.min(range[1], Math.max(range[0], (cursor ?? range[1]) + (way * (range[1] - range[0])) / 60));
    draw();
    event.preventDefault();
  }

  const leave = telemetry.follow(take);
  return {
    update({ robots, robot, world }) {
      const mine = robots.filter((one) => one.world === world).map((one) => one.name);
      if (who.children.length !== mine.length + 1) replace(who, el("legend", { class: "small" }, "Robots"), mine.map((name) => wanted(name, name === robot)));
    },
    close: () => leave(),
  };
}

function worded(value) {
  return Number.isFinite(value) ? value.toFixed(Math.abs(value) < 10 ? 2 : 1) : "–";
}
