// The workbench (SRA): robots and their properties, driving one by hand, plots of telemetry, the behaviour of one robot.
// Fetched when it is first opened, in place of goal and plan.

import { el, replace, show } from "../page/dom.js";
import { words } from "../page/format.js";
import { mountBehaviour } from "./behaviour.js";
import { mountDrive } from "./drive.js";
import { mountPlots } from "./plots.js";
import { mountTable } from "./table.js";

const PARTS = { robots: mountTable, drive: mountDrive, plots: mountPlots, behaviour: mountBehaviour };

export function mountWorkbench(root, store, telemetry) {
  const body = el("div", { class: "bench-body" });
  const choice = el("select", { "aria-label": "Robot", "data-testid": "bench-robot", onchange: () => store.update({ robot: choice.value }) });
  const tabs = Object.keys(PARTS).map((name) => el("button", { type: "button", "data-testid": `bench-${name}`, onclick: () => open(name) }, words(name)));
  let [part, opened] = [null, null];

  function open(name) {
    part?.close();
    opened = name;
    tabs.forEach((tab, at) => tab.setAttribute("aria-pressed", String(Object.keys(PARTS)[at] === name)));
    replace(body);
    part = PARTS[name](body, store, telemetry);
    part.update(store.get());
  }

  replace(root, el("div", { class: "head" }, el("h2", {}, "Workbench"), el("div", { class: "switch", role: "group", "aria-label": "Workbench" }, tabs), el("span", { class: "spring" }), choice), body);
  store.subscribe((state) => {
    if (part === null) return;
    const mine = state.robots.filter((robot) => robot.world === state.world);
    show(choice, mine.map((robot) => el("option", { value: robot.name }, robot.name)));
    if (state.robot) choice.value = state.robot;
    part.update(state);
  });
  return {
    open(name = opened ?? "robots") {
      // Whatever is looked at closely, one robot is.
      if (!store.get().robot) store.update({ robot: store.get().robots.find((robot) => robot.world === store.get().world)?.name ?? null });
      open(name);
      store.update({});
    },
    heard: (event) => part?.heard?.(event),
    close() {
      part?.close();
      replace(body);
      part = null;
    },
  };
}
