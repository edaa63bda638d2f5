// What a robot believed and was committed to at the shown instant of a recording.

import { el, show } from "../page/dom.js";
import { drawAgent } from "../workbench/agents.js";

/** @param {Recording} recording */
export function createMinds(recording) {
  const names = recording.minds;
  const choice = el("select", { "aria-label": "Mind of", "data-testid": "replay-mind-of", onchange: draw }, names.map((name) => el("option", {}, name)));
  const body = el("div", { class: "agents" });
  let instant = recording.from;
  const node = el("details", { "data-testid": "replay-minds", hidden: names.length === 0, ontoggle: draw }, el("summary", {}, "Mind"), choice, body);

  function draw() {
    if (!node.open) return;
    const mind = recording.mind(choice.value, instant);
    if (mind) show(body, mind.agents.map((agent) => drawAgent(agent, instant, false)));
    else show(body, el("p", { class: "quiet" }, "Nothing of its mind was recorded yet."));
  }

  return {
    node,
    /** @param {number} time */
    show(time) {
      instant = time;
      draw();
    },
  };
}
