// The middle pane's mission: robots' progress, time against the estimate, results and messages.

import { id } from "../page/api.js";
import { badge, byId, el, quiet, replace, show } from "../page/dom.js";
import { seconds, tone, words } from "../page/format.js";
import { part } from "../page/part.js";
import { attempt, commandButton, problemBox } from "../page/problem.js";
import { policyChoice, recovery } from "./recovery.js";
import { ENDED, elapsed, silences } from "./timing.js";

/** @typedef {{refresh: () => void, replay: (mission: Mission) => Promise<unknown>}} Actions */

const fetchResults = part(() => import("./results.js"), "results");
const fetchBeside = part(() => import("./beside.js"));
const fetchMessages = part(() => import("./messages.js"), "speech");

/** @param {Store} store @param {Actions} actions */
export function mountMission(store, actions) {
  const container = byId("mission", HTMLElement);
  const clock = el("div", { class: "clock" });
  const results = el("div");
  const messages = createMessages();
  const problem = el("div", { role: "alert" });
  const head = el("div");
  const robots = el("div");
  const card = el("article", { class: "card mission", "data-testid": "mission" }, head, problem, clock, robots, results, messages.node);
  let drawn = "";
  store.subscribe((state) => {
    const { mission } = state;
    const key = JSON.stringify(mission);
    if (key !== drawn) {
      drawn = key;
      show(problem);
      if (mission) {
        drawHead(head, mission, problem, actions);
        show(robots, (mission.progress ?? []).map(robotProgress));
      }
      if (card.isConnected !== Boolean(mission)) replace(container, mission && card); // to move it would take the focus from a message
    }
    if (!mission) return;
    if (mission.results) fetchResults().then((module) => module.showResults(results, mission), (error) => show(results, problemBox(error)));
    else {
      results.dataset.of = "";
      show(results);
    }
    messages.show(mission);
    show(clock, progress(mission, state.worldTimes[mission.world]), silenceNotes(mission, state));
  });
}

/** The mission's messages, which are requested while they are open, and the diagram's modules with them. */
function createMessages() {
  const body = el("div");
  const node = el("details", { "data-testid": "mission-speech", ontoggle: draw }, el("summary", {}, "Messages"), body);
  /** @type {Mission | null} */
  let mission = null;

  async function draw() {
    if (!node.open) return;
    try {
      const { showMessages } = await fetchMessages();
      if (mission) await showMessages(body, mission);
    } catch (error) {
      replace(body, problemBox(error));
    }
  }

  return {
    node,
    /** @param {Mission} shown */
    show(shown) {
      if (mission?.id !== shown.id) replace(body);
      mission = shown;
      draw();
    },
  };
}

/** The mission's state and its commands; the command that has the focus keeps it. @param {Element} node @param {Mission} mission @param {Element} problem @param {Actions} actions */
function drawHead(node, mission, problem, { refresh, replay }) {
  const hasEnded = ENDED.includes(mission.state);
  const beside = mission.joined_goals?.length || mission.better_plan ? el("div") : null;
  if (beside) fetchBeside().then((module) => module.showBeside(beside, mission, problem, refresh), (error) => show(beside, problemBox(error)));
  const focused = document.activeElement instanceof HTMLElement && node.contains(document.activeElement) ? document.activeElement.dataset.testid : undefined;
  replace(
    node,
    el(
      "div",
      { class: "head" },
      el("h3", {}, "Mission"),
      badge(tone(mission.state), words(mission.state), { "data-testid": "mission-state" }),
      mission.failure && mission.failure !== mission.state ? badge("bad", words(mission.failure), { title: "what failed" }) : null,
      el("span", { class: "spring" }),
      hasEnded ? el("button", { "data-testid": "mission-replay", onclick: () => attempt([], problem, () => replay(mission)) }, "Replay") : controls(mission, problem, refresh),
    ),
    mission.reason ? el("p", { class: "note" }, mission.reason) : null,
    beside,
    recovery(mission),
    hasEnded ? null : policyChoice(mission, problem, refresh),
  );
  if (focused) /** @type {HTMLElement | null} */ (node.querySelector(`[data-testid="${focused}"]`))?.focus({ preventScroll: true });
}

/** @param {Mission} mission @param {Element} problem @param {() => void} refresh @returns {Child} */
function controls(mission, problem, refresh) {
  if (mission.cancel_requested) return badge("warn", "being cancelled: waits for its robots", { "data-testid": "mission-ending" });
  const isStuck = mission.recovery?.step === "stuck" && mission.state !== "paused";
  const first = isStuck ? ["resume", "Try again"] : mission.state === "paused" ? ["resume", "Resume"] : ["pause", "Pause"];
  /** @param {HTMLButtonElement} button */
  const done = (button) => {
    button.disabled = false; // an unchanged mission is not drawn again
    refresh();
  };
  return [first, ["cancel", "Cancel"]].map(([verb, label]) =>
    commandButton(label, `/v1/missions/${id(mission.id)}:${verb}`, problem, done, { class: verb === "cancel" ? "danger" : null, "data-testid": `mission-${verb}` }));
}

/** @param {Mission} mission @param {number} worldTime */
function progress(mission, worldTime) {
  const spent = elapsed(mission, worldTime);
  const { estimate_s: estimate, original_estimate_s: original, enquire_at_s: enquiry, deadline_s: deadline } = mission;
  const share = spent === null || !estimate ? 0 : spent / estimate;
  const isChanged = typeof original === "number" && Math.abs(original - estimate) > 0.05;
  const isAsked = typeof enquiry === "number" && spent !== null && !ENDED.includes(mission.state);
  return [
    el("progress", { max: 1, value: Math.min(1, share), class: share > 1 ? "late" : null }),
    el(
      "p",
      { class: "small" },
      `${seconds(spent)} of ${seconds(estimate)} estimated`,
      isChanged ? ` (at first ${seconds(original)})` : "",
      isAsked ? `; robots are asked after ${seconds(enquiry - mission.started_at_s)}` : "",
      typeof deadline === "number" && spent !== null ? `; due at ${seconds(deadline - mission.started_at_s)}` : "",
    ),
  ];
}

/** What is shown of a silent robot is as old as its last message. @param {Mission} mission @param {State} state */
function silenceNotes(mission, state) {
  return silences(mission, state.robots, state.worldTimes[mission.world]).map((silence) => el(
    "p",
    { class: "small silence", "data-testid": "silence" },
    badge(silence.tone, `${silence.robot} ${silence.word}`),
    ` ${silence.note}; below is what was known then`,
  ));
}

/** @param {ScriptProgress} script */
function robotProgress(script) {
  return el(
    "div",
    { class: "script" },
    el(
      "div",
      { class: "script-head" },
      el("b", {}, script.robot),
      badge(tone(script.state), words(script.state ?? script.delivery ?? "waiting")),
      script.order ? el("span", { class: "quiet small" }, `told to ${script.order}, no answer yet`) : null,
      script.lost ? badge("bad", "lost") : null,
    ),
    el("ol", { class: "packets" }, (script.packets ?? []).map((packet) => packetItem(packet, isAborted(script, packet)))),
  );
}

/** @param {PacketProgress} packet @param {boolean} aborted */
function packetItem(packet, aborted) {
  return el(
    "li",
    { class: `packet ${aborted ? "" : tone(packet.state)}`, title: packet.description ?? "", "data-state": packet.state },
    el("b", {}, packet.tag),
    el("span", {}, aborted ? "broken off" : words(packet.state)),
    quiet(timing(packet)),
    packet.delegated_to ? el("span", { class: "waits" }, `by ${packet.delegated_to}`) : null,
    packet.waits_for?.length ? el("span", { class: "waits" }, `waits for ${packet.waits_for.join(", ")}`) : null,
  );
}

/** A stopped robot reports nothing more of the packet it was executing. @param {ScriptProgress} script @param {PacketProgress} packet */
function isAborted(script, packet) {
  return ["cancelled", "failed"].includes(script.state) && ["initializing", "running", "paused"].includes(packet.state);
}

/** @param {PacketProgress} packet */
function timing(packet) {
  if (typeof packet.started_at_s !== "number") return `due ${seconds(packet.expected_start_s)}`;
  if (typeof packet.finished_at_s !== "number") return `of ${seconds(packet.expected_duration_s)}`;
  return `${seconds(packet.finished_at_s - packet.started_at_s)} of ${seconds(packet.expected_duration_s)}`;
}
