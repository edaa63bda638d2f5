// The right pane: the world in three dimensions, or as a map.

import { get } from "../page/api.js";
import { recall, remember } from "../page/remembered.js";
import { isDark, onTheme } from "../page/theme.js";
import { mountLegend } from "./legend.js";
import { createLink } from "./link.js";
import { createPicking } from "./picking.js";

const VIEWER = "/viewer/";
const AGAIN_MS = 1500;
// Narrower than this, viser's page takes itself for a telephone's and covers the world with its panel.
const NARROWEST_PX = 600;

export function mountWorld(store, telemetry, { onPick }) {
  const stage = document.getElementById("stage");
  const pick = createPicking(store, { onPick });
  const link = createLink({ onPick: pick });
  const holder = stage.parentElement;
  // The map is fetched once it is wanted.
  let drawn = null;
  const fetched = () => (drawn ??= import("./map.js").then(({ createMap }) => {
    const map = createMap(store, telemetry, { onPick: pick });
    holder.append(map.node);
    return map;
  }).catch((problem) => {
    drawn = null; // it is fetched anew when it is wanted next
    throw problem;
  }));
  mountLegend();
  const camera = mountCamera(store);
  let replay = null;
  const asMap = () => holder.classList.contains("as-map");
  // Nothing is sent or drawn in three dimensions that nobody sees.
  const tell = ({ world, robot, sample, plan, action, follow, whole }) => link.show({ world, robot, sample, plan_id: plan?.id, action, follow, whole, replay, seen: !document.hidden && !asMap(), dark: isDark() });
  // The view's own page is many times as large as ours: what is to be decided on comes first, and who sees the map needs none of it.
  let opened = false;
  const openOnce = ({ goal }) => {
    if (opened || goal === undefined || asMap()) return;
    opened = true;
    keepStage(stage, link);
  };
  const buttons = { view: document.getElementById("as-view"), map: document.getElementById("as-map") };
  const turn = async (name) => {
    remember("world-as", name);
    for (const [other, button] of Object.entries(buttons)) button.setAttribute("aria-pressed", String(other === name));
    camera.hidden = document.getElementById("legend").hidden = name === "map";
    holder.classList.toggle("as-map", name === "map");
    tell(store.get());
    openOnce(store.get());
    const map = await (name === "map" ? fetched() : drawn);
    map?.show(asMap()); // it may have been turned back meanwhile
  };
  for (const [name, button] of Object.entries(buttons)) button.addEventListener("click", () => turn(name));
  turn(recall("world-as", "view") === "map" ? "map" : "view");
  new ResizeObserver(([entry]) => fit(stage, entry.contentRect)).observe(holder);
  store.subscribe(tell);
  store.subscribe(openOnce);
  document.addEventListener("visibilitychange", () => tell(store.get()));
  onTheme(() => tell(store.get()));
  return {
    // The drawing to show a mission's recording on; `replayTo` says at what instant, `showLive` ends it.
    async showReplay(layout, missionId) {
      if (stage.hidden) turn("map");
      replay = { mission_id: missionId, time_s: 0 };
      return (await fetched()).replay(layout);
    },
    replayTo(time) {
      replay = { ...replay, time_s: time };
      tell(store.get());
    },
    async showLive() {
      replay = null;
      (await drawn)?.replay(null);
    },
  };
}

// The camera of the view goes with the robot that is looked at, or shows the whole world.
function mountCamera(store) {
  const follow = document.getElementById("follow");
  follow.addEventListener("click", () => store.update({ follow: !store.get().follow }));
  document.getElementById("whole").addEventListener("click", () => store.update({ follow: false, whole: store.get().whole + 1 }));
  store.subscribe((state) => {
    follow.disabled = !state.robot;
    follow.setAttribute("aria-pressed", String(state.follow && Boolean(state.robot)));
  });
  return document.getElementById("camera");
}

function fit(frame, { width }) {
  const scale = Math.min(1, width / NARROWEST_PX) || 1;
  const whole = `${100 / scale}%`;
  Object.assign(frame.style, { width: whole, height: whole, transform: scale < 1 ? `scale(${scale})` : "" });
}

// The view is a process of its own and may come later than the page; it goes with the service and comes back with it.
// Meanwhile nothing is tried over sockets: browsers hold those back that have failed often, for longer than viser waits.
async function keepStage(frame, link) {
  const note = document.getElementById("stage-note");
  const shown = () => `${VIEWER}${link.name}/${isDark() ? "?darkMode" : ""}`;
  frame.addEventListener("load", () => stayConnected(frame));
  onTheme(() => frame.hidden || frame.getAttribute("src") === shown() || (frame.src = shown()));
  for (;;) {
    while (!(await answers())) {
      note.textContent = "The view of the world is not there yet.";
      await pause();
    }
    const closed = link.open();
    frame.src = shown();
    frame.hidden = false;
    note.hidden = true;
    await closed;
    frame.src = "about:blank";
    frame.hidden = true;
    note.hidden = false;
    await pause();
  }
}

const pause = () => new Promise((resolve) => setTimeout(resolve, AGAIN_MS));

async function answers() {
  return (await get("/v1/view").catch(() => null))?.running === true;
}

// viser's page reconnects only while it has the focus; inside ours it shall whenever ours is seen.
function stayConnected(frame) {
  const inner = frame.contentDocument;
  if (!inner) return;
  inner.hasFocus = () => !document.hidden;
  frame.contentWindow.dispatchEvent(new Event("focus"));
  document.addEventListener("visibilitychange", () => frame.contentWindow?.dispatchEvent(new Event("focus")));
}
