// The workbench (SRA): robots and their properties, driving one by hand, plots of telemetry, the behaviour of one robot
// and its mind, the words said to it, and the messages of all.

import { el, replace, show } from "../page/dom.js";
import { words } from "../page/format.js";
import { mountBehaviour } from "./behaviour.js";
import { mountDrive } from "./drive.js";
import { mountMessages } from "./messages.js";
import { mountMind } from "./mind.js";
import { mountPlots } from "./plots.js";
import { mountTable } from "./table.js";
import { mountWords } from "./words.js";

/** @type {Record<string, (root: Element, store: Store, telemetry: Telemetry) => WorkbenchPart>} */
const PARTS = { robots: mountTable, drive: mountDrive, plots: mountPlots, behaviour: mountBehaviour, mind: mountMind, words: mountWords, messages: mountMessages };

/** @param {Element} root @param {Store} store @param {Telemetry} telemetry @returns {Workbench} */
export function mountWorkbench(root, store, telemetry) {
  const body = el("div", { class: "bench-body" });
  const choice = el("select", { "aria-label": "Robot", "data-testid": "bench-robot" });
  choice.addEventListener("change", () => store.update({ robot: choice.value }));
  const tabs = Object.keys(PARTS).map((name) => el("button", { type: "button", "data-testid": `bench-${name}`, onclick: () => open(name) }, words(name)));
  /** @type {WorkbenchPart | null} */
  let part = null;
  let lastOpened = "robots";

  /** @param {string} name */
  function open(name) {
    part?.close();
    lastOpened = name;
    tabs.forEach((tab, index) => tab.setAttribute("aria-pressed", String(Object.keys(PARTS)[index] === name)));
    replace(body);
    part = PARTS[name](body, store, telemetry);
    part.update(store.get());
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
      open(name);
      store.update({});
    },
    onEvent: (event) => part?.onEvent?.(event),
    close() {
      part?.close();
      replace(body);
      part = null;
    },
  };
}
