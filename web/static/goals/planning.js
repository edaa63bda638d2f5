// How the planning of a goal comes along: who plans, the best plan so far, the proven bound, and both over time.

import { el, svg } from "../page/dom.js";
import { gap, roughly, seconds } from "../page/format.js";

// Answers a function of the goal: what there is to show of its planning now. It remembers what it was told before.
export function createPlanning(now = () => performance.now() / 1000) {
  let heard = { goal: null, told: "", at: 0, steps: [] };
  return (goal) => {
    const told = JSON.stringify(goal.planning);
    if (heard.goal !== goal.id) heard = { goal: goal.id, told: "", at: now(), steps: [] };
    if (heard.told !== told) Object.assign(heard, { told, at: now() });
    if (!goal.planning) return el("p", { class: "note" }, "Waits for a planner …");
    const { engine, elapsed_s, makespan_s, lower_bound_s } = goal.planning;
    const elapsed = elapsed_s + now() - heard.at; // nothing is told while nothing changes but the time
    const last = heard.steps.at(-1);
    if (typeof makespan_s === "number" && (last?.best !== makespan_s || last.bound !== lower_bound_s)) heard.steps.push({ from: elapsed_s, best: makespan_s, bound: lower_bound_s });
    const isFound = typeof makespan_s === "number";
    const what = goal.state === "planned" ? "Looking for alternatives" : isFound ? `Best plan so far: ${seconds(makespan_s)}` : "No plan yet";
    return el(
      "div",
      { class: "note", "data-testid": "planning" },
      el("b", {}, what),
      el("span", { class: "quiet" }, ` after ${roughly(elapsed)}, ${engine}`),
      isFound ? el("div", { class: "small" }, gap(makespan_s, lower_bound_s)) : null,
      heard.steps.length ? chart(heard.steps, elapsed) : null,
    );
  };
}

// The best plan as a falling line, the bound as a rising one; what lies between is not proven.
function chart(steps, elapsed) {
  const most = Math.max(...steps.map(({ best }) => best));
  const least = Math.min(...steps.map(({ best, bound }) => bound ?? best));
  const x = (time) => (100 * time) / Math.max(elapsed, 0.1);
  const y = (makespan) => 2 + (26 * (most - makespan)) / Math.max(most - least, 0.1);
  const stairs = (of) => steps.map((step, at) => `H${x(step.from)} V${y(of(step))} H${x(steps[at + 1]?.from ?? elapsed)}`).join(" ");
  const path = (of, name) => svg("path", { d: `M${x(steps[0].from)},${y(of(steps[0]))} ${stairs(of)}`, class: name });
  const label = `From ${seconds(most)} to ${seconds(steps.at(-1).best)} in ${roughly(elapsed)}`;
  return svg("svg", { viewBox: "0 0 100 30", preserveAspectRatio: "none", class: "course", role: "img", "aria-label": label }, path(({ best }) => best, "best"), steps[0].bound ? path(({ best, bound }) => bound ?? best, "bound") : null);
}
