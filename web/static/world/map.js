// The world from above, live: works without WebGL, and a sample and a place picked on it become a goal.

import { get, id } from "../page/api.js";
import { el } from "../page/dom.js";
import { inOrder } from "../page/state.js";
import { createDrawing, lyingIn } from "./drawing.js";

export function createMap(store, telemetry, { onPick }) {
  const drawing = createDrawing();
  const node = el("div", { class: "map", "data-testid": "map" }, drawing.node);
  let world = null;
  let version = null;
  let hasGround = false;
  let leave = null;
  let replayed = false;
  const factsAsked = inOrder();

  async function load(name) {
    world = name;
    hasGround = false;
    const { layout } = await get(`/v1/worlds/${id(name)}`);
    if (replayed || world !== name) return; // a recording was opened meanwhile, or another world
    drawing.ground(layout);
    hasGround = true;
    version = null;
    await loadFacts();
  }

  async function loadFacts() {
    const at = store.get().worlds.find((one) => one.id === world)?.version;
    if (!hasGround || (at !== undefined && at === version)) return;
    version = at;
    const [name, isNews] = [world, factsAsked()];
    const { items } = await get(`/v1/worlds/${id(name)}/facts`);
    if (!replayed && hasGround && world === name && isNews()) drawing.samples(lyingIn(items));
  }

  function pick(event) {
    const mark = event.target.closest("[data-name], [data-robot]");
    if (!mark) return;
    const { name, robot } = mark.dataset;
    if (robot) onPick({ kind: "robot", name: robot });
    else onPick({ kind: mark.classList.contains("sample-mark") ? "sample" : "place", name });
  }

  drawing.node.addEventListener("click", pick);
  drawing.node.addEventListener("keydown", (event) => (event.key === "Enter" || event.key === " ") && (event.preventDefault(), pick(event)));
  store.subscribe(({ sample }) => {
    for (const mark of drawing.node.querySelectorAll(".sample-mark")) mark.classList.toggle("picked", mark.dataset.name === sample);
  });
  store.subscribe((state) => {
    if (leave === null || replayed || state.world === null) return;
    if (state.world !== world) load(state.world).catch(() => (world = null));
    else loadFacts().catch(() => (version = null));
  });
  return {
    node,
    show(isShown) {
      node.hidden = !isShown;
      if (!isShown) {
        leave?.();
        leave = null;
        return;
      }
      leave ??= telemetry.follow(({ robots }) => replayed || drawing.robots(robots, store.get().robot));
      store.update({});
    },
    // Shows what was instead of what is, until called with null; answers the drawing to show it on.
    replay(layout) {
      replayed = layout !== null;
      if (replayed) drawing.ground(layout);
      else world = null;
      store.update({});
      return drawing;
    },
  };
}
