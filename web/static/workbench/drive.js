// Drives a robot by hand. Set-points are sent while control is held; without them the robot stops by itself, so control is
// released whenever the operator leaves the page.

import { id, post, problemOf } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";

const SEND_EVERY_MS = 200;
const SILENT_AFTER_S = 1.5;
/** @type {Record<string, number>} shares of the robot's limits */
const SPEEDS = { slow: 0.4, medium: 0.7, full: 1 };
const AHEAD = { ahead: 1, left: 0 };
const BACK = { ahead: -1, left: 0 };
const LEFT = { ahead: 0, left: 1 };
const RIGHT = { ahead: 0, left: -1 };
/** By the key's position, whatever the keyboard's language. @type {Record<string, {ahead: number, left: number}>} */
const DIRECTIONS = { ArrowUp: AHEAD, KeyW: AHEAD, ArrowDown: BACK, KeyS: BACK, ArrowLeft: LEFT, KeyA: LEFT, ArrowRight: RIGHT, KeyD: RIGHT };
const PAD = { ArrowUp: ["▲", "ahead"], ArrowLeft: ["◀", "left"], ArrowDown: ["▼", "back"], ArrowRight: ["▶", "right"] };

/** @param {Element} root @param {Store} store @returns {WorkbenchPart} */
export function mount(root, store) {
  /** @type {Set<string>} */
  const heldKeys = new Set();
  const closed = new AbortController();
  /** The robot that is driven. @type {{robot: string, session: string, timer: number} | null} */
  let drive = null;
  let limits = { most_m_s: 0.3, most_rad_s: 1 };
  const state = el("p", { role: "status", "data-testid": "drive-state" }, "Not driven.");
  const speed = el("select", { onchange: () => showState(state.textContent) }, Object.keys(SPEEDS).map((name) => el("option", { selected: name === "medium" }, name)));
  const limit = el("span", { class: "quiet small" });
  const stop = el("button", { class: "stop", "data-testid": "drive-stop", onclick: () => end("Stopped.") }, "STOP");
  const pad = el("div", { class: "pad", tabindex: 0, role: "group", "aria-label": "Arrow keys or W A S D drive, escape stops", "data-testid": "drive-pad", onkeydown: onKeyDown, onkeyup: (event) => release(event.code) }, Object.entries(PAD).map(padButton));
  pad.addEventListener("focusout", ({ relatedTarget }) => {
    if (!(relatedTarget instanceof Node && pad.contains(relatedTarget))) heldKeys.clear();
  });
  const take = el("button", { class: "primary", "data-testid": "drive-take", onclick: () => (drive ? end("Released.") : begin()) });
  replace(
    root,
    el("div", { class: "head" }, take, el("label", {}, "Speed ", speed), limit),
    state,
    el("div", { class: "drive" }, pad, stop),
    el("p", { class: "quiet small" }, "Keys count while the pad has the focus. The robot still avoids obstacles, and it stops half a second after the last command from here."),
  );

  /** @param {[string, string[]]} entry */
  function padButton([key, [sign, name]]) {
    const button = el("button", { class: `pad-${name}`, "aria-label": name, tabindex: -1, onlostpointercapture: () => release(key) }, sign);
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      press(key);
    });
    return button;
  }

  function begin() {
    const { robot } = store.get();
    if (!robot) return;
    drive = { robot, session: `page-${crypto.getRandomValues(new Uint32Array(1))[0].toString(16)}`, timer: setInterval(send, SEND_EVERY_MS) };
    pad.focus();
    send();
  }

  async function send() {
    if (!drive) return;
    const { robot, session } = drive;
    /** @param {"ahead" | "left"} axis */
    const share = (axis) => Math.sign([...heldKeys].reduce((sum, key) => sum + DIRECTIONS[key][axis], 0)) * SPEEDS[speed.value];
    try {
      /** @type {TeleoperationState} */
      const answer = await post(`/v1/robots/${id(robot)}:teleoperate`, { session, speed_m_s: share("ahead") * limits.most_m_s, turn_rad_s: share("left") * limits.most_rad_s });
      if (drive?.session !== session) return;
      limits = answer;
      if (answer.last_heard_s > SILENT_AFTER_S) showState(`No message from ${robot} for ${answer.last_heard_s.toFixed(1)} s: it stops by itself.`);
      else showState(answer.driving ? `You drive ${robot}.` : `Waiting for ${robot}…`);
    } catch (error) {
      if (drive?.session === session) end(`Stopped: ${problemOf(error).message}.`);
    }
  }

  /** @param {string} reason */
  function end(reason) {
    if (!drive) return;
    const { robot, session, timer } = drive;
    clearInterval(timer);
    heldKeys.clear();
    post(`/v1/robots/${id(robot)}:end_teleoperation`, { session }).catch(() => {}); // the robot stops by itself anyway
    drive = null;
    showState(reason);
  }

  /** @param {string} key */
  function press(key) {
    if (!drive || heldKeys.has(key)) return;
    heldKeys.add(key);
    send();
  }

  /** @param {string} key */
  function release(key) {
    if (heldKeys.delete(key)) send();
  }

  /** @param {KeyboardEvent} event */
  function onKeyDown(event) {
    if (event.code === "Escape") end("Stopped.");
    if (!DIRECTIONS[event.code]) return;
    press(event.code);
    event.preventDefault();
  }

  /** @param {string | null} text */
  function showState(text) {
    show(state, text);
    take.textContent = drive ? "Release control" : `Take control of ${store.get().robot ?? "a robot"}`;
    stop.disabled = !drive;
    pad.classList.toggle("held", drive !== null);
    const share = SPEEDS[speed.value];
    show(limit, `at most ${(share * limits.most_m_s).toFixed(2)} m/s, ${(share * limits.most_rad_s).toFixed(2)} rad/s`);
  }

  document.addEventListener("visibilitychange", () => document.hidden && end("Stopped: the page was hidden."), closed);
  for (const type of ["blur", "pagehide"]) addEventListener(type, () => end("Stopped: the page lost the focus."), closed);
  return {
    update({ robot, robots }) {
      if (drive && robot !== drive.robot) end("Released: another robot was chosen.");
      take.disabled = !robot;
      const driver = robots.find((one) => one.name === robot)?.driven_by;
      showState(!drive && driver ? `${driver} drives ${robot}.` : state.textContent);
    },
    close() {
      end("Released.");
      closed.abort();
    },
  };
}
