// The live map, which needs no WebGL. A click selects a robot, or a sample and then its destination.

import { get, id } from "../page/api.js";
import { closest, el } from "../page/dom.js";
import { part } from "../page/part.js";
import { attempt } from "../page/problem.js";
import { responseOrder, throttled } from "../page/store.js";
import { createDrawing } from "./drawing.js";
import { createNumbers } from "./numbers.js";

const fetchEditor = part(() => import("./editor.js"), "editor");

/** @param {Store} store @param {Telemetry} telemetry @param {(picked: Picked) => void} onPick @param {() => Promise<void>} loadRobots */
export function createMap(store, telemetry, onPick, loadRobots) {
  const drawing = createDrawing();
  const edit = el("button", { class: "edit-world", "aria-pressed": "false", "data-testid": "edit-world", onclick: () => attempt([], problem, openEditor) }, "Edit the world");
  const problem = el("div", { role: "alert" });
  const node = el("div", { class: "map", "data-testid": "map" }, drawing.node, edit, problem, createNumbers(store));
  /** @type {ReturnType<typeof import("./editor.js").createEditor> | null} */
  let editor = null; // fetched when first needed
  const factsOrder = responseOrder();
  /** @type {string | null} */
  let world = null;
  /** @type {number | null} */
  let version = null; // of the facts that are shown
  let edition = 0; // of the layout that is shown
  let hasLayout = false;
  /** @type {(() => void) | null} */
  let unfollow = null; // set while the map is shown
  let isReplaying = false;
  let packets = ""; // those that doors, hatches and lifts are at
  const loadPeripherals = throttled(() => loadRobots().catch(() => (packets = "")));

  /** @param {string} name */
  async function load(name) {
    world = name;
    hasLayout = false;
    const known = await get(`/v1/worlds/${id(name)}`);
    if (isReplaying || world !== name) return; // a recording or another world was opened meanwhile
    drawing.showLayout(known.layout);
    drawPeripherals();
    edition = known.edition;
    await editor?.load();
    hasLayout = true;
    version = null;
    await loadFacts(name);
  }

  /** @param {string} name */
  async function loadFacts(name) {
    const newest = store.get().worlds.find((one) => one.id === name)?.version;
    if (!hasLayout || (newest !== undefined && newest === version)) return;
    version = newest ?? null;
    const isCurrent = factsOrder();
    /** @type {{items: Fact[], edition: number}} */
    const { items, edition: newestEdition } = await get(`/v1/worlds/${id(name)}/facts`);
    if (isReplaying || !hasLayout || world !== name || !isCurrent()) return;
    if (newestEdition > edition) return load(name);
    if (store.get().peripherals.length) loadPeripherals();
    drawing.showSamples(new Map(items.filter((fact) => fact.predicate === "in").map(({ args: [sample, place] }) => [sample, place])));
  }

  async function openEditor() {
    const { createEditor } = await fetchEditor();
    if (editor === null) {
      editor = createEditor(drawing.node, () => world);
      node.append(editor.node);
    }
    const isOpen = Boolean(editor.node.hidden);
    edit.setAttribute("aria-pressed", String(isOpen));
    await editor.open(isOpen);
  }

  /** @param {Event} event */
  function pick(event) {
    const mark = closest(event, "[data-name], [data-robot]");
    if (!mark) return;
    const { name = "", robot } = mark.dataset;
    /** @type {Picked} */
    const picked = robot ? { kind: "robot", name: robot } : { kind: mark.classList.contains("sample-mark") ? "sample" : "place", name };
    if (mark.matches(".peripheral-mark") || !editor?.pick(picked)) onPick(picked);
  }

  /** @param {TelemetryMessage} message */
  function onTelemetry({ robots }) {
    if (isReplaying) return;
    const { robot, peripherals } = store.get();
    drawing.showRobots(robots, robot);
    const newest = peripherals.map(({ name }) => `${robots[name]?.packet_tag} ${robots[name]?.packet_state}`).join();
    if (newest !== packets) loadPeripherals();
    packets = newest;
  }

  function drawPeripherals() {
    const { peripherals, worldTimes, robot } = store.get();
    if (!isReplaying) drawing.showPeripherals(peripherals.filter((one) => one.world === world), worldTimes[world ?? ""], robot);
  }

  drawing.node.addEventListener("click", pick);
  drawing.node.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    pick(event);
  });
  store.subscribe((state) => {
    for (const mark of drawing.node.querySelectorAll(".sample-mark")) mark.classList.toggle("picked", mark.getAttribute("data-name") === state.sample);
    drawPeripherals();
    if (unfollow === null || isReplaying || state.world === null) return;
    if (state.world === world) loadFacts(world).catch(() => (version = null));
    else load(state.world).catch(() => (world = null));
  });
  return {
    node,
    /** @param {boolean} isShown */
    show(isShown) {
      node.hidden = !isShown;
      if (!isShown) {
        unfollow?.();
        unfollow = null;
        return;
      }
      unfollow ??= telemetry.follow(onTelemetry);
      store.update({});
    },
    /** Returns the drawing for a recording of a world with this layout; null ends the replay. @param {WorldLayout | null} layout */
    replay(layout) {
      isReplaying = layout !== null;
      if (layout) drawing.showLayout(layout);
      else world = null;
      store.update({});
      return drawing;
    },
  };
}
