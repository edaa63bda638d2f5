// The constraints of a goal that stand in the way of a plan.

import { el } from "../page/dom.js";

/** Which constraints stand in the way of a plan together. @param {Conflict} conflict */
export function conflictNote({ constraints, proven, complete }) {
  const those = constraints.length === 1 ? "this constraint" : "these constraints together";
  const said = proven ? `No plan keeps ${those}` : `No plan that keeps ${those} was found in time`;
  const hint = complete ? (constraints.length === 1 ? ", without it there is one" : ", without any one of them there is one") : "; there was no time to look for fewer";
  return el("div", { class: "note", "data-testid": "goal-conflict" }, `${said}${hint}:`, el("ul", {}, constraints.map((one) => el("li", {}, one))));
}
