// What a mission's packets have brought, and what its robots have said; fetched with the first mission that is shown.

import { id, list } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { problemBox } from "../page/problem.js";
import { ENDED } from "./timing.js";

const EVERY_MS = 2000;
const results = el("div");
const speech = mountSpeech();

/** @param {HTMLElement} container @param {Mission} mission */
export async function showMore(container, mission) {
  if (!container.firstChild) replace(container, results, speech.node);
  speech.show(mission);
  if (mission.results) await import("./results.js").then((part) => part.showResults(results, mission));
  else {
    results.dataset.of = "";
    show(results);
  }
}

/** The mission's messages, requested while they are open, and the diagram's modules with them. */
function mountSpeech() {
  const body = el("div");
  const node = el("details", { "data-testid": "mission-speech", ontoggle: load }, el("summary", {}, "Messages"), body);
  /** @type {Mission | null} */
  let mission = null;
  /** @type {Conversation | null} */
  let conversation = null;
  let requestedAt = -EVERY_MS;
  let key = "";

  async function load() {
    if (!node.open || mission === null || document.hidden) return;
    const { id: name, world } = mission;
    requestedAt = performance.now();
    try {
      const [{ createConversation }, { sayingsOf }, said, agents] = await Promise.all([import("../speech/conversation.js"), import("../speech/sayings.js"), list(`/v1/missions/${id(name)}/conversation`), list("/v1/robots"), import("../speech/style.js").then((part) => part.fetchSpeechStyle())]);
      if (mission?.id !== name) return;
      conversation ??= createConversation();
      if (!conversation.node.isConnected) replace(body, conversation.node);
      conversation.show(said.flatMap(sayingsOf), agents.filter((one) => one.world === world).map((one) => one.name));
    } catch (error) {
      replace(body, problemBox(error));
    }
  }

  return {
    node,
    /** @param {Mission} shown */
    show(shown) {
      const isOther = mission?.id !== shown.id;
      const next = JSON.stringify(shown);
      mission = shown;
      if (isOther) replace(body);
      if (next !== key || (!ENDED.includes(shown.state) && performance.now() - requestedAt > EVERY_MS)) load();
      key = next;
    },
  };
}
