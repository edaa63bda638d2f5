// Plans to choose from: have alternatives found, see them side by side, look at one.

import { id, post } from "./api.js";
import { el, show } from "./dom.js";
import { seconds } from "./format.js";
import { problemBox } from "./problem.js";

export function choices(goal, plan, plans, { look, refresh }) {
  if (goal?.state !== "planned" || plan.state !== "proposed") return null;
  const search = goal.alternatives;
  const seeking = search?.state === "seeking";
  const box = el("div", { role: "alert" });
  const button = el(
    "button",
    { type: "button", disabled: seeking, "data-testid": "seek-alternatives", onclick: seek },
    seeking ? "Looking for alternatives …" : "Find alternatives",
  );
  async function seek() {
    button.disabled = true;
    show(box);
    try {
      await post(`/v1/goals/${id(goal.id)}:alternatives`);
    } catch (problem) {
      show(box, problemBox(problem));
      button.disabled = false;
    }
    refresh();
  }
  return el(
    "div",
    { class: "alternatives" },
    plans.length > 1 ? comparison(plan, plans, look) : null,
    search && !seeking && plans.length < 2 ? el("p", { class: "quiet small" }, search.reason || "No plan differs from this one and is better at anything.") : null,
    button,
    box,
  );
}

function comparison(plan, plans, look) {
  const head = ["best at", "takes", "drives", "uses", "to clear", "robots"];
  return el(
    "table",
    { class: "actions beside", "data-testid": "alternatives" },
    el("thead", {}, el("tr", {}, head.map((name) => el("th", {}, name)))),
    el("tbody", {}, plans.map((one) => el(
      "tr",
      { class: one.id === plan.id ? "chosen" : null },
      el("td", {}, el("button", { type: "button", class: "choice", "aria-pressed": one.id === plan.id ? "true" : "false", onclick: () => look(one.id) }, one.label || "the plan"), el("div", { class: "quiet small" }, [one.robots.join(", "), one.comparison].filter(Boolean).join(": "))),
      [seconds(one.makespan_s), `${one.distance_m.toFixed(1)} m`, `${Math.round(one.energy_j)} J`, one.clearances].map((figure) => el("td", { class: "number" }, String(figure))),
      el("td", { class: "number" }, String(one.robots.length)),
    ))),
  );
}
