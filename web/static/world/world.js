// The right pane: the world in three dimensions or as a map, and what is not known of it.

import { byId, el, show } from "../page/dom.js";
import { part, whenOpened } from "../page/part.js";
import { loadPreference, savePreference } from "../page/preferences.js";
import { problemBox } from "../page/problem.js";
import { isDark, onTheme } from "../page/theme.js";
import { createViewFrame } from "./view_frame.js";

const fetchMap = part(() => import("./map.js"), "map");
const fetchLegend = part(() => import("./legend.js"));

/** @param {Store} store @param {Telemetry} telemetry @param {(sentence: string) => void} writeGoal @param {() => Promise<void>} loadRobots */
export function mountWorld(store, telemetry, writeGoal, loadRobots) {
  const pick = createPicking(store, writeGoal);
  const view = createViewFrame(pick);
  const holder = byId("stage-holder", HTMLElement);
  const camera = mountCamera(store);
  const legend = whenOpened(byId("legend", HTMLDetailsElement), async () => (await fetchLegend()).createLegend());
  const buttons = { view: byId("as-view", HTMLButtonElement), map: byId("as-map", HTMLButtonElement) };
  const isMap = () => holder.classList.contains("as-map");
  const problem = el("div", { class: "map", role: "alert" });
  /** @type {ReturnType<typeof import("./map.js").createMap> | null} */
  let map = null;
  /** @type {{mission_id: string, time_s: number} | null} */
  let replay = null;

  async function loadMap() {
    const { createMap } = await fetchMap();
    if (map === null) {
      map = createMap(store, telemetry, pick, loadRobots);
      holder.append(map.node);
    }
    return map;
  }

  /** Nothing is sent or drawn in three dimensions while not visible. */
  function update() {
    const { world, robot, sample, plan, action, follow, whole, goal } = store.get();
    view.show({ world, robot, sample, plan_id: plan?.id, action, follow, whole, replay, seen: !document.hidden && !isMap(), dark: isDark() });
    if (goal !== undefined && !isMap()) view.open(); // not before the first goal is loaded
  }

  /** @param {"view" | "map"} chosen */
  async function choose(chosen) {
    savePreference("world-as", chosen);
    for (const [name, button] of Object.entries(buttons)) button.setAttribute("aria-pressed", String(name === chosen));
    camera.hidden = chosen === "map";
    legend.hidden = chosen === "map";
    holder.classList.toggle("as-map", chosen === "map");
    update();
    problem.remove();
    try {
      if (isMap()) await loadMap();
      map?.show(isMap()); // the other may be pressed meanwhile
    } catch (error) {
      holder.append(problem);
      show(problem, problemBox(error));
    }
  }

  buttons.view.addEventListener("click", () => choose("view"));
  buttons.map.addEventListener("click", () => choose("map"));
  choose(loadPreference("world-as", "view") === "map" ? "map" : "view");
  new ResizeObserver(([entry]) => view.fit(entry.contentRect.width)).observe(holder);
  store.subscribe(update);
  document.addEventListener("visibilitychange", update);
  onTheme(update);
  return {
    /** The drawing to show a mission's recording on. @param {WorldLayout} layout @param {string} missionId */
    async showReplay(layout, missionId) {
      if (!view.isVisible) choose("map");
      replay = { mission_id: missionId, time_s: 0 };
      return (await loadMap()).replay(layout);
    },
    /** @param {number} time */
    replayTo(time) {
      if (replay) replay = { ...replay, time_s: time };
      update();
    },
    async showLive() {
      replay = null;
      map?.replay(null);
    },
  };
}

/** The buttons that have the view's camera follow the selected robot or show the whole world. @param {Store} store */
function mountCamera(store) {
  const follow = byId("follow", HTMLButtonElement);
  follow.addEventListener("click", () => store.update({ follow: !store.get().follow }));
  byId("whole", HTMLButtonElement).addEventListener("click", () => store.update({ follow: false, whole: store.get().whole + 1 }));
  store.subscribe((state) => {
    follow.disabled = !state.robot;
    follow.setAttribute("aria-pressed", String(state.follow && Boolean(state.robot)));
  });
  return byId("camera", HTMLElement);
}

/**
 * What is picked in the world, on the map or in three dimensions: a robot is selected; a sample and then a place make a goal.
 * @param {Store} store @param {(sentence: string) => void} writeGoal @returns {(picked: Picked) => void}
 */
function createPicking(store, writeGoal) {
  const note = byId("pick-note", HTMLElement);
  let due = "";
  store.subscribe(({ sample, replaying }) => {
    const now = replaying ? "This is a recording." : sample ? `${sample}: pick the place it is to go to.` : "";
    if (now !== due) note.textContent = due = now;
  });
  return ({ kind, name }) => {
    const { robot, sample } = store.get();
    if (kind === "robot") store.update({ robot: robot === name ? null : name });
    else if (kind === "sample") store.update({ sample: sample === name ? null : name });
    else if (sample) {
      writeGoal(`move ${sample} to ${name}`);
      store.update({ sample: null });
    } else note.textContent = "Pick a sample first, then the place it is to go to.";
  };
}
