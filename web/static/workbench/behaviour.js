// The behaviour of one robot: its script, whether the packet's conditions hold, the patterns' responses and their
// resultants, the robot's events, and the patterns' parameters.

import { get, id, problemOf } from "../page/api.js";
import { badge, el, quiet, replace, show } from "../page/dom.js";
import { tone, words } from "../page/format.js";
import { mountBody } from "./body.js";
import { stripChart } from "./charts.js";
import { mountSensors } from "./sensors.js";
import { mountTuning } from "./tuning.js";

const EVERY_MS = 1000;
const WINDOW_S = 10;
const MAX_EVENTS = 12;

/** @param {Element} root @returns {WorkbenchPart} */
export function mount(root) {
  /** @param {string} name */
  const section = (name) => el("div", { "data-testid": `behaviour-${name}` });
  const parts = { script: section("script"), conditions: section("conditions"), patterns: section("patterns"), events: section("events"), tuning: section("tuning"), sensors: section("sensors"), body: section("body") };
  const tuning = mountTuning(parts.tuning);
  const sensors = mountSensors(parts.sensors);
  const body = mountBody(parts.body);
  /** @type {string[]} */
  const events = [];
  /** @type {Robot | null} */
  let robot = null;
  let isLoading = false;
  replace(root, Object.entries(parts).map(([name, part]) => el("section", {}, el("h3", {}, words(name)), part)));

  async function load() {
    if (!robot || document.hidden || isLoading) return;
    const { name, mission_id: mission } = robot;
    isLoading = true;
    try {
      /** @type {[Trace, Mission | null]} */
      const [trace, answer] = await Promise.all([get(`/v1/robots/${id(name)}/trace?seconds=${WINDOW_S}`), mission ? get(`/v1/missions/${id(mission)}`) : null]);
      if (robot?.name === name) draw(robot, trace, answer?.progress?.find((one) => one.robot === name)?.packets ?? []);
    } catch (error) {
      show(parts.patterns, el("p", { class: "quiet" }, problemOf(error).message));
    }
    isLoading = false;
  }

  /** @param {Robot} current @param {Trace} trace @param {PacketProgress[]} packets */
  function draw(current, { at_s: now, stretches, conditions = [] }, packets) {
    const lines = packets.map((packet) => [badge(tone(packet.state), words(packet.state)), ` ${packet.description || packet.tag} `, quiet(packet.detail)]);
    showList(parts.script, lines, current.packet ? `${current.packet}, of its own` : "No script.");
    showList(parts.conditions, conditions.map((one) => [el("b", {}, one.holds === null ? "?" : one.holds ? "✓" : "✗"), ` ${one.when}: the robot ${one.words}`]), "No packet is under way.");
    show(parts.patterns, patternCharts(stretches, now));
  }

  const timer = setInterval(load, EVERY_MS);
  return {
    update(state) {
      const current = state.robots.find((one) => one.name === state.robot) ?? null;
      const isOther = current?.name !== robot?.name;
      if (isOther) {
        events.length = 0;
        sensors.setRobot(current?.name ?? null);
        body.setRobot(current?.name ?? null);
      }
      if (isOther || current?.packet !== robot?.packet) tuning.setRobot(current?.name ?? null, current?.packet ?? null);
      robot = current;
      if (isOther) load();
      showList(parts.events, events, "Nothing since this was opened.");
    },
    onEvent({ type, subject, data = {} }) {
      if (type === "world.changed" && subject === robot?.world) sensors.refresh();
      if (type?.startsWith("embodiment.") && subject === robot?.name) body.refresh();
      if (!robot || (subject !== robot.name && data.robot !== robot.name)) return;
      const details = [data.packet, ...(data.events ?? []), data.detail || data.reason].filter(Boolean).join(", ");
      events.unshift(`${data.at_s ? `${data.at_s.toFixed(1)} s ` : ""}${words(type)}: ${details}`);
      events.length = Math.min(events.length, MAX_EVENTS);
    },
    close: () => clearInterval(timer),
  };
}

/** @param {Element} part @param {Child[]} lines @param {string} fallback */
function showList(part, lines, fallback) {
  show(part, lines.length ? el("ol", { class: "small" }, lines.map((line) => el("li", {}, line))) : el("p", { class: "quiet" }, fallback));
}

/** A chart for each pattern and resultant of the last stretch. @param {TraceStretch[]} stretches @param {number} now */
function patternCharts(stretches, now) {
  const last = stretches.at(-1);
  if (!last) return el("p", { class: "quiet" }, "No pattern was active.");
  return [
    el("p", { class: "quiet small" }, `The last ${WINDOW_S} s: response −1 to 1 as a line, utility dashed.`),
    last.patterns.map(({ name, level }) => chart(name, level, samples(stretches, "patterns", (one) => one.patterns.findIndex((pattern) => pattern.name === name)), now)),
    last.dofs.map((dof) => chart(dof, "resultant", samples(stretches, "resultants", (one) => one.dofs.indexOf(dof)), now)),
  ];
}

/**
 * One pattern's or resultant's utilitors over all stretches that contain it.
 * @param {TraceStretch[]} stretches @param {"patterns" | "resultants"} field @param {(stretch: TraceStretch) => number} indexIn
 * @returns {[time: number, response: number, utility: number][]}
 */
function samples(stretches, field, indexIn) {
  return stretches.flatMap((stretch) => {
    const index = indexIn(stretch);
    return index < 0 ? [] : stretch.ticks.map((tick) => /** @type {[number, number, number]} */ ([tick.at_s, ...tick[field][index]]));
  });
}

/** @param {string} name @param {string} level @param {[time: number, response: number, utility: number][]} points @param {number} now */
function chart(name, level, points, now) {
  const [, response, utility] = points[points.length - 1];
  const label = `${words(name)}, ${level}: response ${response.toFixed(2)}, utility ${utility.toFixed(2)}`;
  /** @type {[number, number][][]} */
  const series = [points.map(([time, value]) => [time, value]), points.map(([time, , value]) => [time, value])];
  return el("figure", { class: level === "resultant" ? "resultant" : null }, el("figcaption", { class: "small" }, label), stripChart(label, series, [now - WINDOW_S, now], [-1, 1]));
}
