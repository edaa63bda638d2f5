// What was tried to recover a mission, and what it waits for.

import { el } from "./dom.js";
import { words } from "./format.js";

const STEPS = {
  planning: "a repair is being planned",
  deciding: "the repaired plan above waits for your decision",
  waiting: "a repair waits for other missions",
  stuck: "no repair was found: correct what is believed and try again, or cancel",
};

export function recovery(mission) {
  const attempts = mission.recovery?.attempts ?? [];
  if (!attempts.length && !mission.recovery?.step) return null;
  const step = STEPS[mission.recovery.step];
  return el(
    "div",
    { class: "note", "data-testid": "recovery" },
    step ? el("p", {}, step) : null,
    el("ol", { class: "links" }, attempts.map((attempt) => el("li", { value: attempt.number }, line(attempt)))),
  );
}

function line({ failure, reason, measure, without, outcome, detail }) {
  const others = without?.length ? ` without ${without.join(", ")}` : "";
  return `${words(failure)}: ${reason}. ${measure ? `${words(measure)}${others}, ` : ""}${words(outcome)}${detail ? ` (${detail})` : ""}`;
}
