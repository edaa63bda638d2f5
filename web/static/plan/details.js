// Why a plan is as it is, what robots have bid for its legs, and its causal links; loaded once an operator opens one of them.

import { el, quiet } from "../page/dom.js";
import { fact, seconds, words } from "../page/format.js";
import { percent } from "./percent.js";

const MAX_WAITS = 5;

/** @param {Plan} plan */
export function robots({ recruitment = {}, tender }) {
  return el("div", {}, el("dl", {}, Object.entries(recruitment).map(([robot, reason]) => [el("dt", {}, robot), el("dd", {}, reason)])), tender ? bids(tender) : null);
}

/** @param {Tender} tender */
function bids(tender) {
  return [tender.reason ? el("p", { class: "note" }, `Planned without awards: ${tender.reason}`) : null, el("dl", {}, tender.legs.map(leg))];
}

/** @param {TenderLeg} leg */
function leg({ id, goal, team, why, parts, is_planned: isPlanned }) {
  const awarded = team.length ? `awarded to ${team.join(" and ")}${isPlanned === false ? ", which the plan does not keep to" : ""}` : "awarded to nobody";
  return [
    el("dt", {}, `${id}, ${fact(goal)}: ${awarded}`),
    why ? el("dd", {}, why) : null,
    parts.map((part) => el("dd", { class: "small" }, `${part.tags.join(", ")}:`, el("ul", { class: "links" }, part.bids.map((bid) => el("li", {}, offer(bid)))))),
  ];
}

/** @param {TenderBid} bid */
function offer({ robot, state, offer: made, reason }) {
  const figures = made ? ` ${seconds(made.cost_s)} (free in ${seconds(made.release_s)}, way ${seconds(made.way_s)}, work ${seconds(made.work_s)}), battery ${Math.round(made.battery * 100)} % after it` : "";
  return `${robot} ${words(state)}${figures}${reason ? `: ${reason}` : ""}`;
}

/** When each goal is likely achieved, the least likely on time first. @param {PlanForecast} forecast */
export function likelyTimes({ goals }) {
  const ranked = [...goals].sort((one, other) => (one.on_time ?? 2) - (other.on_time ?? 2) || other.p90_s - one.p90_s);
  return el(
    "table",
    { class: "actions", "data-testid": "likely-times" },
    el("thead", {}, el("tr", {}, ["goal", "10 %", "50 %", "90 %", "due", "on time"].map((name) => el("th", { scope: "col" }, name)))),
    el("tbody", {}, ranked.map((one) => el(
      "tr",
      {},
      el("td", {}, el("code", {}, fact(one.goal))),
      [one.p10_s, one.p50_s, one.p90_s, one.deadline_s].map((value) => el("td", { class: "number" }, seconds(value))),
      el("td", { class: "number" }, one.on_time === null ? "–" : percent(one.on_time)),
    ))),
  );
}

/** @param {Plan} plan */
export function links({ causal_links: all = [] }) {
  return el(
    "ul",
    { class: "links" },
    all.map((link) => el("li", {}, quiet(link.producer), " → ", el("code", {}, fact(link.fact)), " → ", quiet(link.consumer))),
  );
}

/** @param {PlanExplanation} explained */
export function reasons({ makespan, waits, constraints, robots: recruited, actions }) {
  return el(
    "dl",
    {},
    el("dt", {}, "What determines the duration"),
    [...makespan, ...waits.slice(0, MAX_WAITS).map((wait) => wait.words)].map((text) => el("dd", {}, text)),
    constraints.map((cost) => [el("dt", {}, cost.constraint), el("dd", {}, cost.words)]),
    Object.entries(recruited).map(([robot, text]) => [el("dt", {}, robot), el("dd", {}, text)]),
    actions.map((action) => [
      el("dt", {}, action.action),
      [...action.because.slice(0, 1), ...Object.entries(action.robots).map((pair) => pair.join(": ")), ...action.order].map((text) => el("dd", {}, text)),
    ]),
  );
}
