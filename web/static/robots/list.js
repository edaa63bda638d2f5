// The robots, a line each: link, what it is at, battery; one of them can be looked at more closely.

import { el, replace, show } from "../page/dom.js";
import { contact } from "./contact.js";

const LOW = 0.2;

export function mountRobots(store) {
  const list = document.getElementById("robots");
  const lines = new Map();
  list.addEventListener("click", (event) => {
    const name = event.target.closest("[data-robot]")?.dataset.robot;
    if (name) store.update({ robot: store.get().robot === name ? null : name });
  });
  // A line stays what it is while what stands in it changes: it may be under the pointer, or hold the focus.
  const lineOf = (name) => {
    if (!lines.has(name)) lines.set(name, el("button", { type: "button", "data-testid": "robot", "data-robot": name }));
    return lines.get(name);
  };
  store.subscribe((state) => {
    const mine = state.robots.filter((robot) => !robot.world || robot.world === state.world);
    const nodes = mine.map((robot) => lineOf(robot.name));
    if (nodes.length !== list.children.length || nodes.some((node, at) => node !== list.children[at])) replace(list, nodes);
    mine.forEach((robot, at) => {
      const link = contact(robot, state.worldTimes[robot.world]);
      nodes[at].className = `robot ${link.tone}`;
      nodes[at].setAttribute("aria-pressed", String(robot.name === state.robot));
      show(nodes[at], parts(robot, link));
    });
  });
}

function parts(robot, link) {
  const doing = [robot.packet, robot.holding && `holds ${robot.holding}`].filter(Boolean).join(", ") || "idle";
  const is = link.word === "online" ? el("span", { class: "quiet doing" }, doing) : el("span", { class: "doing link-word" }, link.word);
  return [
    el("span", { class: `dot ${link.tone}`, title: link.word }),
    el("b", {}, robot.name),
    is,
    battery(robot.battery),
    link.note ? el("span", { class: "quiet whole link-note" }, link.note) : null,
  ];
}

function battery(level) {
  if (typeof level !== "number") return null;
  const told = `${Math.round(level * 100)} %`;
  const low = level < LOW;
  return el("span", { class: low ? "battery low" : "quiet battery", title: `battery ${told}` }, el("meter", { min: 0, max: 1, low: LOW, value: level.toFixed(2), "aria-hidden": "true" }), low ? `low ${told}` : told);
}
