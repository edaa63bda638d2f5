// Approve or reject a plan, with a comment; approval is confirmed in a dialog that names the robots that will move.

import { Problem, id, post } from "../page/api.js";
import { closest, el, show } from "../page/dom.js";
import { seconds } from "../page/format.js";
import { attempt, problemBox } from "../page/problem.js";

const MAX_TAGS = 6;

/** @param {Plan} plan @param {() => void} refresh */
export function decision(plan, refresh) {
  const written = document.querySelector(`[data-keep="comment ${CSS.escape(plan.id)}"]`);
  const comment = el("input", { value: written instanceof HTMLInputElement ? written.value : null, "data-keep": `comment ${plan.id}`, placeholder: "comment", maxlength: 500, "data-testid": "plan-comment", "aria-label": "Comment" });
  const box = el("div", { role: "alert" });
  const approve = el("button", { type: "button", class: "primary", "data-testid": "plan-approve", "aria-keyshortcuts": "a", title: "Approve (a)", onclick: () => confirm(plan, (delegate) => send("approve", { delegate })) }, "Approve …");
  const reject = el("button", { type: "button", "data-testid": "plan-reject", "aria-keyshortcuts": "r", title: "Reject (r)", onclick: rejectWithComment }, "Reject");

  function rejectWithComment() {
    if (comment.value.trim() === "") {
      show(box, problemBox(new Problem({ detail: "Say in the comment why you reject the plan." })));
      comment.focus();
    } else send("reject");
  }

  /** @param {string} verb @param {{delegate?: boolean}} more */
  async function send(verb, more = {}) {
    await attempt([approve, reject], box, () => post(`/v1/plans/${id(plan.id)}:${verb}`, { comment: comment.value, ...more }));
    refresh();
  }

  const overtaken = plan.overtaken?.length
    ? el("div", { class: "problem", "data-testid": "overtaken" }, el("strong", {}, "The world has changed under this plan. Approving it has it repaired."), el("ul", { class: "links" }, plan.overtaken.map((change) => el("li", {}, change))))
    : null;
  return el("div", { class: "decision" }, el("div", { class: "row" }, comment, approve, reject), overtaken, box);
}

/** `a` and `r` decide, except while something is being typed. */
export function mountDecisionKeys() {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    if (!["a", "r"].includes(event.key) || closest(event, "input, select, textarea, [contenteditable]")) return;
    const button = document.querySelector(event.key === "a" ? "[data-testid=plan-approve]" : "[data-testid=plan-reject]");
    if (!(button instanceof HTMLButtonElement) || button.disabled) return;
    event.preventDefault();
    button.click();
  });
}

/** @param {Plan} plan @param {(delegate: boolean) => void} onApproved */
function confirm(plan, onApproved) {
  const delegate = el("input", { type: "checkbox", "data-testid": "plan-delegate" });
  const go = el("button", { class: "primary", value: "go", "data-testid": "plan-confirm" }, `Approve: ${plan.robots.join(", ")} will move`);
  const dialog = el(
    "dialog",
    { "aria-labelledby": "confirm-title", "data-testid": "plan-dialog" },
    el(
      "form",
      { method: "dialog" },
      el("h2", { id: "confirm-title" }, plan.robots.length === 1 ? "This robot will move" : `These ${plan.robots.length} robots will move`),
      el("ul", { class: "movers" }, plan.robots.map((robot) => el("li", {}, el("b", {}, robot), " ", el("span", { class: "quiet" }, actionTags(plan, robot))))),
      el("p", { class: "quiet small" }, `The mission is expected to take ${seconds(plan.makespan_s)}. Robots go on by themselves when out of contact.`),
      el("label", { class: "small" }, delegate, " A robot out of contact may have another do what it fails at"),
      el("div", { class: "row" }, el("button", { value: "no", formnovalidate: true }, "Not yet"), go),
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
