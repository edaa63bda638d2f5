// The middle column's plan: what would happen, when, how good that is, why by these robots; approve or reject.

import { id, post } from "./api.js";
import { choices } from "./choices.js";
import { el, replace, show } from "./dom.js";
import { fact, gap, seconds, tone, words } from "./format.js";
import { lanes } from "./lanes.js";
import { problemBox } from "./problem.js";
import { repair } from "./repair.js";
import { why } from "./why.js";

export function mountPlan(store, { look, refresh }) {
  const body = document.getElementById("plan");
  let drawn = null;
  store.subscribe((state) => {
    const goal = state.goals.find((candidate) => candidate.id === state.selected);
    const key = JSON.stringify([goal?.state, goal?.alternatives, state.plan, state.choices]);
    if (key === drawn) return; // a comment being written survives other news
    drawn = key;
    replace(body, state.plan ? planCard(state.plan, refresh, choices(goal, state.plan, state.choices, { look, refresh })) : null);
  });
}

function planCard(plan, refresh, alternatives) {
  return el(
    "article",
    { class: "card", "data-testid": "plan" },
    el(
      "div",
      { class: "head" },
      el("h3", {}, `Plan: ${plan.actions.length} actions, ${seconds(plan.makespan_s)}`),
      el("span", { class: `badge ${tone(plan.state)}`, "data-testid": "plan-state" }, words(plan.state)),
    ),
    el("p", { class: "quiet small" }, provenance(plan)),
    figures(plan),
    late(plan),
    repair(plan),
    plan.label ? el("p", { class: "quiet small" }, [plan.label, plan.comparison].filter(Boolean).join(": ")) : null,
    plan.state === "proposed" ? decision(plan, refresh) : null,
    alternatives,
    plan.comment ? el("p", { class: "note" }, `“${plan.comment}”`) : null,
    lanes(plan),
    actionTable(plan),
    why(plan),
    recruitment(plan),
    linkList(plan),
  );
}

function provenance(plan) {
  return [plan.engine && `by ${plan.engine}`, typeof plan.planning_s === "number" && `in ${plan.planning_s.toFixed(2)} s`, plan.robots?.length && `with ${plan.robots.join(", ")}`]
    .filter(Boolean)
    .join(" ");
}

function figures(plan) {
  const told = [
    gap(plan.makespan_s, plan.lower_bound_s),
    plan.distance_m ? `${plan.distance_m.toFixed(1)} m to drive` : "",
    plan.energy_j ? `${Math.round(plan.energy_j)} J` : "",
    plan.clearances ? `${plan.clearances} ${plan.clearances === 1 ? "wait" : "waits"} to be cleared` : "",
  ].filter(Boolean);
  return told.length ? el("p", { class: "small", "data-testid": "figures" }, told.join(" · ")) : null;
}

function late(plan) {
  if (!plan.late?.length) return null;
  return el("ul", { class: "problem", "data-testid": "late" }, plan.late.map(({ goal, late_s }) => el("li", {}, `${fact(goal)} comes ${seconds(late_s)} after its deadline`)));
}

function decision(plan, refresh) {
  const comment = el("input", { placeholder: "comment (asked for when you reject)", maxlength: 500, "data-testid": "plan-comment", "aria-label": "Comment" });
  const box = el("div", { role: "alert" });
  const buttons = [
    el("button", { type: "button", class: "primary", "data-testid": "plan-approve", onclick: () => decide("approve") }, "Approve"),
    el("button", { type: "button", "data-testid": "plan-reject", onclick: () => decide("reject") }, "Reject"),
  ];
  async function decide(verb) {
    if (verb === "reject" && comment.value.trim() === "") {
      show(box, problemBox({ message: "Say in the comment why the plan will not do." }));
      comment.focus();
      return;
    }
    for (const button of buttons) button.disabled = true;
    show(box);
    try {
      await post(`/v1/plans/${id(plan.id)}:${verb}`, { comment: comment.value });
    } catch (problem) {
      show(box, problemBox(problem));
      for (const button of buttons) button.disabled = false;
    }
    refresh();
  }
  return el("div", { class: "decision" }, el("div", { class: "row" }, comment, buttons), box);
}

function actionTable(plan) {
  const order = [...plan.actions].sort((one, other) => one.earliest_start_s - other.earliest_start_s || one.id.localeCompare(other.id));
  const head = ["", "robot", "action", "starts", "at latest", "takes", "slack"];
  return el(
    "table",
    { class: "actions" },
    el("thead", {}, el("tr", {}, head.map((name) => el("th", {}, name)))),
    el("tbody", {}, order.map((action) => el(
      "tr",
      { class: action.critical ? "critical" : null, title: action.critical ? "on the critical path: the plan ends later if it does" : null },
      el("td", { class: "quiet" }, action.id),
      el("td", {}, action.agents.join(", ")),
      el("td", {}, el("b", {}, action.tag), el("div", { class: "quiet small" }, action.description ?? "")),
      [action.earliest_start_s, action.latest_start_s, action.duration_s, action.slack_s].map((value) => el("td", { class: "number" }, seconds(value))),
    ))),
  );
}

function recruitment(plan) {
  const reasons = Object.entries(plan.recruitment ?? {});
  if (!reasons.length) return null;
  return el(
    "details",
    {},
    el("summary", {}, "Why these robots"),
    el("dl", {}, reasons.map(([robot, reason]) => [el("dt", {}, robot), el("dd", {}, String(reason))])),
  );
}

function linkList(plan) {
  const links = plan.causal_links ?? [];
  if (!links.length) return null;
  return el(
    "details",
    { "data-testid": "causal-links" },
    el("summary", {}, `Causal links (${links.length})`),
    el("ul", { class: "links" }, links.map((link) => el(
      "li",
      {},
      el("span", { class: "quiet" }, link.producer),
      " → ",
      el("code", {}, fact(link.fact)),
      " → ",
      el("span", { class: "quiet" }, link.consumer),
    ))),
  );
}
