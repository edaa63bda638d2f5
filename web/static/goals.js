// The left column: state a goal, see the goals and missions.

import { post } from "./api.js";
import { el, show } from "./dom.js";
import { facts, standing, tone, words } from "./format.js";
import { problemBox } from "./problem.js";

export function mountGoals(store, { select, refresh }) {
  const form = document.getElementById("goal-form");
  const text = document.getElementById("goal-text");
  const box = document.getElementById("goal-problem");

  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const button = form.querySelector("button");
    button.disabled = true;
    show(box);
    try {
      const goal = await post("/v1/goals", { world: store.get().world, text: text.value, ...wishes(form) });
      form.reset();
      select(goal.id);
      refresh();
    } catch (problem) {
      // A choice replaces the word it stands for, or completes the sentence; the operator sends it.
      show(box, problemBox(problem, (choice) => {
        text.value = completed(text.value, choice);
        text.focus();
      }));
    } finally {
      button.disabled = false;
    }
  });

  const [goals, missions] = [document.getElementById("goals"), document.getElementById("missions")];
  for (const items of [goals, missions]) {
    items.addEventListener("click", (event) => {
      const item = event.target.closest("[data-goal]");
      if (item) select(item.dataset.goal);
    });
  }
  store.subscribe((state) => {
    show(goals, newestFirst(state.goals).map((goal) => goalItem(goal, state)));
    show(missions, missionItems(state));
  });
}

// What the operator wishes of the planning beside the goal; what is left empty is left to the service.
function wishes(form) {
  const given = [...form.elements].filter((field) => field.name && field.value !== "");
  return Object.fromEntries(given.map((field) => [field.name, field.type === "number" ? field.valueAsNumber : field.value]));
}

// The sentence with the choice in the place of the word it stands for, else as its destination.
export function completed(sentence, choice) {
  const tokens = sentence.trim().split(/\s+/).filter(Boolean);
  const isPreposition = (token) => /^(to|in|into|at|from)$/i.test(token);
  const stem = choice.slice(0, 3).toLowerCase();
  const at = tokens.findLastIndex((token) => !isPreposition(token) && token.toLowerCase().startsWith(stem));
  if (at >= 0) tokens[at] = choice;
  else tokens.push(...(isPreposition(tokens.at(-1) ?? "") ? [choice] : ["to", choice]));
  return tokens.join(" ");
}

function goalItem(goal, state) {
  return el(
    "li",
    {},
    el(
      "button",
      {
        type: "button",
        class: goal.id === state.selected ? "item chosen" : "item",
        "data-testid": "goal-item",
        "data-goal": goal.id,
        "aria-pressed": goal.id === state.selected ? "true" : "false",
      },
      el("span", { class: "item-text" }, goal.text || facts(goal.goal)),
      el("span", { class: `badge ${tone(standing(goal))}` }, words(standing(goal))),
      goal.reason ? el("span", { class: "quiet small whole" }, goal.reason) : null,
    ),
  );
}

function missionItems(state) {
  const goals = new Map(state.goals.map((goal) => [goal.id, goal]));
  return newestFirst(state.missions).map((mission) =>
    el(
      "li",
      {},
      el(
        "button",
        { type: "button", class: "item", "data-goal": mission.goal_id, "data-testid": "mission-item" },
        el("span", { class: "item-text" }, goals.get(mission.goal_id)?.text || mission.id),
        el("span", { class: `badge ${tone(mission.state)}` }, words(mission.state)),
      ),
    ),
  );
}

function newestFirst(list) {
  return [...list].sort((one, other) => String(other.created_at ?? "").localeCompare(String(one.created_at ?? "")));
}
