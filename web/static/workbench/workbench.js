// The workbench (SRA): robots and their properties, driving one by hand, plots of telemetry, the behaviour of one robot
// and its mind, the words said to it, and the messages of all.

import { el, replace, show } from "../page/dom.js";
import { words } from "../page/format.js";
import { part as fetched } from "../page/part.js";
import { problemBox } from "../page/problem.js";

/** @type {Record<string, () => Promise<{mount: (root: Element, store: Store, telemetry: Telemetry) => WorkbenchPart}>>} */
const PARTS = {
  robots: fetched(() => import("./table.js")),
  drive: fetched(() => import("./drive.js")),
  plots: fetched(() => import("./plots.js")),
  behaviour: fetched(() => import("./behaviour.js")),
  mind: fetched(() => import("./mind.js")),
  words: fetched(() => import("./words.js")),
  messages: fetched(() => import("./messages.js"), "speech"),
};

/** @param {Element} root @param {Store} store @param {Telemetry} telemetry @returns {Workbench} */
export function mountWorkbench(root, store, telemetry) {
  const body = el("div", { class: "bench-body" });
  const choice = el("select", { "aria-label": "Robot", "data-testid": "bench-robot" });
  choice.addEventListener("change", () => store.update({ robot: choice.value }));
  const tabs = Object.keys(PARTS).map((name) => el("button", { "data-testid": `bench-${name}`, onclick: () => open(name) }, words(name)));
  /** @type {WorkbenchPart | null} */
  let part = null;
  let lastOpened = "robots";
  let openings = 0;
  /** @type {Promise<void> | undefined} */
  let opening; // events that come meanwhile are passed on afterwards

  /** @param {string} name */
  const open = (name) => (opening = load(name));

  /** What is shown of another part stays until this one is there. @param {string} name */
  async function load(name) {
    const number = ++openings;
    part?.close();
    part = null;
    lastOpened = name;
    tabs.forEach((tab, index) => tab.setAttribute("aria-pressed", String(Object.keys(PARTS)[index] === name)));
    try {
      const { mount } = await PARTS[name]();
      if (number !== openings) return;
      replace(body);
      part = mount(body, store, telemetry);
      store.update({});
    } catch (error) {
      if (number === openings) replace(body, problemBox(error));
    }
  }

  const tabBar = el("div", { class: "switch", role: "group", "aria-label": "Workbench" }, tabs);
  replace(root, el("div", { class: "head" }, el("h2", {}, "Workbench"), tabBar, el("span", { class: "spring" }), choice), body);
  store.subscribe((state) => {
    if (part === null) return;
    const robots = state.robots.filter((robot) => robot.world === state.world);
    show(choice, robots.map((robot) => el("option", { value: robot.name }, robot.name)));
    if (state.robot) choice.value = state.robot;
    part.update(state);
  });
  return {
    open(name = lastOpened) {
      const { robot, robots, world } = store.get();
      if (!robot) store.update({ robot: robots.find((one) => one.world === world)?.name ?? null });
      return open(name);
    },
    async onEvent(event) {
      await opening;
      part?.onEvent?.(event);
    },
    close() {
      openings += 1;
      part?.close();
      replace(body);
      part = null;
    },
  };
}
