// The middle column's mission: how far each robot's script has come, and how long it takes against the estimate.

import { id, post } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { seconds, tone, words } from "../page/format.js";
import { asking } from "../page/problem.js";
import { unheardOn } from "../robots/contact.js";
import { elapsed } from "./elapsed.js";
import { policy, recovery } from "./recovery.js";

const ENDED = ["completed", "partially_completed", "failed", "cancelled"];

export function mountMission(store, { refresh, replay }) {
  const container = document.getElementById("mission");
  const clock = el("div", { class: "clock" });
  const problem = el("div", { role: "alert" });
  let drawn = null;
  store.subscribe((state) => {
    const mission = state.mission;
    const key = JSON.stringify(mission);
    if (key !== drawn) {
      drawn = key;
      show(problem);
      replace(container, mission ? card(mission, clock, problem, refresh, replay) : null);
    }
    if (mission) show(clock, progress(mission, state.worldTimes[mission.world]), silences(mission, state));
  });
}

function card(mission, clock, problem, refresh, replay) {
  return el(
    "article",
    { class: "card mission", "data-testid": "mission" },
    el(
      "div",
      { class: "head" },
      el("h3", {}, "Mission"),
      el("span", { class: `badge ${tone(mission.state)}`, "data-testid": "mission-state" }, words(mission.state)),
      mission.failure && mission.failure !== mission.state ? el("span", { class: "badge bad", title: "what went wrong" }, words(mission.failure)) : null,
      el("span", { class: "spring" }),
      ENDED.includes(mission.state) ? el("button", { type: "button", "data-testid": "mission-replay", onclick: () => replay(mission) }, "Replay") : null,
      controls(mission, problem, refresh),
    ),
    mission.reason ? el("p", { class: "note" }, mission.reason) : null,
    recovery(mission),
    ENDED.includes(mission.state) ? null : policy(mission, problem, refresh),
    problem,
    clock,
    (mission.progress ?? []).map(robotProgress),
  );
}

function controls(mission, problem, refresh) {
  if (ENDED.includes(mission.state)) return null;
  if (mission.cancel_requested) return el("span", { class: "badge warn", "data-testid": "mission-ending" }, "being cancelled: waits for its robots");
  const isStuck = mission.recovery?.step === "stuck" && mission.state !== "paused";
  const turn = isStuck ? ["resume", "Try again"] : mission.state === "paused" ? ["resume", "Resume"] : ["pause", "Pause"];
  return [turn, ["cancel", "Cancel"]].map(([verb, label]) => el(
    "button",
    {
      type: "button",
      class: verb === "cancel" ? "danger" : null,
      "data-testid": `mission-${verb}`,
      onclick: async (event) => {
        const button = event.currentTarget;
        await asking([button], problem, () => post(`/v1/missions/${id(mission.id)}:${verb}`));
        button.disabled = false; // what it asked for may take its time, and nothing be drawn anew
        refresh();
      },
    },
    label,
  ));
}

function progress(mission, worldTime) {
  const spent = elapsed(mission, worldTime);
  const estimate = mission.estimate_s;
  const share = spent === null || !estimate ? 0 : spent / estimate;
  const [asked, due] = [mission.enquire_at_s, mission.deadline_s];
  const changed = typeof mission.original_estimate_s === "number" && Math.abs(mission.original_estimate_s - estimate) > 0.05;
  return [
    el("progress", { max: 1, value: Math.min(1, share), class: share > 1 ? "late" : null }),
    el(
      "p",
      { class: "small" },
      `${seconds(spent)} of ${seconds(estimate)} estimated`,
      changed ? ` (at first ${seconds(mission.original_estimate_s)})` : "",
      typeof asked === "number" && spent !== null && !ENDED.includes(mission.state)
        ? `; robots are asked after ${seconds(asked - mission.started_at_s)}`
        : "",
      typeof due === "number" && spent !== null ? `; due at ${seconds(due - mission.started_at_s)}` : "",
    ),
  ];
}

// What the robots at work are believed to do is as old as the last word of them.
function silences(mission, state) {
  return unheardOn(mission, state.robots, state.worldTimes[mission.world]).map(({ robot, tone, word, note }) => el("p", { class: "small silence", "data-testid": "silence" }, el("span", { class: `badge ${tone}` }, `${robot} ${word}`), ` ${note}; below is what was known then`));
}

function robotProgress(script) {
  return el(
    "div",
    { class: "script" },
    el(
      "div",
      { class: "script-head" },
      el("b", {}, script.robot),
      el("span", { class: `badge ${tone(script.state)}` }, words(script.state ?? script.delivery ?? "waiting")),
      script.order ? el("span", { class: "quiet small" }, `told to ${script.order}, no answer yet`) : null,
      script.lost ? el("span", { class: "badge bad" }, "lost") : null,
    ),
    el("ol", { class: "packets" }, (script.packets ?? []).map((packet) => el(
      "li",
      { class: `packet ${isBrokenOff(script, packet) ? "" : tone(packet.state)}`, title: packet.description ?? "", "data-state": packet.state },
      el("b", {}, packet.tag),
      el("span", {}, isBrokenOff(script, packet) ? "broken off" : words(packet.state)),
      el("span", { class: "quiet" }, timing(packet)),
      packet.waits_for?.length ? el("span", { class: "waits" }, `waits for ${packet.waits_for.join(", ")}`) : null,
    ))),
  );
}

// A robot that was stopped says nothing more of the packet that it was at.
function isBrokenOff(script, packet) {
  return ["cancelled", "failed"].includes(script.state) && ["initializing", "running", "paused"].includes(packet.state);
}

function timing(packet) {
  if (typeof packet.started_at_s !== "number") return `due ${seconds(packet.expected_start_s)}`;
  if (typeof packet.finished_at_s !== "number") return `of ${seconds(packet.expected_duration_s)}`;
  return `${seconds(packet.finished_at_s - packet.started_at_s)} of ${seconds(packet.expected_duration_s)}`;
}
