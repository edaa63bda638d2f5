// The course of a goal's planning: the best plan so far and the proven bound, over time.

import { svg } from "../page/dom.js";
import { roughly, seconds } from "../page/format.js";

/** @typedef {{from: number, best: number, bound: number | null}} Step */

/** The best plan as a falling line, the bound as a rising one; the optimum lies between. @param {Step[]} steps @param {number} elapsed */
export function chart(steps, elapsed) {
  const max = Math.max(...steps.map(({ best }) => best));
  const min = Math.min(...steps.map(({ best, bound }) => bound ?? best));
  /** @param {number} time */
  const x = (time) => (100 * time) / Math.max(elapsed, 0.1);
  /** @param {number} makespan */
  const y = (makespan) => 2 + (26 * (max - makespan)) / Math.max(max - min, 0.1);
  /** @param {(step: Step) => number} value @param {string} name */
  const path = (value, name) => {
    const stairs = steps.map((step, index) => `H${x(step.from)} V${y(value(step))} H${x(steps[index + 1]?.from ?? elapsed)}`).join(" ");
    return svg("path", { d: `M${x(steps[0].from)},${y(value(steps[0]))} ${stairs}`, class: name });
  };
  const label = `From ${seconds(max)} to ${seconds(steps[steps.length - 1].best)} in ${roughly(elapsed)}`;
  return svg(
    "svg",
    { viewBox: "0 0 100 30", preserveAspectRatio: "none", class: "course", role: "img", "aria-label": label },
    path(({ best }) => best, "best"),
    steps[0].bound ? path(({ best, bound }) => bound ?? best, "bound") : null,
  );
}
