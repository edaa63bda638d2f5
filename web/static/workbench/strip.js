// Strip charts: values over time, a line a series, which its dashes tell as well as its colour; and tables beside them.

import { el, svg } from "../page/dom.js";

const HEIGHT = 40;
const MOST = 500;

// `series`: each [[time, value], …], oldest first; `at`: where the cursor stands, null without one.
export function strip(label, series, [from, till], [least, most], at = null) {
  const x = (time) => ((100 * (time - from)) / (till - from || 1)).toFixed(2);
  const y = (value) => (HEIGHT - 2 - ((HEIGHT - 4) * (value - least)) / (most - least || 1)).toFixed(1);
  const line = (points, index) => svg("polyline", { class: `series s${index % 4}`, points: thinned(points.filter(([time]) => time >= from && time <= till)).map(([time, value]) => `${x(time)},${y(value)}`).join(" ") });
  return svg("svg", { viewBox: `0 0 100 ${HEIGHT}`, preserveAspectRatio: "none", class: "strip", role: "img", "aria-label": label }, least < 0 && most > 0 ? svg("path", { class: "nought", d: `M0,${y(0)} H100` }) : null, series.map(line), at === null ? null : svg("path", { class: "cursor", d: `M${x(at)},0 V${HEIGHT}` }));
}

// As many points as a line has room for.
function thinned(points) {
  const every = Math.ceil(points.length / MOST);
  return points.filter((_, at) => at % every === 0);
}

// A table that scrolls; the first cell of a row names it.
export function grid(label, columns, body) {
  const head = el("thead", {}, el("tr", {}, columns.map((name) => el("th", { scope: "col" }, name))));
  return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": label }, el("table", {}, head, body));
}

export function row([name, ...cells]) {
  return el("tr", {}, el("th", { scope: "row" }, name), cells.map((cell) => el("td", {}, cell)));
}

// The newest of the points that is not after a time.
export function valueAt(points, time) {
  return points.findLast(([at]) => at <= time)?.[1];
}
