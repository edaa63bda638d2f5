// Plays a recording at a chosen speed or scrubbed, in the plan's picture and on a map together, beside the list of its events,
// what robots said and what they believed.

import { resultList } from "../mission/results.js";
import { el, quiet, show, svg } from "../page/dom.js";
import { seconds, words } from "../page/format.js";
import { createMessages } from "./messages.js";
import { createMinds } from "./minds.js";

const SPEEDS = [1, 2, 5, 10, 20, 50];

/**
 * @param {object} parts
 * @param {Recording} parts.recording @param {WorldDrawing} parts.drawing @param {Picture} parts.picture
 * @param {Node[]} [parts.more] further controls in the same row
 * @param {(robots: Record<string, RobotTelemetry>, time: number) => void} [parts.onSeek] receives the telemetry at the shown instant
 */
export function createControls({ recording, drawing, picture, more = [], onSeek = () => {} }) {
  const duration = recording.to - recording.from;
  /** @type {number | null} */
  let animation = null;
  let time = recording.from;
  const events = createEvents(recording, (at, index) => {
    pause();
    seek(at, index);
  });
  const results = el("div");
  const minds = createMinds(recording);
  const messages = createMessages(recording);
  let shown = 0;
  const clock = el("span", { class: "number", "data-testid": "replay-clock" });
  const slider = el("input", { type: "range", min: 0, max: duration, step: 0.1, "aria-label": "Time", "data-testid": "replay-time", title: "Arrow keys: a second; Page keys: an event; Space: play", onkeydown: onKey });
  slider.addEventListener("input", () => seek(recording.from + slider.valueAsNumber));
  const speed = el("select", { "aria-label": "Speed" }, SPEEDS.map((factor) => el("option", { value: factor }, `×${factor}`)));
  const button = el("button", { class: "primary", "data-testid": "replay-play", onclick: toggle }, "Play");
  /** @param {string} sign @param {string} label @param {number} by */
  const jump = (sign, label, by) => el("button", { "aria-label": label, title: label, onclick: () => events.step(by) }, sign);

  /** @param {number} at @param {number} [eventIndex] */
  function seek(at, eventIndex) {
    if (at < time) drawing.clearTrails();
    time = Math.min(Math.max(at, recording.from), recording.to);
    const mission = recording.mission(time);
    const robots = recording.robots(time);
    drawing.showSamples(recording.samples(time));
    drawing.showRobots(robots);
    onSeek(robots, time);
    picture.showProgress(mission && { ...mission, ended_at_s: null }, time); // at that time it had not ended
    slider.value = String(time - recording.from);
    clock.textContent = `${seconds(time - recording.from)} of ${seconds(duration)}`;
    slider.setAttribute("aria-valuetext", clock.textContent);
    events.show(time, eventIndex);
    minds.show(time);
    messages.show(time);
    const brought = recording.results.filter((one) => one.at_s <= time);
    if (brought.length !== shown) show(results, resultList(brought, (/** @type {RecordedResult} */ one) => one.image ?? "", (one) => seconds(one.at_s - recording.from)));
    shown = brought.length;
  }

  /** @param {KeyboardEvent} event */
  function onKey(event) {
    if (event.key === "ArrowLeft") seek(time - 1);
    else if (event.key === "ArrowRight") seek(time + 1);
    else if (event.key === "PageUp") events.step(-1);
    else if (event.key === "PageDown") events.step(1);
    else if (event.key === " ") toggle();
    else return;
    event.preventDefault();
  }

  function toggle() {
    if (animation === null) play();
    else pause();
  }

  function play() {
    if (time >= recording.to) seek(recording.from);
    button.textContent = "Pause";
    let last = performance.now();
    /** @param {number} now */
    const tick = (now) => {
      if (animation === null) return;
      seek(time + ((now - last) / 1000) * Number(speed.value));
      last = now;
      if (time >= recording.to) pause();
      else animation = requestAnimationFrame(tick);
    };
    animation = requestAnimationFrame(tick);
  }

  function pause() {
    if (animation !== null) cancelAnimationFrame(animation);
    animation = null;
    button.textContent = "Play";
  }

  seek(recording.from);
  const line = el("div", { class: "time-line" }, slider, events.marks);
  const row = el("div", { class: "row player-row" }, button, jump("‹", "Event before", -1), jump("›", "Next event", 1), line, clock, speed, more);
  return { nodes: [row, results, events.list, minds.node, messages.node], pause, focus: () => button.focus({ preventScroll: true }) };
}

/** The class of an event's mark, by the first word of its type. @type {Record<string, string>} */
const MARKS = { plan: "decided", goal: "decided", mission: "decided", packet: "done", script: "done" };

/**
 * The list of events that follows the recording, and their marks along its time line.
 * @param {Recording} recording @param {(at: number, index?: number) => void} seek called with the instant of a chosen event
 */
function createEvents(recording, seek) {
  const list = el("ol", { class: "events", "aria-label": "What happened" }, recording.events.map(item));
  const marks = svg("svg", { viewBox: "0 0 1000 6", preserveAspectRatio: "none", class: "event-marks", "aria-hidden": "true" }, recording.events.map(mark));
  let current = -1;
  /** @param {number} index */
  const buttonAt = (index) => list.children[index]?.querySelector("button");

  /** @param {RecordedEvent} event */
  function item({ at_s: at, type, data = {} }) {
    const after = at - recording.from;
    const about = [data.robot, data.packet, data.of, data.actor, data.source, data.text, data.reason, data.detail].filter(Boolean).join(" · ");
    return el("li", {}, el(
      "button",
      { tabindex: -1, onclick: () => seek(at) },
      el("span", { class: "number quiet" }, `${after < 0 ? "−" : ""}${seconds(Math.abs(after))}`),
      ` ${words(type.replace(".", ": "))}`,
      about ? quiet(` ${about}`) : null,
    ));
  }

  /** @param {RecordedEvent} event */
  function mark({ at_s: at, type }) {
    const share = (at - recording.from) / (recording.to - recording.from || 1);
    return share < 0 ? null : svg("rect", { x: 1000 * share, y: 0, width: 2, height: 6, class: MARKS[type.split(".")[0]] ?? "other" });
  }

  /** Go to the event that is `by` places after the current one. @param {number} by */
  function step(by) {
    const index = Math.min(recording.events.length - 1, Math.max(0, current + by));
    if (recording.events[index]) seek(recording.events[index].at_s, index);
    return buttonAt(index);
  }

  list.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowDown" && event.key !== "ArrowUp") return;
    event.preventDefault();
    step(event.key === "ArrowDown" ? 1 : -1)?.focus();
  });
  return {
    list,
    marks,
    step,
    /** Mark the last event at that instant; `index` tells which of several. @param {number} time @param {number} index */
    show(time, index = recording.event(time)) {
      if (index === current) return;
      list.children[current]?.removeAttribute("aria-current");
      buttonAt(current)?.setAttribute("tabindex", "-1");
      current = index;
      const line = list.children[current];
      line?.setAttribute("aria-current", "true");
      (buttonAt(current) ?? buttonAt(0))?.setAttribute("tabindex", "0");
      list.scrollTop = line instanceof HTMLElement ? line.offsetTop - list.clientHeight + line.offsetHeight : 0;
    },
  };
}
