// Strip charts: values over time, a line per series, distinguished by dashes as well as colours; and tables.

import { el, svg } from "../page/dom.js";

const HEIGHT = 40;
const MAX_POINTS = 500;
/** @typedef {[time: number, value: number]} Sample @typedef {[min: number, max: number]} Bounds */

/**
 * @param {string} label @param {Sample[][]} series each oldest first @param {Bounds} times @param {Bounds} values
 * @param {number | null} cursor a time
 */
export function stripChart(label, series, [from, till], [min, max], cursor = null) {
  /** @param {number} time */
  const x = (time) => ((100 * (time - from)) / (till - from || 1)).toFixed(2);
  /** @param {number} value */
  const y = (value) => (HEIGHT - 2 - ((HEIGHT - 4) * (value - min)) / (max - min || 1)).toFixed(1);
  const lines = series.map((samples, index) => {
    const shown = samples.filter(([time]) => time >= from && time <= till);
    const every = Math.ceil(shown.length / MAX_POINTS);
    const points = shown.filter((_, position) => position % every === 0).map(([time, value]) => `${x(time)},${y(value)}`);
    return svg("polyline", { class: `series s${index % 4}`, points: points.join(" ") });
  });
  return svg(
    "svg",
    { viewBox: `0 0 100 ${HEIGHT}`, preserveAspectRatio: "none", class: "strip", role: "img", "aria-label": label },
    min < 0 && max > 0 ? svg("path", { class: "zero-line", d: `M0,${y(0)} H100` }) : null,
    lines,
    cursor === null ? null : svg("path", { class: "cursor", d: `M${x(cursor)},0 V${HEIGHT}` }),
  );
}

/** A scrolling table. @param {string} label @param {string[]} columns @param {Child} rows */
export function table(label, columns, rows) {
  const head = el("thead", {}, el("tr", {}, columns.map((name) => el("th", { scope: "col" }, name))));
  return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": label }, el("table", {}, head, rows));
}

/** A row of a table, headed by its first cell. @param {Child[]} cells */
export function tableRow([name, ...cells]) {
  return el("tr", {}, el("th", { scope: "row" }, name), cells.map((cell) => el("td", {}, cell)));
}
