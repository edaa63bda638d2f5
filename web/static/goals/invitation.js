// What a new operator does first, while there is no goal.

import { byId, el } from "../page/dom.js";

const STEPS = [
  ["State a goal", "A sentence such as “move sample_1 to bay_7”; the page says what is missing as you type. Or pick a sample and a place on the map."],
  ["Review the plan", "It is drawn here: who does what when, and why these robots."],
  ["Approve it", "No robot moves before that."],
  ["Watch the mission", "What happens is drawn beneath what was planned. What needs a decision stands at the top of the page."],
];

/** @param {Store} store */
export function mountInvitation(store) {
  const container = byId("invitation", HTMLElement);
  const invitation = el(
    "div",
    { class: "empty", "data-testid": "invitation" },
    el("h2", {}, "No goal yet"),
    el("ol", {}, STEPS.map(([step, about]) => el("li", {}, el("b", {}, step), el("div", { class: "quiet" }, about)))),
    el("button", { class: "primary", onclick: () => byId("goal-text", HTMLElement).focus() }, "State a goal"),
  );
  store.subscribe(({ goal }) => {
    if (goal !== null) invitation.remove();
    else if (!invitation.isConnected) container.append(invitation);
  });
}
