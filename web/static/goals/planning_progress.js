// A goal's planning progress: the engine, the best plan so far, the proven bound, and both over time.

import { el } from "../page/dom.js";
import { gap, roughly, seconds } from "../page/format.js";

/** @type {typeof import("./planning_chart.js") | undefined} */
let drawing;

/** Returns a function that draws a goal's progress and keeps its history between calls. */
export function createPlanningProgress(now = () => performance.now() / 1000) {
  let heard = { goal: "", message: "", at: 0, steps: /** @type {import("./planning_chart.js").Step[]} */ ([]) };
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
      el("span", { class: "quiet" }, ` after ${roughly(elapsed)}, ${engine}`),
      best !== null ? el("div", { class: "small" }, gap(best, bound)) : null,
      heard.steps.length ? chart(heard.steps, elapsed) : null,
    );
  };
}

/** Fetched when there is first a plan to draw. @param {import("./planning_chart.js").Step[]} steps @param {number} elapsed */
function chart(steps, elapsed) {
  if (drawing) return drawing.chart(steps, elapsed);
  const place = el("div");
  import("./planning_chart.js").then((module) => {
    drawing = module;
    place.replaceWith(module.chart(steps, elapsed));
  });
  return place;
}
