// The decision on a proposed plan: approve or reject it, with a comment, or look for alternatives first.

import { Problem, id, post } from "../page/api.js";
import { closest, el, show } from "../page/dom.js";
import { part } from "../page/part.js";
import { attempt, commandButton, problemBox } from "../page/problem.js";

const fetchDialog = part(() => import("./confirmation.js"));

/** @param {Plan} plan @param {State} state @param {() => void} refresh @param {Child} comparison of it with alternatives */
export function decision(plan, state, refresh, comparison) {
  const written = document.querySelector(`[data-keep="comment ${CSS.escape(plan.id)}"]`);
  const comment = el("input", { value: written instanceof HTMLInputElement ? written.value : null, "data-keep": `comment ${plan.id}`, placeholder: "comment", maxlength: 500, "data-testid": "plan-comment", "aria-label": "Comment" });
  const box = el("div", { role: "alert" });
  const approve = el("button", { class: "primary", "data-testid": "plan-approve", "aria-keyshortcuts": "a", title: "Approve (a)", onclick: () => confirmFirst() }, "Approve …");
  const reject = el("button", { "data-testid": "plan-reject", "aria-keyshortcuts": "r", title: "Reject (r)", onclick: rejectWithComment }, "Reject");

  const confirmFirst = () => attempt([], box, async () => {
    const { confirm } = await fetchDialog();
    if (!document.querySelector("dialog[open]")) confirm(plan, (delegate) => send("approve", { delegate }));
  });

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
  return [el("div", { class: "decision" }, el("div", { class: "row" }, comment, approve, reject), overtaken, box), alternatives(state, refresh, comparison)];
}

/** Have alternative plans searched for, and compare them. @param {State} state @param {() => void} refresh @param {Child} comparison */
function alternatives({ goal, alternatives: plans }, refresh, comparison) {
  if (goal?.state !== "planned") return null;
  const search = goal.alternatives;
  const isSearching = search?.state === "seeking";
  const box = el("div", { role: "alert" });
  const label = !isSearching ? "Find alternatives" : search.edited ? "Planning the change …" : "Looking for alternatives …";
  const button = commandButton(label, `/v1/goals/${id(goal.id)}:alternatives`, box, refresh, { disabled: isSearching, "data-testid": "seek-alternatives" });
  return el(
    "div",
    { class: "alternatives" },
    comparison,
    search && !isSearching && (search.reason || plans.length < 2) ? el("p", { class: "quiet small", "data-testid": "search-reason" }, search.reason || "No plan differs from this one and is better at anything.") : null,
    button,
    box,
  );
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
