// A robot's mind (SRA): its agents with roles, beliefs and commitments, its open conversations, and its rules.

import { get, id, problemOf } from "../page/api.js";
import { badge, el, replace, show } from "../page/dom.js";
import { words } from "../page/format.js";
import { drawAgent, quietLine } from "./agents.js";
import { mountBreakpoints } from "./breakpoints.js";
import { mountRole } from "./role.js";
import { mountRules } from "./rules.js";

const EVERY_MS = 1000;
/** @param {Element} root @returns {WorkbenchPart} */
export function mount(root) {
  const agents = el("div", { class: "agents", "data-testid": "mind-agents" });
  const conversations = el("div", { "data-testid": "mind-conversations" });
  const rulesRoot = el("div", { "data-testid": "mind-rules" });
  const rules = mountRules(rulesRoot);
  const breakpointsRoot = el("div", { "data-testid": "mind-breakpoints" });
  const breakpoints = mountBreakpoints(breakpointsRoot, rules.caret);
  const roleRoot = el("div", { "data-testid": "mind-role" });
  const role = mountRole(roleRoot);
  /** @type {string | null} */
  let robot = null;
  let isLoading = false;
  replace(root, section("Breakpoints", breakpointsRoot), agents, section("Conversations", conversations), section("Role", roleRoot), section("Rules", rulesRoot));
  agents.addEventListener("click", (event) => {
    const rule = event.target instanceof HTMLElement ? event.target.dataset.rule : undefined;
    if (rule) rules.showLine(rule);
  });

  async function load() {
    if (!robot || document.hidden || isLoading) return;
    const name = robot;
    isLoading = true;
    try {
      const halt = await breakpoints.load();
      if (robot === name && halt) draw({ ...halt, conversations: [] });
      else if (robot === name && breakpoints.stands()) show(agents, quietLine("Its world stands at a breakpoint of another robot."));
      else {
        /** @type {Mind} */
        const mind = await get(`/v1/robots/${id(name)}/mind`);
        if (robot === name) draw(mind);
      }
    } catch (error) {
      if (robot === name) show(agents, quietLine(problemOf(error).message));
    }
    isLoading = false;
  }

  /** @param {Mind} mind */
  function draw(mind) {
    show(agents, mind.agents.length ? mind.agents.map((agent) => drawAgent(agent, mind.at_s)) : quietLine("The robot follows no rules."));
    show(conversations, mind.conversations.length ? el("ol", { class: "small" }, mind.conversations.map(drawConversation)) : quietLine("None is open."));
  }

  const timer = setInterval(load, EVERY_MS);
  return {
    update(state) {
      if (state.robot === robot) return;
      robot = state.robot;
      rules.setRobot(robot);
      breakpoints.setRobot(robot);
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

/** @param {ToldConversation} one */
function drawConversation(one) {
  const until = one.reply_by_s === null ? "" : `, an answer is awaited until ${one.reply_by_s.toFixed(1)} s`;
  return el("li", {}, badge("idle", words(one.state)), ` ${one.protocol} with ${one.partner}, opened by ${one.is_mine ? "the robot" : one.partner}${until}`);
}
