// What was said up to the shown instant of a recording.

import { el } from "../page/dom.js";
import { createConversation } from "../speech/conversation.js";
import { sayingsOfEvent } from "../speech/sayings.js";

/** @param {Recording} recording */
export function createMessages(recording) {
  const said = recording.events.flatMap((event) => sayingsOfEvent(event, event.at_s));
  const robots = Object.keys(recording.robots(recording.to));
  const conversation = createConversation();
  let drawn = "";
  let instant = recording.from;
  const node = el("details", { "data-testid": "replay-speech", hidden: said.length === 0, ontoggle: draw }, el("summary", {}, "Messages"), conversation.node);

  function draw() {
    if (!node.open) return;
    const known = said.filter((one) => one.said_s <= instant).map((one) => (one.heard_s !== null && one.heard_s > instant ? { ...one, heard_s: null } : one));
    const key = `${known.length} ${known.filter((one) => one.heard_s !== null).length}`;
    if (key === drawn) return;
    drawn = key;
    conversation.show(known, robots);
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
