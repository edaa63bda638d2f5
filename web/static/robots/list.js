// The robots, a line each: link, current packet, battery; then doors, hatches and lifts. A click selects one.

import { byId, closest, el, replace, show } from "../page/dom.js";
import { part } from "../page/part.js";
import { contact, isHeard } from "./contact.js";

const fetchStanding = part(() => import("./standing.js"));

const LOW_BATTERY = 0.2;

/** @param {Store} store */
export function mountRobots(store) {
  const list = byId("robots", HTMLElement);
  /** @type {Map<string, HTMLButtonElement>} */
  const lines = new Map();
  /** @type {typeof import("./standing.js").doing | undefined} */
  let doing; // fetched when there are doors
  list.addEventListener("click", (event) => {
    const name = closest(event, "[data-robot]")?.dataset.robot;
    if (name) store.update({ robot: store.get().robot === name ? null : name });
  });
  // A robot keeps its button, which may be under the pointer or hold the focus.
  /** @param {string} name */
  const lineOf = (name) => {
    const line = lines.get(name) ?? el("button", { "data-testid": "robot", "data-robot": name });
    lines.set(name, line);
    return line;
  };
  store.subscribe(async (state) => {
    if (state.peripherals.length) doing ??= (await fetchStanding().catch(() => null))?.doing;
    const robots = [...state.robots, ...state.peripherals].filter((robot) => !robot.world || robot.world === state.world);
    const nodes = robots.map((robot) => lineOf(robot.name));
    if (nodes.length !== list.children.length || nodes.some((node, index) => node !== list.children[index])) replace(list, nodes);
    robots.forEach((robot, index) => {
      const link = contact(robot, state.worldTimes[robot.world]);
      nodes[index].className = `robot ${link.tone}`;
      nodes[index].setAttribute("aria-pressed", String(robot.name === state.robot));
      show(nodes[index], parts(robot, link, doing));
    });
  });
}

/** @param {Robot} robot @param {ReturnType<typeof contact>} link @param {(robot: Robot) => string | null} [doing] of doors and lifts */
function parts(robot, link, doing) {
  const activity = [robot.out_of_service && "out of service", doing?.(robot) ?? robot.packet, robot.holding && `holds ${robot.holding}`].filter(Boolean).join(", ") || "idle";
  const isOnline = isHeard(robot);
  return [
    el("span", { class: `dot ${link.tone}`, title: link.word }),
    el("b", {}, robot.name),
    el("span", { class: isOnline ? "quiet doing" : "doing link-word" }, isOnline ? activity : link.word),
    battery(robot.battery),
    link.note ? el("span", { class: "quiet whole link-note" }, link.note) : null,
  ];
}

/** @param {number | null | undefined} level */
function battery(level) {
  if (typeof level !== "number") return null;
  const text = `${Math.round(level * 100)} %`;
  const isLow = level < LOW_BATTERY;
  const meter = el("meter", { min: 0, max: 1, low: LOW_BATTERY, value: level.toFixed(2), "aria-hidden": "true" });
  return el("span", { class: isLow ? "battery low" : "quiet battery", title: `battery ${text}` }, meter, isLow ? `low ${text}` : text);
}
