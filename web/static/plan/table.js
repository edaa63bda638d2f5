// A plan's actions as a table, in the order of their starts.

import { el } from "../page/dom.js";
import { byNumber, seconds } from "../page/format.js";

const COLUMNS = ["id", "robot", "action", "starts", "at latest", "takes", "slack"];

/** @param {Plan} plan @param {PlanChanges} changes */
export function actionTable(plan, changes) {
  const actions = [...plan.actions].sort((one, other) => one.earliest_start_s - other.earliest_start_s || byNumber(one.id, other.id));
  return el(
    "table",
    { class: "actions", "data-testid": "action-table" },
    el("thead", {}, el("tr", {}, COLUMNS.map((name) => el("th", { scope: "col" }, name)))),
    el("tbody", {}, actions.map((action) => el(
      "tr",
      { class: action.critical ? "critical" : null, title: action.critical ? "on the critical path: a delay here delays the plan's end" : null },
      el("td", { class: "quiet" }, action.id),
      el("td", {}, action.agents.join(", ")),
      el("td", {}, el("b", {}, action.tag), el("div", { class: "quiet small" }, [action.description, changes.byAction.get(action.id)?.words].filter(Boolean).join(": "))),
      [action.earliest_start_s, action.latest_start_s, action.duration_s, action.slack_s].map((value) => el("td", { class: "number" }, seconds(value))),
    ))),
  );
}
