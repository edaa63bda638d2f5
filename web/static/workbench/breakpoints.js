// Breakpoints on the rules of a simulated robot: where its world stands, with what fired; step, go on, remove.

import { get, id, post, put } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { attempt } from "../page/problem.js";

/**
 * @param {Element} root
 * @param {() => string} caret the file and line at the caret of the rules' text, "guard:2"; empty: none
 */
export function mountBreakpoints(root, caret) {
  /** @type {string | null} */
  let robot = null;
  /** @type {Breakpoints | null} */
  let known = null;
  const state = el("div", { role: "status", "data-testid": "breakpoints-state" });
  const problem = el("div", { role: "alert" });
  const rules = el("div", { class: "head" });
  const add = el("button", { onclick: breakAtCaret, title: "The rule begins at the line of the caret" }, "Break at the caret");
  const clear = el("button", { onclick: () => set([]) }, "Clear");
  const step = el("button", { onclick: () => goOn("step"), title: "One control cycle: each robot deliberates once" }, "Step");
  const go = el("button", { class: "primary", onclick: () => goOn("continue") }, "Continue");
  replace(root, state, problem, rules, el("div", { class: "head" }, add, clear, el("span", { class: "spring" }), step, go));

  const path = () => `/v1/robots/${id(robot ?? "")}/breakpoints`;

  /** @param {Breakpoints} answer */
  function draw(answer) {
    known = answer;
    const stands = answer.halts.length > 0;
    show(rules, answer.rules.map((rule) => el("button", { title: "Remove this breakpoint", onclick: () => set(answer.rules.filter((one) => one !== rule)) }, `${rule} ×`)));
    show(state, stands ? [answer.halts.map(drawHalt), el("p", { class: "quiet small" }, left(answer))] : quietly(answer));
    add.disabled = answer.refusal !== "";
    clear.disabled = answer.rules.length === 0;
    step.disabled = go.disabled = !stands;
  }

  /** @param {Breakpoints} answer */
  function quietly({ refusal, ended, rules: mine, of_others: others }) {
    const words = refusal || ended || (mine.length ? "The world runs until a rule with a breakpoint fires." : "No breakpoints.");
    return el("p", { class: "quiet small" }, words, others ? ` Other robots of the world have ${others}.` : "");
  }

  /** @param {string[]} wanted */
  const set = (wanted) => change(() => put(path(), { rules: wanted }));

  function breakAtCaret() {
    const rule = caret();
    if (rule && known !== null) return set([...new Set([...known.rules, rule])]);
    return undefined;
  }

  /** @param {"step" | "continue"} verb */
  const goOn = (verb) => change(() => post(`${path()}:${verb}`));

  /** @param {() => Promise<Breakpoints>} request */
  async function change(request) {
    const name = robot;
    await attempt([add, clear, step, go], problem, async () => {
      const answer = await request();
      if (robot === name) draw(answer);
    });
    if (known !== null) draw(known);
  }

  return {
    /** @param {string | null} name */
    setRobot(name) {
      robot = name;
      known = null;
      show(state);
      show(rules);
      add.disabled = clear.disabled = step.disabled = go.disabled = true;
    },
    /** Read where the world stands; where the robot's own mind does, or null while it runs. @returns {Promise<BreakpointHalt | null>} */
    async load() {
      const name = robot;
      if (name === null) return null;
      /** @type {Breakpoints | null} */
      const answer = await get(path()).catch(() => null);
      if (answer === null || robot !== name) return null;
      draw(answer);
      return answer.halts.find((one) => one.robot === name) ?? null;
    },
    /** True if the world stands: then its robots answer nothing. */
    stands: () => known !== null && known.halts.length > 0,
  };
}

/** @param {Breakpoints} answer */
const left = ({ left_s: seconds }) => `The whole world stands. If nobody goes on, it runs again in ${Math.ceil((seconds ?? 0) / 60)} min, without breakpoints.`;

/** @param {BreakpointHalt} halt */
function drawHalt({ robot, at_s: at, firings }) {
  const title = el("p", {}, el("b", {}, robot), ` stands at ${at.toFixed(2)} s`, firings.length ? "; these rules have fired and take effect next:" : "; no breakpoint was met in this step.");
  return [title, el("ul", { class: "small" }, firings.map(drawFiring))];
}

/** @param {BreakpointFiring} firing */
function drawFiring({ agent, rule, does, bindings }) {
  const bound = Object.entries(bindings).map(([name, value]) => `, ?${name.replace(/^\?/, "")} = ${value}`);
  return el("li", {}, `${agent}: `, el("code", {}, rule), ` ${does || "beliefs only"}${bound.join("")}`);
}
