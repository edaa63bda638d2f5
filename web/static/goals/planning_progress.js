// A goal's planning progress: the engine, the best plan so far, the proven bound, and both over time.

import { el, quiet, svg } from "../page/dom.js";
import { gap, roughly, seconds } from "../page/format.js";

/** @typedef {{from: number, best: number, bound: number | null}} Step */

/** Returns a function that draws a goal's progress and keeps its history between calls. */
export function createPlanningProgress(now = () => performance.now() / 1000) {
  let heard = { goal: "", message: "", at: 0, steps: /** @type {Step[]} */ ([]) };
  /** @param {Goal} goal */
  return (goal) => {
    const message = JSON.stringify(goal.planning) ?? "";
    if (heard.goal !== goal.id) heard = { goal: goal.id, message: "", at: now(), steps: [] };
    if (heard.message !== message) Object.assign(heard, { message, at: now() });
    if (!goal.planning) return el("p", { class: "note" }, "Waits for a planner …");
    if (goal.planning.waits_for) return el("p", { class: "note" }, `Waits for ${goal.planning.waits_for} …`);
    const { engine, elapsed_s: sent, makespan_s: best, lower_bound_s: bound } = goal.planning;
    const elapsed = sent + now() - heard.at; // no message comes while only the time changes
    const last = heard.steps.at(-1);
    if (best !== null && (last?.best !== best || last.bound !== bound)) heard.steps.push({ from: sent, best, bound });
    const summary = goal.state === "planned" ? "Looking for alternatives" : best !== null ? `Best plan so far: ${seconds(best)}` : "No plan yet";
    return el(
      "div",
      { class: "note", "data-testid": "planning" },
      el("b", {}, summary),
      quiet(` after ${roughly(elapsed)}, ${engine}`),
      best !== null ? el("div", { class: "small" }, gap(best, bound)) : null,
      heard.steps.length ? chart(heard.steps, elapsed) : null,
    );
  };
}

/** The best plan as a falling line, the bound as a rising one; the optimum lies between. @param {Step[]} steps @param {number} elapsed */
function chart(steps, elapsed) {
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
