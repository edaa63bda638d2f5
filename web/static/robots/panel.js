// One robot closely: its link, battery and packet, what its whiskers feel, and the behaviour synthesis made visible.

import { id, post } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { tone, words } from "../page/format.js";
import { asking } from "../page/problem.js";

export function mountRobotPanel(store, telemetry, { refresh, bench }) {
  const panel = document.getElementById("robot");
  const parts = { head: el("div"), synthesis: el("div", { class: "synthesis" }), rose: el("div"), told: el("div", { class: "told" }), problem: el("div", { role: "alert" }) };
  let shown = null;
  let leave = null;
  let drawnHead = null;

  async function open(name) {
    leave?.();
    leave = null;
    shown = name;
    panel.hidden = name === null;
    drawnHead = null;
    if (name === null) return;
    for (const part of Object.values(parts)) show(part);
    replace(panel, parts.head, parts.problem, el("div", { class: "robot-parts" }, el("div", { class: "grow" }, parts.synthesis, parts.told), parts.rose));
    const drawn = await import("./inside.js"); // wanted only once a robot is looked at
    if (shown !== name) return;
    leave ??= telemetry.follow(({ robots }) => {
      const told = robots[name];
      if (!told) return;
      show(parts.synthesis, drawn.synthesis(told));
      show(parts.told, drawn.tellings(told));
      replace(parts.rose, drawn.rose(told));
    });
  }

  function head(robot) {
    // Seconds since it was heard change all the time: told roughly, so that the buttons stay under the pointer.
    const key = JSON.stringify([robot.connection, robot.lost, robot.mission_id, heard(robot)]);
    if (key === drawnHead) return;
    drawnHead = key;
    replace(
      parts.head,
      el(
        "div",
        { class: "head" },
        el("h3", {}, robot.name),
        el("span", { class: `badge ${robot.lost ? "bad" : tone(robot.connection)}`, "data-testid": "robot-connection" }, robot.lost ? "lost" : words(robot.connection)),
        el("span", { class: "quiet small" }, heard(robot)),
        el("span", { class: "spring" }),
        robot.lost ? order(robot, "declare_found", "Declare found") : robot.connection === "online" ? null : order(robot, "declare_lost", "Declare lost"),
        el("button", { type: "button", "data-testid": "robot-bench", onclick: () => bench.open("drive") }, "Drive"),
        el("button", { type: "button", "aria-label": "Close", onclick: () => store.update({ robot: null }) }, "×"),
      ),
    );
  }

  function order(robot, verb, label) {
    return el("button", { type: "button", class: "danger", "data-testid": `robot-${verb}`, onclick: async (event) => {
      await asking([event.currentTarget], parts.problem, () => post(`/v1/robots/${id(robot.name)}:${verb}`));
      drawnHead = null;
      refresh();
    } }, label);
  }

  store.subscribe((state) => {
    if (state.robot !== shown) open(state.robot);
    const robot = state.robots.find((one) => one.name === shown);
    if (robot) head(robot);
  });
}

function heard(robot) {
  const ago = robot.last_heard_s;
  if (typeof ago !== "number") return "never heard";
  if (robot.connection === "online" && ago < 10) return "heard just now";
  return ago < 120 ? `last heard ${Math.round(ago / 5) * 5} s ago` : `last heard ${Math.round(ago / 60)} min ago`;
}
