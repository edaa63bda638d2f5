// A plan's actions as a table, for those who prefer it to the picture.

import { el } from "../page/dom.js";
import { seconds } from "../page/format.js";

const HEAD = ["id", "robot", "action", "starts", "at latest", "takes", "slack"];

export function actionTable(plan, changes) {
  const order = [...plan.actions].sort((one, other) => one.earliest_start_s - other.earliest_start_s || one.id.localeCompare(other.id));
  return el(
    "table",
    { class: "actions", "data-testid": "action-table" },
    el("thead", {}, el("tr", {}, HEAD.map((name) => el("th", { scope: "col" }, name)))),
    el("tbody", {}, order.map((action) => el(
      "tr",
      { class: action.critical ? "critical" : null, title: action.critical ? "on the critical path: the plan ends later if it does" : null },
      el("td", { class: "quiet" }, action.id),
      el("td", {}, action.agents.join(", ")),
      el("td", {}, el("b", {}, action.tag), el("div", { class: "quiet small" }, [action.description, changes.of.get(action.id)?.words].filter(Boolean).join(": "))),
      [action.earliest_start_s, action.latest_start_s, action.duration_s, action.slack_s].map((value) => el("td", { class: "number" }, seconds(value))),
    ))),
  );
}
