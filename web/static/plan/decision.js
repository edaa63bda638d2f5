// Approve or reject a plan, with a comment; approving asks once more, naming the robots that will move.

import { id, post } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { seconds } from "../page/format.js";
import { asking, problemBox } from "../page/problem.js";

export function decision(plan, refresh) {
  const written = document.querySelector(`[data-keep="comment ${CSS.escape(plan.id)}"]`)?.value;
  const comment = el("input", { value: written, "data-keep": `comment ${plan.id}`, placeholder: "comment", maxlength: 500, "data-testid": "plan-comment", "aria-label": "Comment" });
  const box = el("div", { role: "alert" });
  const approve = el("button", { type: "button", class: "primary", "data-testid": "plan-approve", "aria-keyshortcuts": "a", title: "Approve (a)", onclick: () => confirm(plan, () => decide("approve")) }, "Approve …");
  const reject = el("button", { type: "button", "data-testid": "plan-reject", "aria-keyshortcuts": "r", title: "Reject (r)", onclick: refuse }, "Reject");

  function refuse() {
    if (comment.value.trim() === "") {
      show(box, problemBox({ message: "Say in the comment why the plan will not do." }));
      comment.focus();
      return;
    }
    decide("reject");
  }

  async function decide(verb) {
    await asking([approve, reject], box, () => post(`/v1/plans/${id(plan.id)}:${verb}`, { comment: comment.value }));
    refresh();
  }

  const overtaken = plan.overtaken?.length
    ? el("div", { class: "problem", "data-testid": "overtaken" }, el("strong", {}, "The world has changed under this plan. Approving it has it repaired."), el("ul", { class: "links" }, plan.overtaken.map((change) => el("li", {}, change))))
    : null;
  return el("div", { class: "decision", "data-decision": plan.id }, el("div", { class: "row" }, comment, approve, reject), overtaken, box);
}

// `a` and `r` anywhere but where something is being written.
export function mountDecisionKeys() {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    if (event.target.closest("input, select, textarea, [contenteditable]")) return;
    const button = document.querySelector({ a: "[data-testid=plan-approve]", r: "[data-testid=plan-reject]" }[event.key] ?? "none");
    if (!button || button.disabled) return;
    event.preventDefault();
    button.click();
  });
}

function confirm(plan, approved) {
  const go = el("button", { class: "primary", value: "go", "data-testid": "plan-confirm" }, `Approve: ${plan.robots.join(", ")} will move`);
  const dialog = el(
    "dialog",
    { "aria-labelledby": "confirm-title", "data-testid": "plan-dialog" },
    el(
      "form",
      { method: "dialog" },
      el("h2", { id: "confirm-title" }, plan.robots.length === 1 ? "This robot will move" : `These ${plan.robots.length} robots will move`),
      el("ul", { class: "movers" }, plan.robots.map((robot) => el("li", {}, el("b", {}, robot), " ", el("span", { class: "quiet" }, course(plan, robot))))),
      el("p", { class: "quiet small" }, `The mission is expected to take ${seconds(plan.makespan_s)}. Robots go on by themselves when out of contact.`),
      el("div", { class: "row" }, el("button", { value: "no", formnovalidate: true }, "Not yet"), go),
    ),
  );
  dialog.addEventListener("close", () => {
    dialog.remove();
    if (dialog.returnValue === "go") approved();
  });
  document.body.append(dialog);
  dialog.showModal();
  go.focus();
}

function course(plan, robot) {
  const mine = plan.actions.filter((action) => action.agents.includes(robot)).sort((one, other) => one.earliest_start_s - other.earliest_start_s);
  const tags = mine.map((action) => action.tag);
  return tags.length > 6 ? `${tags.slice(0, 5).join(", ")} and ${tags.length - 5} more` : tags.join(", ");
}
