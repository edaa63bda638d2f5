// The dialog that confirms an approval: which robots will move, and what they may decide themselves. Loaded when it is asked for.

import { el, quiet } from "../page/dom.js";
import { seconds } from "../page/format.js";

const MAX_TAGS = 6;

/** @param {Plan} plan @param {(delegate: boolean) => void} onApproved */
export function confirm(plan, onApproved) {
  const delegate = el("input", { type: "checkbox", "data-testid": "plan-delegate" });
  const go = el("button", { type: "submit", class: "primary", value: "go", "data-testid": "plan-confirm" }, `Approve: ${plan.robots.join(", ")} will move`);
  const dialog = el(
    "dialog",
    { "aria-labelledby": "confirm-title", "data-testid": "plan-dialog" },
    el(
      "form",
      { method: "dialog" },
      el("h2", { id: "confirm-title" }, plan.robots.length === 1 ? "This robot will move" : `These ${plan.robots.length} robots will move`),
      el("ul", { class: "movers" }, plan.robots.map((robot) => el("li", {}, el("b", {}, robot), " ", quiet(actionTags(plan, robot))))),
      el("p", { class: "quiet small" }, `The mission is expected to take ${seconds(plan.makespan_s)}. Robots go on by themselves when out of contact.`),
      el("label", { class: "small" }, delegate, " A robot out of contact may have another do what it fails at"),
      el("div", { class: "row" }, el("button", { type: "submit", value: "no", formnovalidate: true }, "Not yet"), go),
    ),
  );
  dialog.addEventListener("close", () => {
    dialog.remove();
    if (dialog.returnValue === "go") onApproved(delegate.checked);
  });
  document.body.append(dialog);
  dialog.showModal();
  go.focus();
}

/** @param {Plan} plan @param {string} robot */
function actionTags(plan, robot) {
  const actions = plan.actions.filter((action) => action.agents.includes(robot));
  const tags = actions.sort((one, other) => one.earliest_start_s - other.earliest_start_s).map((action) => action.tag);
  return tags.length > MAX_TAGS ? `${tags.slice(0, MAX_TAGS - 1).join(", ")} and ${tags.length - MAX_TAGS + 1} more` : tags.join(", ");
}
