// The middle column's mission: how far each robot's script has come, and how long it takes against the estimate.

import { id, post } from "./api.js";
import { el, replace, show } from "./dom.js";
import { seconds, tone, words } from "./format.js";
import { problemBox } from "./problem.js";
import { recovery } from "./recovery.js";

const ENDED = ["completed", "partially_completed", "failed", "cancelled"];

export function mountMission(store, { refresh }) {
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
      replace(container, mission ? card(mission, clock, problem, refresh) : null);
    }
    if (mission) show(clock, progress(mission, state.worldTimes[mission.world]));
  });
}

export function elapsed(mission, worldTime) {
  if (typeof mission.started_at_s !== "number") return null;
  const now = typeof mission.ended_at_s === "number" ? mission.ended_at_s : worldTime;
  return typeof now === "number" ? Math.max(0, now - mission.started_at_s) : null;
}

function card(mission, clock, problem, refresh) {
  return el(
    "article",
    { class: "card mission", "data-testid": "mission" },
    el(
      "div",
      { class: "head" },
      el("h3", {}, "Mission"),
      el("span", { class: `badge ${tone(mission.state)}`, "data-testid": "mission-state" }, words(mission.state)),
      el("span", { class: "spring" }),
      controls(mission, problem, refresh),
    ),
    mission.reason ? el("p", { class: "note" }, mission.reason) : null,
    mission.failure ? el("p", { class: "note" }, `Failure: ${words(mission.failure)}`) : null,
    recovery(mission),
    problem,
    clock,
    (mission.progress ?? []).map(robotProgress),
  );
}

function controls(mission, problem, refresh) {
  if (ENDED.includes(mission.state)) return null;
  const again = mission.state === "paused" || mission.recovery?.step === "stuck";
  const verbs = [again ? "resume" : "pause", "cancel"];
  return verbs.map((verb) => el(
    "button",
    {
      type: "button",
      class: verb === "cancel" ? "danger" : null,
      "data-testid": `mission-${verb}`,
      onclick: async (event) => {
        event.currentTarget.disabled = true;
        const button = event.currentTarget;
        try {
          await post(`/v1/missions/${id(mission.id)}:${verb}`);
        } catch (error) {
          show(problem, problemBox(error));
        }
        button.disabled = false;
        refresh();
      },
    },
    words(verb),
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
      { class: `packet ${tone(packet.state)}`, title: packet.description ?? "", "data-state": packet.state },
      el("b", {}, packet.tag),
      el("span", {}, words(packet.state)),
      el("span", { class: "quiet" }, timing(packet)),
      packet.waits_for?.length ? el("span", { class: "waits" }, `waits for ${packet.waits_for.join(", ")}`) : null,
    ))),
  );
}

function timing(packet) {
  if (typeof packet.started_at_s !== "number") return `due ${seconds(packet.expected_start_s)}`;
  if (typeof packet.finished_at_s !== "number") return `of ${seconds(packet.expected_duration_s)}`;
  return `${seconds(packet.finished_at_s - packet.started_at_s)} of ${seconds(packet.expected_duration_s)}`;
}
