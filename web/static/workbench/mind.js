// A robot's mind (SRA): its agents with roles, beliefs and commitments, its open conversations, and its rules.

import { get, id, problemOf } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { seconds, words } from "../page/format.js";
import { mountRole } from "./role.js";
import { mountRules } from "./rules.js";

const EVERY_MS = 1000;
/** The tone of a commitment's badge, where it is not idle. @type {Record<string, string>} */
const TONES = { active: "busy", fulfilled: "good", failed: "bad" };

/** @param {Element} root @returns {WorkbenchPart} */
export function mountMind(root) {
  const agents = el("div", { class: "agents", "data-testid": "mind-agents" });
  const conversations = el("div", { "data-testid": "mind-conversations" });
  const rulesRoot = el("div", { "data-testid": "mind-rules" });
  const rules = mountRules(rulesRoot);
  const roleRoot = el("div", { "data-testid": "mind-role" });
  const role = mountRole(roleRoot);
  /** @type {string | null} */
  let robot = null;
  let isLoading = false;
  replace(root, agents, section("Conversations", conversations), section("Role", roleRoot), section("Rules", rulesRoot));
  agents.addEventListener("click", (event) => {
    const rule = event.target instanceof HTMLElement ? event.target.dataset.rule : undefined;
    if (rule) rules.showLine(rule);
  });

  async function load() {
    if (!robot || document.hidden || isLoading) return;
    const name = robot;
    isLoading = true;
    try {
      /** @type {Mind} */
      const mind = await get(`/v1/robots/${id(name)}/mind`);
      if (robot === name) draw(mind);
    } catch (error) {
      if (robot === name) show(agents, quiet(problemOf(error).message));
    }
    isLoading = false;
  }

  /** @param {Mind} mind */
  function draw(mind) {
    show(agents, mind.agents.length ? mind.agents.map((agent) => drawAgent(agent, mind.at_s)) : quiet("The robot follows no rules."));
    show(conversations, mind.conversations.length ? el("ol", { class: "small" }, mind.conversations.map(drawConversation)) : quiet("None is open."));
  }

  const timer = setInterval(load, EVERY_MS);
  return {
    update(state) {
      if (state.robot === robot) return;
      robot = state.robot;
      rules.setRobot(robot);
      role.setRobot(state.robots.find((one) => one.name === robot) ?? null);
      show(agents);
      show(conversations);
      load();
    },
    onEvent({ type, subject }) {
      if (subject === robot && type && /^(rules|role)\./.test(type)) {
        rules.refresh();
        role.refresh();
      }
    },
    close: () => clearInterval(timer),
  };
}

/** @param {string} title @param {Child} content */
const section = (title, content) => el("section", {}, el("h3", {}, title), content);

/** @param {string} text */
const quiet = (text) => el("p", { class: "quiet" }, text);

/** @param {ToldAgent} agent @param {number} now */
function drawAgent(agent, now) {
  const roles = agent.roles.length ? el("span", { class: "quiet" }, ` in the role ${agent.roles.map(words).join(", ")}`) : null;
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
    ])) : quiet("None."),
    title("Commitments", agent.commitments.length, agent.commitment_count),
    agent.commitments.length ? table(["State", "Commitment", "Ago"], agent.commitments.map((one) => [
      el("span", { class: `badge ${TONES[one.state] ?? "idle"}` }, words(one.state)),
      [
        [one.name, one.towards && ` to ${one.towards}`],
        note(el("button", { type: "button", "data-rule": one.rule, title: "Show the rule" }, one.rule), Object.entries(one.bindings).map(([name, value]) => ` ${name} = ${value}`).join(",")),
        note(one.words || words(one.reason)),
      ],
      seconds(now - one.made_s),
    ])) : quiet("No rule has fired."),
  );
}

/** @param {string} name @param {number} shown @param {number} count */
const title = (name, shown, count) => el("h4", {}, name, count > shown ? el("span", { class: "quiet" }, ` the newest ${shown} of ${count}`) : null);

/** @param {Child[]} content */
const note = (...content) => el("div", { class: "quiet" }, ...content);

/** @param {string[]} heads @param {Child[][]} rows */
function table(heads, rows) {
  const head = el("tr", {}, heads.map((one) => el("th", {}, one)));
  return el("div", { class: "scroll", tabindex: "0" }, el("table", {}, el("thead", {}, head), el("tbody", {}, rows.map((row) => el("tr", {}, row.map((cell) => el("td", {}, cell)))))));
}

/** @param {ToldConversation} one */
function drawConversation(one) {
  const until = one.reply_by_s === null ? "" : `, an answer is awaited until ${one.reply_by_s.toFixed(1)} s`;
  return el("li", {}, el("span", { class: "badge idle" }, words(one.state)), ` ${one.protocol} with ${one.partner}, opened by ${one.is_mine ? "the robot" : one.partner}${until}`);
}
