// The selected robot: its link, battery and packet, its range readings and its behaviour synthesis.

import { id } from "../page/api.js";
import { badge, byId, el, replace, show } from "../page/dom.js";
import { tone, words } from "../page/format.js";
import { commandButton } from "../page/problem.js";
import { serviceControl } from "./service.js";
import { isPeripheral, standing } from "./standing.js";
import { rangeRose, robotState, synthesis } from "./telemetry_drawing.js";

/** @param {Store} store @param {Telemetry} telemetry @param {{refresh: () => void, workbench: Workbench}} actions */
export function mountRobotPanel(store, telemetry, { refresh, workbench }) {
  const panel = byId("robot", HTMLElement);
  const parts = { head: el("div"), service: el("div"), synthesis: el("div", { class: "synthesis" }), rose: el("div"), state: el("div", { class: "told" }), problem: el("div", { role: "alert" }) };
  /** @type {string | null} */
  let shown = null;
  /** @type {(() => void) | null} */
  let unfollow = null;
  let drawnHead = "";
  let drawnService = "";

  /** @param {string | null} name */
  function open(name) {
    unfollow?.();
    unfollow = null;
    shown = name;
    panel.hidden = name === null;
    drawnHead = "";
    drawnService = "";
    if (name === null) return;
    for (const part of Object.values(parts)) show(part);
    replace(panel, parts.head, parts.service, parts.problem, el("div", { class: "robot-parts" }, el("div", { class: "grow" }, parts.synthesis, parts.state), parts.rose));
    unfollow = telemetry.follow(({ robots }) => {
      const robot = robots[name];
      if (!robot || store.get().peripherals.some((one) => one.name === name)) return; // a peripheral has no sensors
      show(parts.synthesis, synthesis(robot));
      show(parts.state, robotState(robot));
      replace(parts.rose, rangeRose(robot));
    });
  }

  /** @param {Robot} robot */
  function drawHead(robot) {
    // The time since it was heard is rounded, so that the buttons stay under the pointer.
    const key = JSON.stringify([robot.connection, robot.world_stands, robot.lost, robot.mission_id, lastHeard(robot), standing(robot)]);
    if (key === drawnHead) return;
    drawnHead = key;
    replace(
      parts.head,
      el(
        "div",
        { class: "head" },
        el("h3", {}, robot.name),
        isPeripheral(robot) ? el("span", { "data-testid": "standing" }, `${robot.kind}, ${standing(robot)}`) : null,
        badge(robot.lost ? "bad" : tone(robot.connection), robot.lost ? "lost" : robot.world_stands ? "at a breakpoint" : words(robot.connection), { "data-testid": "robot-connection" }),
        el("span", { class: "quiet small" }, lastHeard(robot)),
        el("span", { class: "spring" }),
        robot.lost ? declare(robot, "declare_found", "Declare found") : robot.connection === "online" ? null : declare(robot, "declare_lost", "Declare lost"),
        isPeripheral(robot) ? null : el("button", { "data-testid": "robot-bench", onclick: () => workbench.open("drive") }, "Drive"),
        el("button", { "aria-label": "Close", onclick: () => store.update({ robot: null }) }, "×"),
      ),
    );
  }

  /** Drawn apart from the head, so that a reason that is being written stays. @param {Robot} robot */
  function drawService(robot) {
    const key = JSON.stringify([robot.name, robot.out_of_service]);
    if (key === drawnService) return;
    drawnService = key;
    replace(parts.service, serviceControl(robot, parts.problem, refresh));
  }

  /** @param {Robot} robot @param {string} verb @param {string} label */
  function declare(robot, verb, label) {
    const done = () => {
      drawnHead = "";
      refresh();
    };
    return commandButton(label, `/v1/robots/${id(robot.name)}:${verb}`, parts.problem, done, { class: "danger", "data-testid": `robot-${verb}` });
  }

  store.subscribe((state) => {
    if (state.robot !== shown) open(state.robot);
    const robot = [...state.robots, ...state.peripherals].find((one) => one.name === shown);
    if (!robot) return;
    drawHead(robot);
    drawService(robot);
  });
}

/** @param {Robot} robot */
function lastHeard({ connection, last_heard_s: ago }) {
  if (typeof ago !== "number") return "never heard";
  if (connection === "online" && ago < 10) return "heard just now";
  return ago < 120 ? `last heard ${Math.round(ago / 5) * 5} s ago` : `last heard ${Math.round(ago / 60)} min ago`;
}
