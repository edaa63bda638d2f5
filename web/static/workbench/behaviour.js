// The behaviour of one robot, for whoever wants to know why it does what it does: where it is in its script, whether the
// packet's conditions hold, what each pattern wants and what comes of it, what happened; and the patterns' parameters.

import { get, id } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { tone, words } from "../page/format.js";
import { mountTuning } from "./tuning.js";
import { strip } from "./strip.js";

const EVERY_MS = 1000;
const SECONDS = 10;
const EVENTS = 12;
const HOLDS = { true: "✓", false: "✗", null: "?" };

export function mountBehaviour(root, store) {
  const events = [];
  const parts = Object.fromEntries(["script", "conditions", "patterns", "events", "tuning"].map((name) => [name, el("div", { "data-testid": `behaviour-${name}` })]));
  let [robot, packet, asking] = [null, null, false];
  const tuning = mountTuning(parts.tuning);
  replace(root, Object.entries(parts).map(([name, part]) => el("section", {}, el("h3", {}, words(name)), part)));

  async function look() {
    const name = robot?.name;
    if (!name || document.hidden || asking) return;
    asking = true;
    try {
      const mission = robot.mission_id;
      const [trace, { progress }] = await Promise.all([get(`/v1/robots/${id(name)}/trace?seconds=${SECONDS}`), mission ? get(`/v1/missions/${id(mission)}`) : { progress: [] }]);
      if (robot?.name === name) draw(trace, progress.find((one) => one.robot === name)?.packets ?? []);
    } catch (problem) {
      show(parts.patterns, el("p", { class: "quiet" }, problem.message));
    }
    asking = false;
  }

  function draw({ at_s: now, stretches, conditions }, packets) {
    listed(parts.script, packets.map((one) => [el("span", { class: `badge ${tone(one.state)}` }, words(one.state)), ` ${one.description || one.tag} `, el("span", { class: "quiet" }, one.detail)]), robot.packet ? `${robot.packet}, of its own` : "No script.");
    listed(parts.conditions, (conditions ?? []).map((one) => [el("b", {}, HOLDS[one.holds]), ` ${one.when}: the robot ${one.words}`]), "No packet is under way.");
    const last = stretches.at(-1);
    show(parts.patterns, last ? [
      el("p", { class: "quiet small" }, `The last ${SECONDS} s: response −1 to 1 as a line, utility dashed.`),
      last.patterns.map(({ name, level }) => chart(name, level, over(stretches, "patterns", (one) => one.patterns.findIndex((pattern) => pattern.name === name)), now)),
      last.dofs.map((dof) => chart(dof, "resultant", over(stretches, "resultants", (one) => one.dofs.indexOf(dof)), now)),
    ] : el("p", { class: "quiet" }, "No pattern was active."));
  }

  const timer = setInterval(look, EVERY_MS);
  return {
    update(state) {
      const now = state.robots.find((one) => one.name === state.robot) ?? null;
      const other = now?.name !== robot?.name;
      if (other) events.length = 0;
      if (other || now?.packet !== packet) tuning.of(now?.name, now?.packet);
      [robot, packet] = [now, now?.packet];
      if (other) look();
      listed(parts.events, events, "Nothing since this was opened.");
    },
    heard({ type, subject, data }) {
      if (!robot || (subject !== robot.name && data?.robot !== robot.name)) return;
      const said = [data.packet, ...(data.events ?? []), data.detail || data.reason].filter(Boolean).join(", ");
      events.unshift(`${data.at_s ? `${data.at_s.toFixed(1)} s ` : ""}${words(type)}: ${said}`);
      events.length = Math.min(events.length, EVENTS);
    },
    close: () => clearInterval(timer),
  };
}

function listed(part, lines, none) {
  show(part, lines.length ? el("ol", { class: "small" }, lines.map((line) => el("li", {}, line))) : el("p", { class: "quiet" }, none));
}

// One pattern's or resultant's (r, u) over all stretches that have it.
function over(stretches, what, indexIn) {
  return stretches.flatMap((one) => (indexIn(one) < 0 ? [] : one.ticks.map((tick) => [tick.at_s, ...tick[what][indexIn(one)]])));
}

function chart(name, level, points, now) {
  const [, r, u] = points.at(-1);
  const label = `${words(name)}, ${level}: response ${r.toFixed(2)}, utility ${u.toFixed(2)}`;
  const of = (index) => points.map((point) => [point[0], point[index]]);
  return el("figure", { class: level === "resultant" ? "resultant" : null }, el("figcaption", { class: "small" }, label), strip(label, [of(1), of(2)], [now - SECONDS, now], [-1, 1]));
}
