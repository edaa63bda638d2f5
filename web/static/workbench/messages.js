// What is said in the world: by its newest missions' records, the selected robot's conversations with the service, and live.

import { id, list } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { newestFirst } from "../page/format.js";
import { createConversation } from "../speech/conversation.js";
import { sayingsOf, sayingsOfEvent, sayingsWithService } from "../speech/sayings.js";

const MAX_MISSIONS = 4;
const MAX_LIVE = 1000;

/** @param {Element} root @param {Store} store @returns {WorkbenchPart} */
export function mount(root, store) {
  const conversation = createConversation();
  /** By the path of what was requested. @type {Map<string, Saying[]>} */
  const recorded = new Map();
  /** @type {Saying[]} */
  let live = [];
  let world = store.get().world;
  /** Counts what is heard and loaded: the number of sayings stays the same once the oldest are dropped. */
  let revision = 0;
  let isShown = "";
  replace(root, el("section", { "data-testid": "bench-speech" }, conversation.node));

  function draw() {
    const { robots } = store.get();
    const names = robots.filter((one) => one.world === world).map((one) => one.name);
    const key = JSON.stringify([names, revision, world, [...recorded.keys()]]);
    if (key === isShown) return;
    isShown = key;
    conversation.show([...recorded.values(), live].flat(), names);
  }

  /** Request once. @template T @param {string} path @param {(item: T) => Saying[]} read */
  async function load(path, read) {
    if (recorded.has(path)) return;
    recorded.set(path, []);
    const said = await list(path).catch(() => null);
    if (said === null) recorded.delete(path); // tried again with the next change
    else if (recorded.has(path)) recorded.set(path, said.flatMap(read));
    revision += 1;
    draw();
  }

  return {
    update(state) {
      if (state.world !== world) {
        world = state.world;
        live = [];
        recorded.clear();
      }
      for (const { id: mission } of newestFirst(state.missions.filter((one) => one.world === world)).slice(0, MAX_MISSIONS)) {
        load(`/v1/missions/${id(mission)}/conversation`, sayingsOf);
      }
      if (state.robots.some((one) => one.name === state.robot && one.world === world)) load(`/v1/robots/${id(state.robot ?? "")}/conversations`, sayingsWithService);
      draw();
    },
    onEvent(event) {
      const { worldTimes, robots } = store.get();
      const { robot, world: of } = event.data ?? {};
      if (of !== world && !robots.some((one) => one.name === robot && one.world === world)) return;
      const heard = sayingsOfEvent(event, worldTimes[world ?? ""] ?? 0);
      if (!heard.length) return;
      live = [...live, ...heard].slice(-MAX_LIVE);
      revision += 1;
      draw();
    },
    close() {},
  };
}
