// The composition of the page: fetches, follows the events, and lets the parts draw.

import { get, id, list } from "./api.js";
import { el, show } from "./dom.js";
import { seconds } from "./format.js";
import { mountGoal } from "./goal.js";
import { mountGoals } from "./goals.js";
import { follow } from "./live.js";
import { mountMission } from "./mission.js";
import { mountPlan } from "./plan.js";
import { createState, gathered } from "./state.js";
import { mountWorld } from "./world.js";

const CLOCK_MS = 1000;

const store = createState({
  world: null,
  worlds: [],
  worldTimes: {},
  goals: [],
  missions: [],
  robots: [],
  selected: null,
  look: null, // the plan an operator looks at, where there are several to choose from
  plan: null,
  choices: [],
  mission: null,
});

// The token in the address has become a cookie by now; it should not stay where shoulders and histories see it.
if (new URLSearchParams(location.search).has("token")) history.replaceState(null, "", location.pathname);

// Live means both: the stream of events is open, and the last question was answered.
const health = { stream: false, answers: true };
const refresh = gathered(() => asked(load));
const select = (goalId) => {
  store.update({ selected: goalId, look: null, plan: null, choices: [], mission: null });
  refresh();
};
const look = (planId) => {
  store.update({ look: planId });
  refresh();
};

async function asked(question) {
  try {
    await question();
    badge({ answers: true });
  } catch (problem) {
    badge({ answers: false }, problem.message);
  }
}

async function load() {
  const [goals, missions, robots] = await Promise.all([list("/v1/goals"), list("/v1/missions"), list("/v1/robots")]);
  const selected = store.get().selected ?? newest(goals)?.id ?? null;
  const goal = goals.find((candidate) => candidate.id === selected);
  // A mission of the same goal may be followed by another after a replan: the latest counts.
  const missionId = goal?.mission_id ?? newest(missions.filter((mission) => mission.goal_id === selected))?.id;
  const choices = goal?.alternatives ? await list(`/v1/goals/${id(goal.id)}/plans`) : [];
  const looked = choices.find((choice) => choice.id === store.get().look)?.id ?? goal?.plan_id;
  const [plan, mission] = await Promise.all([
    looked ? get(`/v1/plans/${id(looked)}`) : null,
    missionId ? get(`/v1/missions/${id(missionId)}`) : null,
  ]);
  if ((store.get().selected ?? selected) !== selected) return; // another goal was chosen meanwhile
  store.update({ goals, missions, robots, selected, plan, choices, mission });
}

function newest(items) {
  return items.reduce((best, item) => (best === null || String(item.created_at ?? "") >= String(best.created_at ?? "") ? item : best), null);
}

async function loadWorlds() {
  const worlds = await list("/v1/worlds");
  const worldTimes = Object.fromEntries(worlds.map((world) => [world.id, world.time_s]));
  store.update({ worlds, worldTimes, world: store.get().world ?? worlds[0]?.id ?? null });
}

function badge(change, reason = "") {
  Object.assign(health, change);
  const live = health.stream && health.answers;
  const node = document.getElementById("live");
  node.textContent = live ? "live" : "not live";
  node.className = live ? "badge good" : "badge bad";
  node.title = live ? "Changes are shown as they happen" : reason || "The connection to the service is lost; trying again";
}

function mountWorldChoice() {
  const choice = document.getElementById("world");
  choice.addEventListener("change", () => store.update({ world: choice.value }));
  store.subscribe((state) => {
    show(choice, state.worlds.map((world) => el("option", { value: world.id }, world.title || world.name)));
    if (state.world !== null) choice.value = state.world;
    document.getElementById("world-time").textContent = seconds(state.worldTimes[state.world]);
  });
}

mountWorldChoice();
mountGoals(store, { select, refresh });
mountGoal(store, { refresh });
mountPlan(store, { look, refresh });
mountMission(store, { refresh });
mountWorld(store);
follow("/v1/events", {
  onEvent: refresh,
  onState: (stream) => {
    badge({ stream });
    if (stream) refresh();
  },
});
const tick = () => document.hidden || asked(loadWorlds);
tick();
setInterval(tick, CLOCK_MS);
