// Messages as a sequence diagram or a table, of all conversations or of one, with the words of the one that is looked at.

import { closest, el, show } from "../page/dom.js";
import { loadPreference, savePreference } from "../page/preferences.js";
import { drawDiagram, speakers, spoken } from "./diagram.js";
import { fate, merged } from "./sayings.js";

const MAX_SHOWN = 200;
const KEEP_BELOW_PX = 40;
/** @returns {Conversation} */
export function createConversation() {
  const views = ["diagram", "table"];
  const buttons = views.map((name) => el("button", { "data-testid": `speech-${name}`, onclick: () => setView(name) }, name === "table" ? "Table" : "Diagram"));
  const who = el("select", { "aria-label": "Speaker", "data-testid": "speech-who", onchange: draw });
  const talk = el("select", { "aria-label": "Conversation", "data-testid": "speech-talk", onchange: draw });
  const count = el("span", { class: "quiet small", role: "status" });
  const body = el("div", { class: "speech-body", role: "region", tabindex: 0, "aria-label": "Messages", "data-testid": "speech-body" });
  const words = el("p", { class: "note small", role: "status", "data-testid": "speech-words" });
  const node = el("div", { class: "speech" }, el("div", { class: "head" }, el("span", { class: "switch", role: "group", "aria-label": "Show messages as" }, buttons), who, talk, count), body, words);
  let view = loadPreference("speech", "diagram");
  /** @type {Saying[]} */
  let all = [];
  /** @type {Saying[]} */
  let shown = [];
  /** @type {Set<string>} */
  let robots = new Set();
  /** The saying that is looked at. @type {Saying | null} */
  let chosen = null;

  /** @param {string} name */
  function setView(name) {
    view = name;
    savePreference("speech", name);
    draw();
  }

  /** @param {HTMLSelectElement} choice @param {string} every @param {[value: string, text: string][]} options */
  function offer(choice, every, options) {
    const before = choice.value;
    show(choice, el("option", { value: "" }, every), options.map(([value, text]) => el("option", { value }, text)));
    choice.value = options.some(([value]) => value === before) ? before : "";
  }

  function draw() {
    offer(who, "everybody", speakers(all, robots).map((name) => [name, name]));
    /** @type {Map<string, string>} */
    const talks = new Map(all.map((one) => /** @type {const} */ ([one.conversation, `${one.protocol || "no protocol"}, ${one.from} and ${one.to}, ${one.said_s.toFixed(1)} s`])).reverse());
    offer(talk, "all conversations", [...talks].reverse());
    const found = all.filter((one) => (!who.value || one.from === who.value || one.to === who.value) && (!talk.value || one.conversation === talk.value));
    const held = body.contains(document.activeElement) ? shown[Number(document.activeElement?.closest("[data-saying]")?.getAttribute("data-saying") ?? -1)] : undefined;
    shown = found.slice(-MAX_SHOWN);
    if (chosen !== null && !shown.includes(chosen)) chosen = null;
    show(count, found.length > shown.length ? `the newest ${shown.length} of ${found.length} messages` : `${found.length} messages`);
    buttons.forEach((button, index) => button.setAttribute("aria-pressed", String(views[index] === view)));
    const follows = body.scrollHeight - body.scrollTop - body.clientHeight < KEEP_BELOW_PX;
    if (!shown.length) show(body, el("p", { class: "quiet" }, "Nothing was said."));
    else if (view === "table") show(body, asTable());
    else {
      const index = chosen === null ? null : shown.indexOf(chosen);
      show(body, drawDiagram(shown, speakers(shown, robots), { width: body.clientWidth || 600, robots, conversation: chosen?.conversation ?? null, chosen: index }));
    }
    if (follows) body.scrollTop = body.scrollHeight;
    if (held) rows()[shown.findIndex((one) => spoken(one) === spoken(held))]?.focus({ preventScroll: true });
    show(words, chosen === null ? "" : [el("b", {}, `${chosen.performative} `), el("code", {}, chosen.content), ` ${chosen.from} to ${chosen.to}, said at ${chosen.said_s.toFixed(1)} s`, chosen.heard_s === null ? "" : `, heard at ${chosen.heard_s.toFixed(1)} s`, chosen.protocol && `, ${chosen.protocol}`, fate(chosen) && `; ${fate(chosen)}`]);
    words.hidden = chosen === null;
  }

  function asTable() {
    const heads = ["s", "from", "to", "performative", "content", "protocol", "heard at s", "how it arrived"];
    return el(
      "table",
      {},
      el("thead", {}, el("tr", {}, heads.map((name) => el("th", { scope: "col" }, name)))),
      el("tbody", {}, shown.map((one) => el("tr", {}, [one.said_s.toFixed(1), one.from, one.to, one.performative, one.content, one.protocol, one.heard_s?.toFixed(1), fate(one)].map((cell) => el("td", {}, cell))))),
    );
  }

  const rows = () => /** @type {(SVGElement & {dataset: DOMStringMap})[]} */ ([...body.querySelectorAll("[data-saying]")]);

  /** @param {number} index */
  function choose(index) {
    chosen = shown[index] ?? null;
    draw();
  }

  /** @param {Event} event */
  const indexOf = (event) => Number(closest(event, "[data-saying]")?.dataset.saying ?? -1);
  body.addEventListener("click", (event) => {
    const index = indexOf(event);
    if (view === "diagram") choose(shown[index] === chosen ? -1 : index);
  });
  body.addEventListener("keydown", (event) => {
    const index = indexOf(event);
    if (index < 0) return;
    if (event.key === "ArrowDown") choose(Math.min(index + 1, shown.length - 1));
    else if (event.key === "ArrowUp") choose(Math.max(index - 1, 0));
    else if (event.key === "Home") choose(0);
    else if (event.key === "End") choose(shown.length - 1);
    else if (event.key === "Enter" || event.key === " ") choose(shown[index] === chosen ? -1 : index);
    else if (event.key === "Escape") choose(-1);
    else return;
    event.preventDefault();
    const row = rows().find((one) => one.tabIndex === 0);
    row?.focus({ preventScroll: true });
    row?.scrollIntoView({ block: "nearest" });
  });
  new ResizeObserver(() => requestAnimationFrame(() => view === "diagram" && shown.length && draw())).observe(node);

  return {
    node,
    show(sayings, names) {
      const next = merged(sayings);
      const same = chosen && spoken(chosen);
      all = next;
      robots = new Set(names);
      chosen = next.find((one) => spoken(one) === same) ?? null;
      draw();
    },
  };
}
