// A mission's recovery attempts, what it waits for, and what happens at its next failure.

import { id, put } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { words } from "../page/format.js";
import { problemBox } from "../page/problem.js";

const POLICIES = {
  ask: "ask me about repairs",
  auto: "approve repairs at once",
  never: "end the mission",
};

/** @type {Record<string, string>} */
const STEPS = {
  planning: "a repair is being planned",
  deciding: "the repaired plan below waits for your decision",
  waiting: "a repair waits for other missions",
  stuck: "no repair was found: correct what is believed and try again, or cancel",
};

/** @param {Mission} mission */
export function recovery({ recovery: state }) {
  if (!state || (!state.attempts.length && !state.step)) return null;
  const step = state.step && STEPS[state.step];
  return el(
    "div",
    { class: "note", "data-testid": "recovery" },
    step ? el("p", {}, step) : null,
    el("ol", { class: "links" }, state.attempts.map((attempt) => el("li", {}, attemptText(attempt)))),
  );
}

/** @param {RecoveryAttempt} attempt */
function attemptText({ number, failure, reason, measure, without, outcome, detail }) {
  const excluded = without?.length ? ` without ${without.join(", ")}` : "";
  return `${number}. ${failure ? words(failure) : "on request"}: ${reason}. ${measure ? `${words(measure)}${excluded}, ` : ""}${words(outcome)}${detail ? ` (${detail})` : ""}`;
}

/** @param {Mission} mission @param {Element} problem @param {() => void} refresh */
export function policyChoice(mission, problem, refresh) {
  const set = async () => {
    try {
      await put(`/v1/missions/${id(mission.id)}/recovery`, { policy: choice.value });
    } catch (error) {
      show(problem, problemBox(error));
    }
    refresh();
  };
  const options = Object.entries(POLICIES).map(([value, text]) => el("option", { value, selected: value === mission.recovery?.policy }, text));
  const choice = el("select", { "data-testid": "mission-policy", onchange: set }, options);
  return el("label", { class: "policy small" }, "If it fails: ", choice);
}
