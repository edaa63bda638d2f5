// What is not known of the world: samples without a place, robots that are lost or do not answer.

import { el, show } from "../page/dom.js";
import { seconds } from "../page/format.js";

export function mountUnknown(store) {
  const container = document.getElementById("unknown");
  store.subscribe((state) => show(container, state.unknown.length ? box(state.unknown) : null));
}

function box(things) {
  return el(
    "details",
    { open: true, "data-testid": "unknown" },
    el("summary", {}, `Not known (${things.length})`),
    el("dl", {}, things.map((thing) => [el("dt", {}, thing.name), el("dd", {}, line(thing))])),
  );
}

function line({ reason, since_s: since, last_believed: last }) {
  const when = typeof since === "number" ? `, since ${seconds(since)}` : "";
  return `${reason}${when}${last ? `; last believed ${last.predicate}(${last.args.join(", ")}), ${last.source} at ${seconds(last.at_s)}` : ""}`;
}
