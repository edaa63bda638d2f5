// Driving a robot by hand. Set-points go out while control is held; without them the robot stops by itself, so whatever
// takes the operator's eye or hand off the page lets go of it, too.

import { id, post } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";

const EVERY_MS = 200;
const UNHEARD_S = 1.5;
const SHARES = { slow: 0.4, medium: 0.7, full: 1 };
// Ahead and to the left, by key; WASD is where these keys lie, whatever the keyboard's language.
const AHEAD = [1, 0], BACK = [-1, 0], LEFT = [0, 1], RIGHT = [0, -1];
const WAYS = { ArrowUp: AHEAD, KeyW: AHEAD, ArrowDown: BACK, KeyS: BACK, ArrowLeft: LEFT, KeyA: LEFT, ArrowRight: RIGHT, KeyD: RIGHT };
const PAD = { ArrowUp: ["▲", "ahead"], ArrowLeft: ["◀", "left"], ArrowDown: ["▼", "back"], ArrowRight: ["▶", "right"] };

export function mountDrive(root, store) {
  const held = new Set();
  const gone = new AbortController();
  let [robot, session, timer, limits] = [null, null, null, { most_m_s: 0.3, most_rad_s: 1 }];
  const state = el("p", { role: "status", "data-testid": "drive-state" }, "Not driven.");
  const speed = el("select", { onchange: () => tell(state.textContent) }, Object.keys(SHARES).map((name) => el("option", { selected: name === "medium" }, name)));
  const limit = el("span", { class: "quiet small" });
  const keys = Object.entries(PAD).map(([key, [sign, name]]) => el("button", {
    type: "button", class: `pad-${name}`, "aria-label": name, tabindex: -1,
    onpointerdown: (event) => { event.target.setPointerCapture(event.pointerId); press(key); },
    onlostpointercapture: () => lift(key),
  }, sign));
  const stop = el("button", { type: "button", class: "stop", "data-testid": "drive-stop", onclick: () => end("Stopped.") }, "STOP");
  const pad = el("div", { class: "pad", tabindex: 0, role: "group", "aria-label": "Arrow keys or W A S D drive, escape stops", "data-testid": "drive-pad", onkeydown: down, onkeyup: (event) => lift(event.code), onfocusout: (event) => pad.contains(event.relatedTarget) || held.clear() }, keys);
  const take = el("button", { type: "button", class: "primary", "data-testid": "drive-take", onclick: () => (session ? end("Released.") : begin()) });
  replace(root, el("div", { class: "head" }, take, el("label", {}, "Speed ", speed), limit), state, el("div", { class: "drive" }, pad, stop),
    el("p", { class: "quiet small" }, "Keys count while the pad has the focus. What is in the robot's way still counts, and it stops half a second after the last word from here."));

  function begin() {
    robot = store.get().robot;
    session = `page-${crypto.getRandomValues(new Uint32Array(1))[0].toString(16)}`;
    timer = setInterval(send, EVERY_MS);
    pad.focus();
    send();
  }

  async function send() {
    const mine = session;
    const wish = (axis) => Math.sign([...held].reduce((sum, key) => sum + WAYS[key][axis], 0)) * SHARES[speed.value];
    try {
      const told = await post(`/v1/robots/${id(robot)}:teleoperate`, { session, speed_m_s: wish(0) * limits.most_m_s, turn_rad_s: wish(1) * limits.most_rad_s });
      if (session !== mine) return;
      limits = told;
      const unheard = told.last_heard_s > UNHEARD_S && `No word from ${robot} for ${told.last_heard_s.toFixed(1)} s: it stops by itself.`;
      tell(unheard || (told.driving ? `You drive ${robot}.` : `Waiting for ${robot}…`));
    } catch (problem) {
      if (session === mine) end(`Stopped: ${problem.message}.`);
    }
  }

  function end(why) {
    if (!session) return;
    clearInterval(timer);
    held.clear();
    post(`/v1/robots/${id(robot)}:end_teleoperation`, { session }).catch(() => {}); // it stops by itself
    session = null;
    tell(why);
  }

  function press(key) {
    if (!session || held.has(key)) return;
    held.add(key);
    send();
  }

  function lift(key) {
    if (held.delete(key) && session) send();
  }

  function down(event) {
    if (event.code === "Escape") end("Stopped.");
    if (!WAYS[event.code]) return;
    press(event.code);
    event.preventDefault();
  }

  function tell(words) {
    show(state, words);
    take.textContent = session ? "Release control" : `Take control of ${store.get().robot ?? "a robot"}`;
    stop.disabled = !session;
    pad.classList.toggle("held", Boolean(session));
    const most = (fastest) => (SHARES[speed.value] * fastest).toFixed(2);
    show(limit, `at most ${most(limits.most_m_s)} m/s, ${most(limits.most_rad_s)} rad/s`);
  }

  document.addEventListener("visibilitychange", () => document.hidden && end("Stopped: the page was hidden."), gone);
  for (const event of ["blur", "pagehide"]) addEventListener(event, () => end("Stopped: the page lost the focus."), gone);
  return {
    update({ robot: chosen, robots }) {
      if (session && chosen !== robot) end("Released: another robot was chosen.");
      take.disabled = !chosen;
      const by = robots.find((one) => one.name === chosen)?.driven_by;
      tell(!session && by ? `${by} drives ${chosen}.` : state.textContent);
    },
    close() {
      end("Released.");
      gone.abort();
    },
  };
}
