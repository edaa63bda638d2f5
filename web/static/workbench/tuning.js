// The parameters of one packet's patterns, and what an operator makes of them; made from the newest version or not at all.

import { get, id, put } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { asking } from "../page/problem.js";

export function mountTuning(root) {
  let [robot, told] = [null, null];
  const packet = el("select", { "aria-label": "Packet", "data-testid": "tuning-packet", onchange: draw });
  const state = el("span", { class: "quiet small", role: "status" });
  const problem = el("div", { role: "alert" });
  const rows = el("div", { class: "tuning" });
  const again = el("button", { type: "button", onclick: () => read() }, "Read again");
  replace(root, el("div", { class: "head" }, packet, state, again), problem, rows);

  async function read() {
    const [name, before] = [robot, packet.value];
    await asking([], problem, async () => {
      const tuning = await get(`/v1/robots/${id(name)}/tuning`);
      if (robot !== name) return;
      told = tuning;
      replace(packet, Object.keys(told.packets).map((tag) => el("option", {}, tag)));
      if (before in told.packets) packet.value = before;
      draw();
    });
  }

  // `value` undefined: as the robot was set out.
  function set(pattern, parameter, value, input) {
    const tag = packet.value;
    const { [parameter]: _, ...others } = told.tuning[tag]?.[pattern] ?? {};
    const tuning = { ...told.tuning, [tag]: { ...told.tuning[tag], [pattern]: value === undefined ? others : { ...others, [parameter]: value } } };
    return asking([input], problem, async () => {
      told = await put(`/v1/robots/${id(robot)}/tuning`, { tuning }, { "if-match": `"${told.version}"` });
      draw();
    });
  }

  function draw() {
    const tag = packet.value;
    const ours = told.tuning[tag] ?? {};
    replace(state, `version ${told.version}, ${words(told.delivery)}${told.detail ? `: ${told.detail}` : ""}; counts from the next packet on`);
    replace(rows, Object.entries(told.packets[tag] ?? {}).map(([pattern, parameters]) => el("fieldset", {}, el("legend", { class: "small" }, words(pattern)), Object.entries(parameters).map(([name, value]) => el("label", { class: "small" }, `${words(name)} `,
      el("input", { type: "number", step: "any", value, "data-testid": `tune-${pattern}-${name}`, onchange: ({ target }) => Number.isFinite(target.valueAsNumber) && set(pattern, name, target.valueAsNumber, target) }),
      ours[pattern]?.[name] === undefined ? null : el("button", { type: "button", title: "As it was set out", "aria-label": `${words(name)} as it was set out`, onclick: ({ target }) => set(pattern, name, undefined, target) }, "↺"))))));
  }

  return {
    of(name, tag) {
      const other = name !== robot;
      robot = name;
      if (!name) return;
      if (other) read().then(() => tag && show(tag));
      else if (tag) show(tag);
    },
  };

  function show(tag) {
    if (!told || !(tag in told.packets) || root.contains(document.activeElement)) return;
    packet.value = tag;
    draw();
  }
}
