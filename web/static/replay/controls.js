// Plays a recording: scrubbed or at a speed, in the plan's picture and on a map together.

import { el } from "../page/dom.js";
import { seconds } from "../page/format.js";
import { createEvents } from "./events.js";

const SPEEDS = [1, 2, 5, 10, 20, 50];

// `more`: what else stands in the row of controls. `onRobots` hears what robots told at the instant that is shown.
export function createControls({ recording, drawing, picture, more = [], onRobots = () => {} }) {
  let playing = null;
  let time = recording.from;
  const events = createEvents(recording, (at, which) => (pause(), seek(at, which)));
  const clock = el("span", { class: "number", "data-testid": "replay-clock" });
  const slider = el("input", { type: "range", min: 0, max: recording.to - recording.from, step: 0.1, "aria-label": "Time", "data-testid": "replay-time", title: "Arrow keys: a second; Page keys: an event; Space: play", oninput: () => seek(recording.from + slider.valueAsNumber), onkeydown: key });
  const speed = el("select", { "aria-label": "Speed" }, SPEEDS.map((times) => el("option", { value: times }, `×${times}`)));
  const button = el("button", { type: "button", class: "primary", "data-testid": "replay-play", onclick: toggle }, "Play");
  const jumps = [["‹", "Event before", -1], ["›", "Next event", 1]].map(([sign, label, by]) => el("button", { type: "button", "aria-label": label, title: label, onclick: () => events.step(by) }, sign));

  function seek(at, which) {
    if (at < time) drawing.forgetTrails();
    time = Math.min(Math.max(at, recording.from), recording.to);
    const mission = recording.mission(time);
    const robots = recording.robots(time);
    drawing.samples(recording.samples(time));
    drawing.robots(robots);
    onRobots(robots, time);
    // As it stood then it had not ended.
    picture.happens(mission && { ...mission, ended_at_s: null }, time);
    slider.value = time - recording.from;
    clock.textContent = `${seconds(time - recording.from)} of ${seconds(recording.to - recording.from)}`;
    slider.setAttribute("aria-valuetext", clock.textContent);
    events.show(time, which);
  }

  function key(event) {
    const moves = { ArrowLeft: () => seek(time - 1), ArrowRight: () => seek(time + 1), PageUp: () => events.step(-1), PageDown: () => events.step(1), " ": toggle };
    if (!moves[event.key]) return;
    event.preventDefault();
    moves[event.key]();
  }

  function toggle() {
    if (playing) pause();
    else play();
  }

  function play() {
    if (time >= recording.to) seek(recording.from);
    button.textContent = "Pause";
    let last = performance.now();
    const tick = (now) => {
      if (!playing) return;
      seek(time + ((now - last) / 1000) * Number(speed.value));
      last = now;
      if (time >= recording.to) pause();
      else playing = requestAnimationFrame(tick);
    };
    playing = requestAnimationFrame(tick);
  }

  function pause() {
    if (playing) cancelAnimationFrame(playing);
    playing = null;
    button.textContent = "Play";
  }

  seek(recording.from);
  const line = el("div", { class: "time-line" }, slider, events.strip);
  return { nodes: [el("div", { class: "row player-row" }, button, jumps, line, clock, speed, more), events.list], pause, focus: () => button.focus({ preventScroll: true }) };
}
