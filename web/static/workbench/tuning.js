// The parameters of one packet's patterns, which an operator may change; a change based on an old version is refused.

import { put } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { deliveryText, ofRobot } from "./of_robot.js";

/** @param {Element} root */
export function mountTuning(root) {
  /** @type {string | null} */
  let robot = null;
  /** @type {Tuning | null} */
  let tuning = null;
  const packet = el("select", { "aria-label": "Packet", "data-testid": "tuning-packet", onchange: draw });
  const state = el("span", { class: "quiet small", role: "status" });
  const problem = el("div", { role: "alert" });
  const rows = el("div", { class: "tuning" });
  const known = ofRobot("tuning", problem, (/** @type {Tuning} */ answer) => {
    const before = packet.value;
    tuning = answer;
    replace(packet, Object.keys(answer.packets).map((tag) => el("option", {}, tag)));
    if (before in answer.packets) packet.value = before;
    draw();
  });
  replace(root, el("div", { class: "head" }, packet, state, el("button", { onclick: known.load }, "Read again")), problem, rows);

  /**
   * @param {string} pattern @param {string} parameter @param {number | undefined} value undefined: the original one
   * @param {HTMLButtonElement | HTMLInputElement} input
   */
  function set(pattern, parameter, value, input) {
    const tag = packet.value;
    if (tuning === null) return undefined;
    const { tuning: now, version } = tuning;
    const changed = structuredClone(now);
    const values = ((changed[tag] ??= {})[pattern] ??= {});
    if (value === undefined) delete values[parameter];
    else values[parameter] = value;
    return known.answer(() => put(known.path(), { tuning: changed }, { "if-match": `"${version}"` }), [input]);
  }

  function draw() {
    if (tuning === null) return;
    replace(state, `${deliveryText(tuning)}; counts from the next packet on`);
    replace(rows, Object.entries(tuning.packets[packet.value] ?? {}).map(([pattern, parameters]) => el(
      "fieldset",
      {},
      el("legend", { class: "small" }, words(pattern)),
      Object.entries(parameters).map(([name, value]) => field(pattern, name, value)),
    )));
  }

  /** @param {string} pattern @param {string} name @param {number} value */
  function field(pattern, name, value) {
    const isChanged = tuning?.tuning[packet.value]?.[pattern]?.[name] !== undefined;
    const input = el("input", { type: "number", step: "any", value, "data-testid": `tune-${pattern}-${name}` });
    input.addEventListener("change", () => Number.isFinite(input.valueAsNumber) && set(pattern, name, input.valueAsNumber, input));
    const reset = el("button", { title: "Original value", "aria-label": `${words(name)}: original value` }, "↺");
    reset.addEventListener("click", () => set(pattern, name, undefined, reset));
    return el("label", { class: "small" }, `${words(name)} `, input, isChanged ? reset : null);
  }

  /** @param {string | null} tag */
  function showPacket(tag) {
    if (!tag || !tuning || !(tag in tuning.packets) || root.contains(document.activeElement)) return;
    packet.value = tag;
    draw();
  }

  return {
    /** @param {string | null} name @param {string | null} tag the packet that it executes */
    async setRobot(name, tag) {
      const isOther = name !== robot;
      robot = name;
      if (isOther) await known.select(name);
      showPacket(tag);
    },
  };
}
