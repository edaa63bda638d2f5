// Composes the page: creates the state, requests and follows it, and mounts the parts that draw it.

import { mountAlerts } from "./alerts.js";
import { mountGoalForm } from "./goals/goal_form.js";
import { mountInvitation } from "./goals/invitation.js";
import { mountLists } from "./goals/list.js";
import { createLoading } from "./loading.js";
import { followEvents, list, problemOf } from "./page/api.js";
import { byId, el, show } from "./page/dom.js";
import { seconds } from "./page/format.js";
import { mountPanes } from "./page/panes.js";
import { part } from "./page/part.js";
import { problemBox } from "./page/problem.js";
import { createStore, responseOrder } from "./page/store.js";
import { createTelemetry } from "./page/telemetry.js";
import { mountTheme } from "./page/theme.js";
import { mountRobots } from "./robots/list.js";
import { mountWorkbenchButton } from "./workbench/lazy.js";
import { mountWorld } from "./world/world.js";

const CLOCK_MS = 1000;
const TICKS_PER_ROBOT_REQUEST = 3;

const store = createStore({
  world: null,
  worlds: [],
  worldTimes: {},
  goals: [],
  missions: [],
  hasOlder: { goals: false, missions: false },
  robots: [],
  peripherals: [],
  unknown: [],
  holds: [],
  robot: null,
  sample: null,
  action: null,
  follow: false,
  whole: 0,
  replaying: null,
  selected: null,
  goal: undefined,
  viewedPlan: null,
  plan: null,
  previousPlan: null,
  alternatives: [],
  mission: null,
});

// The token in the address has become a cookie; neither the address bar nor the history keeps it.
if (new URLSearchParams(location.search).has("token")) history.replaceState(null, "", location.pathname);

/** Live: the stream is open and the last request of each kind was answered. @type {Record<string, boolean>} */
const health = { stream: false, clock: false, lists: false };
let ticks = 0;
/** The plan's picture, which the player draws in. @type {Picture} */
let picture;
/** @type {ReturnType<typeof import("./replay/player.js").mountPlayer> | undefined} */
let player;
const fetchGoal = part(() => Promise.all([import("./goals/goal.js"), import("./plan/plan.js"), import("./mission/mission.js")]), "plan");
const fetchPanel = part(() => import("./robots/panel.js"), "robot");
const fetchNotes = part(() => import("./world/notes.js"));
const fetchPlayer = part(() => import("./replay/player.js"), "replay", "results", "speech", "workbench");
const loading = createLoading(store, track);
const { refresh, refreshAll } = loading;

/** @param {string} goalId */
function select(goalId) {
  workbench.close();
  store.update({ selected: goalId, goal: store.get().goals.find((one) => one.id === goalId), viewedPlan: null, plan: null, alternatives: [], mission: null });
  refresh();
}

/** @param {string} planId */
function viewPlan(planId) {
  store.update({ viewedPlan: planId });
  refresh();
}

/** @param {string} kind @param {() => Promise<void>} request */
async function track(kind, request) {
  try {
    await request();
    showHealth({ [kind]: true });
  } catch (error) {
    showHealth({ [kind]: false }, problemOf(error).message);
  }
}

/** @param {Record<string, boolean>} change @param {string} reason */
function showHealth(change, reason = "") {
  Object.assign(health, change);
  const isLive = Object.values(health).every(Boolean);
  const badge = byId("live", HTMLElement);
  badge.textContent = isLive ? "live" : "not live";
  badge.className = isLive ? "badge good" : "badge bad";
  badge.title = isLive ? "Changes are shown as they happen" : reason || "The connection to the service is lost; trying again";
}

const worldsOrder = responseOrder();

async function loadWorlds() {
  const isCurrent = worldsOrder();
  /** @type {World[]} */
  const worlds = await list("/v1/worlds");
  if (!isCurrent()) return;
  const worldTimes = Object.fromEntries(worlds.map((world) => [world.id, world.time_s]));
  const { world } = store.get();
  const isFirst = world === null;
  const isGone = !isFirst && !worlds.some(({ id }) => id === world);
  if (isGone) store.update({ robot: null, sample: null });
  store.update({ worlds, worldTimes, world: isFirst || isGone ? (worlds[0]?.id ?? null) : world });
  if (isGone) refreshAll();
  else if (isFirst) loading.onWorldChange();
}

// Robots are requested from time to time, for a robot that falls silent sends no event.
function tick(withRobots = false) {
  if (document.hidden) return;
  track("clock", async () => {
    await loadWorlds();
    if (withRobots) await loading.loadRobots();
  });
}

/** The world's title, and its status while it does not run. @param {World} world */
function named({ name, title, status = "running" }) {
  const shown = title || name;
  return status === "running" ? shown : `${shown} (${status.replaceAll("_", " ")})`;
}

function mountWorldChoice() {
  const choice = byId("world", HTMLSelectElement);
  const clock = byId("world-time", HTMLElement);
  choice.addEventListener("change", () => {
    store.update({ world: choice.value, robot: null, sample: null });
    refreshAll();
  });
  store.subscribe((state) => {
    show(choice, state.worlds.map((world) => el("option", { value: world.id, title: world.status_detail ?? "" }, named(world))));
    if (state.world !== null) choice.value = state.world;
    clock.textContent = seconds(state.worldTimes[state.world ?? ""]);
  });
}

/**
 * Mount a part of the page when it is first needed. That it cannot be fetched is shown in its place, until the state changes again.
 * @param {HTMLElement} place @param {(state: State) => unknown} isNeeded @param {() => Promise<void>} mount
 */
function mountWhen(place, isNeeded, mount) {
  const problem = el("div", { role: "alert" });
  let isMounted = false;
  store.subscribe(async (state) => {
    if (!isNeeded(state)) show(problem);
    else if (!isMounted) {
      isMounted = true;
      try {
        await mount();
        problem.remove();
        store.update({});
      } catch (error) {
        isMounted = false;
        place.before(problem);
        show(problem, problemBox(error));
      }
    }
  });
}

/** @param {Mission} mission */
async function replay(mission) {
  const { mountPlayer } = await fetchPlayer();
  player ??= mountPlayer(store, telemetry, { picture, world });
  await player.open(mission);
}

mountWorldChoice();
mountTheme();
mountPanes();
mountAlerts(store, { select, refresh: refreshAll });
const goalForm = mountGoalForm(store, { select, refresh: refreshAll });
mountLists(store, { select, loadOlder: loading.loadOlder });
mountInvitation(store);
const telemetry = createTelemetry();
store.subscribe((state) => telemetry.setWorld(state.world));
mountRobots(store);
const workbench = mountWorkbenchButton(store, telemetry);
const world = mountWorld(store, telemetry, goalForm.write, loading.loadRobots);
mountWhen(byId("goal", HTMLElement), ({ goals }) => goals.length, async () => {
  const [{ mountGoal }, { mountPlan }, { mountMission }] = await fetchGoal();
  mountGoal(store, refreshAll);
  picture = mountPlan(store, { viewPlan, refresh: refreshAll });
  mountMission(store, { refresh: refreshAll, replay });
});
mountWhen(byId("robot", HTMLElement), ({ robot }) => robot, async () => (await fetchPanel()).mountRobotPanel(store, telemetry, { refresh: refreshAll, workbench }));
mountWhen(byId("unknown", HTMLElement), ({ unknown, holds }) => unknown.length + holds.length, async () => (await fetchNotes()).mountNotes(store, refreshAll));
followEvents("/v1/events?state=false", {
  onEvent(event) {
    workbench.onEvent(event);
    loading.onEvent(event);
    if (/^world\.(added|removed)$/.test(event.type ?? "")) tick(true);
  },
  onState(isOpen) {
    showHealth({ stream: isOpen });
    if (isOpen) refreshAll();
  },
});
tick();
document.addEventListener("visibilitychange", () => tick(true));
setInterval(() => tick(++ticks % TICKS_PER_ROBOT_REQUEST === 0), CLOCK_MS);
