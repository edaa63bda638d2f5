// The agents of a robot's mind: roles, beliefs and commitments.

import { badge, el, quiet } from "../page/dom.js";
import { seconds, words } from "../page/format.js";

/** The tone of a commitment's badge, where it is not idle. @type {Record<string, string>} */
const TONES = { active: "busy", fulfilled: "good", failed: "bad" };

/** @param {string} text */
export const quietLine = (text) => el("p", { class: "quiet" }, text);

/** @param {ToldAgent} agent @param {number} now @param {boolean} isLinked rules are buttons */
export function drawAgent(agent, now, isLinked = true) {
  const roles = agent.roles.length ? quiet(` in the role ${agent.roles.map(words).join(", ")}`) : null;
  return el(
    "section",
    { "data-testid": `agent-${agent.name}` },
    el("h3", {}, words(agent.name), roles),
    title("Beliefs", agent.beliefs.length, agent.belief_count),
    agent.beliefs.length ? table(["Belief", "For"], agent.beliefs.map((one) => [
      [
        [el("b", { title: one.value ? "believed to hold" : "believed not to hold" }, one.value ? "✓" : "✗"), ` ${one.term}`],
        note([one.origin, one.source, one.words].filter(Boolean).join(", ")),
      ],
      seconds(now - one.since_s),
    ])) : quietLine("None."),
    title("Commitments", agent.commitments.length, agent.commitment_count),
    agent.commitments.length ? table(["State", "Commitment", "Ago"], agent.commitments.map((one) => [
      badge(TONES[one.state] ?? "idle", words(one.state)),
      [
        [one.name, one.towards && ` to ${one.towards}`],
        note(isLinked ? el("button", { "data-rule": one.rule, title: "Show the rule" }, one.rule) : el("code", {}, one.rule), Object.entries(one.bindings).map(([name, value]) => ` ${name} = ${value}`).join(",")),
        note(one.words || words(one.reason)),
      ],
      seconds(now - one.made_s),
    ])) : quietLine("No rule has fired."),
  );
}

/** @param {string} name @param {number} shown @param {number} count */
const title = (name, shown, count) => el("h4", {}, name, count > shown ? quiet(` the newest ${shown} of ${count}`) : null);

/** @param {Child[]} content */
const note = (...content) => el("div", { class: "quiet" }, ...content);

/** @param {string[]} heads @param {Child[][]} rows */
function table(heads, rows) {
  const head = el("tr", {}, heads.map((one) => el("th", {}, one)));
  return el("div", { class: "scroll", tabindex: "0" }, el("table", {}, el("thead", {}, head), el("tbody", {}, rows.map((row) => el("tr", {}, row.map((cell) => el("td", {}, cell)))))));
}
