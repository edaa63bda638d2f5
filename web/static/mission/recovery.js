// What was tried to recover a mission, what it waits for, and what is to become of its next failure.

import { id, put } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { words } from "../page/format.js";
import { problemBox } from "../page/problem.js";

const POLICIES = {
  ask: "ask me about repairs",
  auto: "approve repairs at once",
  never: "end the mission",
};

const STEPS = {
  planning: "a repair is being planned",
  deciding: "the repaired plan below waits for your decision",
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
    el("ol", { class: "links" }, attempts.map((attempt) => el("li", {}, line(attempt)))),
  );
}

function line({ number, failure, reason, measure, without, outcome, detail }) {
  const others = without?.length ? ` without ${without.join(", ")}` : "";
  return `${number}. ${words(failure)}: ${reason}. ${measure ? `${words(measure)}${others}, ` : ""}${words(outcome)}${detail ? ` (${detail})` : ""}`;
}

export function policy(mission, problem, refresh) {
  const set = async (event) => {
    try {
      await put(`/v1/missions/${id(mission.id)}/recovery`, { policy: event.target.value });
    } catch (error) {
      show(problem, problemBox(error));
    }
    refresh();
  };
  const chosen = mission.recovery?.policy;
  const options = Object.entries(POLICIES).map(([value, text]) => el("option", { value, selected: value === chosen }, text));
  return el("label", { class: "policy small" }, "If it fails: ", el("select", { "data-testid": "mission-policy", onchange: set }, options));
}
