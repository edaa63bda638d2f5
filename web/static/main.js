// The composition of the page: fetches, follows the events, and lets the parts draw.

import { mountAlerts } from "./page/alerts.js";
import { list } from "./page/api.js";
import { el, show } from "./page/dom.js";
import { seconds } from "./page/format.js";
import { mountGoal } from "./goals/goal.js";
import { mountLists } from "./goals/list.js";
import { mountStatement } from "./goals/statement.js";
import { follow } from "./page/live.js";
import { createLoading } from "./page/loading.js";
import { mountPanes } from "./page/panes.js";
import { mountMission } from "./mission/mission.js";
import { mountPlan } from "./plan/plan.js";
import { createState } from "./page/state.js";
import { createTelemetry } from "./page/telemetry.js";
import { mountTheme } from "./page/theme.js";
import { mountPlayer } from "./replay/player.js";
import { mountRobots } from "./robots/list.js";
import { mountRobotPanel } from "./robots/panel.js";
import { mountDoor } from "./workbench/door.js";
import { mountUnknown } from "./world/unknown.js";
import { mountWorld } from "./world/world.js";

const CLOCK_MS = 1000;
const ROBOTS_TICKS = 3;

const store = createState({
  world: null,
  worlds: [],
  worldTimes: {},
  goals: [],
  missions: [],
  more: { goals: false, missions: false }, // there are older ones than are shown
  robots: [],
  unknown: [], // what is not known of the world that is looked at
  robot: null, // the one looked at closely
  sample: null, // the one picked, to be moved somewhere
  action: null, // of the plan, the one looked at
  follow: false, // the view's camera goes with the robot
  whole: 0, // counts how often the whole world was to be seen again
  replaying: null, // the mission whose recording is shown
  selected: null,
  goal: undefined, // the one selected, which may be older than those listed; null if there is none
  look: null, // the plan an operator looks at, where there are several to choose from
  plan: null,
  before: null, // the plan that it takes the place of
  choices: [],
  mission: null,
});

// The token in the address has become a cookie by now; it should not stay where shoulders and histories see it.
if (new URLSearchParams(location.search).has("token")) history.replaceState(null, "", location.pathname);

// Live means all: the stream of events is open, and the last question of each kind was answered.
let ticks = 0;
const health = { stream: false };
const loading = createLoading(store, asked);
const { refresh, refreshAll, older } = loading;
const select = (goalId) => {
  const goal = store.get().goals.find((one) => one.id === goalId);
  bench.close();
  store.update({ selected: goalId, goal, look: null, plan: null, choices: [], mission: null });
  refresh();
};
const look = (planId) => {
  store.update({ look: planId });
  refresh();
};

async function asked(kind, question) {
  try {
    await question();
    badge({ [kind]: true });
  } catch (problem) {
    badge({ [kind]: false }, problem.message);
  }
}

async function loadWorlds() {
  const worlds = await list("/v1/worlds");
  const worldTimes = Object.fromEntries(worlds.map((world) => [world.id, world.time_s]));
  const first = store.get().world === null;
  store.update({ worlds, worldTimes, world: store.get().world ?? worlds[0]?.id ?? null });
  if (first) loading.worldChanged();
}

function badge(change, reason = "") {
  Object.assign(health, change);
  const live = Object.values(health).every(Boolean);
  const node = document.getElementById("live");
  node.textContent = live ? "live" : "not live";
  node.className = live ? "badge good" : "badge bad";
  node.title = live ? "Changes are shown as they happen" : reason || "The connection to the service is lost; trying again";
}

function mountWorldChoice() {
  const choice = document.getElementById("world");
  choice.addEventListener("change", () => {
    store.update({ world: choice.value, robot: null, sample: null }); // which are of the one that is left
    refreshAll();
  });
  store.subscribe((state) => {
    show(choice, state.worlds.map((world) => el("option", { value: world.id }, world.title || world.name)));
    if (state.world !== null) choice.value = state.world;
    document.getElementById("world-time").textContent = seconds(state.worldTimes[state.world]);
  });
}

mountWorldChoice();
mountTheme();
mountPanes();
mountAlerts(store, { select, refresh: refreshAll });
const statement = mountStatement(store, { select, refresh: refreshAll });
mountLists(store, { select, older });
mountGoal(store, { refresh: refreshAll });
const picture = mountPlan(store, { look, refresh: refreshAll });
const telemetry = createTelemetry();
store.subscribe((state) => telemetry.of(state.world));
mountRobots(store);
mountUnknown(store);
const bench = mountDoor(store, telemetry);
mountRobotPanel(store, telemetry, { refresh: refreshAll, bench });
const world = mountWorld(store, telemetry, { onPick: (sentence) => statement.write(sentence) });
const player = mountPlayer(store, telemetry, { picture, world });
mountMission(store, { refresh: refreshAll, replay: player.open });
follow("/v1/events?state=false", {
  onEvent: (event) => {
    bench.heard(event);
    loading.note(event);
  },
  onState: (stream) => {
    badge({ stream });
    if (stream) refreshAll();
  },
});
// A robot that falls silent sends no event of it.
const tick = (everything) => document.hidden || asked("clock", async () => {
  await loadWorlds();
  if (everything) await loading.loadRobots();
});
tick(false);
document.addEventListener("visibilitychange", () => tick(true));
setInterval(() => tick(++ticks % ROBOTS_TICKS === 0), CLOCK_MS);
