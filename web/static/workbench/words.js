// The message console (SRA): what a person says to one robot, its questions, scripts to approve, and the answers.

import { get, id, post, problemOf } from "../page/api.js";
import { badge, el, quiet, replace, show } from "../page/dom.js";
import { words } from "../page/format.js";

const SHOWN = 20;
const OPEN = ["asking", "proposed", "said", "agreed"];
/** The tone of a state's badge, where it is not idle. @type {Record<string, string>} */
const TONES = { asking: "busy", proposed: "busy", said: "busy", agreed: "busy", done: "good", refused: "bad", failed: "bad", not_understood: "bad", timed_out: "bad" };
/** FIPA's communicative acts (SC00037). */
const ACTS = ["request", "query-if", "query-ref", "inform", "cfp", "accept-proposal", "agree", "cancel", "confirm", "disconfirm", "failure", "inform-if", "inform-ref", "propagate", "propose", "proxy", "refuse", "reject-proposal", "request-when", "request-whenever", "subscribe"];
/** The acts that go on with what is under way, as to a bid, instead of opening something. */
const GO_ON = ["accept-proposal", "reject-proposal", "cancel"];
const UNDER_WAY = ["said", "agreed"];
const EXAMPLES = ["what do you see?", "where are you?", "how is your battery?", "stop"];

/** @param {Element} root @returns {WorkbenchPart} */
export function mount(root) {
  const act = el("select", { "aria-label": "Act", "data-testid": "say-act" }, el("option", { value: "" }, "in words"), ACTS.map((one) => el("option", { value: one }, one)));
  const text = el("input", { type: "text", required: "", maxlength: "500", "aria-label": "What to say", placeholder: "face sample_1", "data-testid": "say-text", autocomplete: "off" });
  const atOnce = el("input", { type: "checkbox", "data-testid": "say-at-once" });
  const problem = el("p", { class: "problem", role: "alert", hidden: "", "data-testid": "say-problem" });
  const list = el("div", { class: "dialogues", "data-testid": "dialogues" });
  const examples = el("div", { class: "choices" }, EXAMPLES.map((one) => el("button", { onclick: () => say(one) }, one)));
  const form = el(
    "form",
    { class: "say", onsubmit: (/** @type {Event} */ event) => { event.preventDefault(); say(asTyped(), GO_ON.includes(act.value) ? underWay(act.value) : null); } },
    act, text,
    el("label", { title: "Without showing the script first" }, atOnce, " at once"),
    el("button", { type: "submit", class: "primary", "data-testid": "say" }, "Say"),
  );
  /** @type {string | null} */
  let robot = null;
  let isLoading = false;
  let isStale = false;
  /** The robot's newest dialogues, the newest first. @type {Dialogue[]} */
  let dialogues = [];
  replace(root, form, problem, examples, list);
  act.addEventListener("change", () => {
    text.placeholder = act.value ? (act.value.startsWith("query") ? "content, such as seen or sees(sample_1)" : "content, such as cover_role(attacker)") : "face sample_1";
  });

  function asTyped() {
    return act.value ? `${act.value.toUpperCase()} content:"${text.value.replaceAll(/["\\]/g, "\\$&")}"` : text.value;
  }

  /** The dialogue that an act goes on with: the newest one under way, for an answer to a bid one with a bid. @param {string} performative */
  function underWay(performative) {
    const open = dialogues.filter((one) => UNDER_WAY.includes(one.state));
    const fit = performative === "cancel" ? open : open.filter((one) => one.lines.at(-1)?.performative === "propose");
    return fit[0]?.id ?? null;
  }

  const path = () => `/v1/robots/${id(robot ?? "")}/dialogues`;

  /** @param {string} said @param {string | null} dialogue */
  async function say(said, dialogue = null) {
    if (await tried(() => post(path(), { text: said, dialogue, approve: atOnce.checked }))) text.value = "";
  }

  /** @param {() => Promise<any>} request @returns {Promise<boolean>} */
  async function tried(request) {
    try {
      await request();
      problem.hidden = true;
      return true;
    } catch (error) {
      problem.hidden = false;
      show(problem, problemOf(error).message);
      return false;
    } finally {
      load();
    }
  }

  async function load() {
    if (!robot) return;
    if (isLoading) {
      isStale = true;
      return;
    }
    const name = robot;
    isLoading = true;
    try {
      const { items } = await get(`${path()}?limit=${SHOWN}`);
      if (robot === name) {
        dialogues = items;
        show(list, items.length ? items.map(drawDialogue) : el("p", { class: "quiet" }, "Nothing was said to it yet."));
      }
    } catch (error) {
      if (robot === name) show(list, el("p", { class: "quiet" }, problemOf(error).message));
    }
    isLoading = false;
    if (isStale) {
      isStale = false;
      load();
    }
  }

  /** @param {Dialogue} one */
  function drawDialogue(one) {
    const isOpen = OPEN.includes(one.state);
    return el(
      "section",
      { class: "dialogue", "data-testid": `dialogue-${one.id}` },
      el("h3", {}, badge(TONES[one.state] ?? "idle", words(one.state)), ` ${one.text}`),
      el("ol", {}, one.lines.map((line) => el(
        "li",
        { class: line.by === one.robot ? "of-robot" : "" },
        quiet(`${line.by}, ${line.performative}`), " ", line.words,
      ))),
      one.question && el("div", { class: "choices" }, one.question.choices.map((choice) => el("button", { "data-testid": "choice", onclick: () => say(choice, one.id) }, choice))),
      one.state === "proposed" && one.script.length > 0 && el("ol", { class: "script" }, one.script.map((packet) => el("li", {}, el("b", {}, packet.tag), ` ${Object.entries(packet.arguments).map(([name, value]) => `${name} ${value}`).join(", ")}, about ${Math.round(packet.expected_duration_s)} s`))),
      isOpen && el(
        "div",
        { class: "choices" },
        one.state === "proposed" && el("button", { class: "primary", "data-testid": "approve-words", onclick: () => tried(() => post(`${path()}/${id(one.id)}:approve`)) }, "Approve"),
        el("button", { "data-testid": "withdraw-words", onclick: () => tried(() => post(`${path()}/${id(one.id)}:withdraw`)) }, "Withdraw"),
      ),
    );
  }

  return {
    update(state) {
      if (state.robot === robot) return;
      robot = state.robot;
      dialogues = [];
      problem.hidden = true;
      show(list);
      load();
    },
    onEvent({ type, subject }) {
      if (subject === robot && type?.startsWith("dialogue.")) load();
    },
    close() {},
  };
}
