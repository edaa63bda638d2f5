// Below the robots: what is not known of the world, and the places that are kept empty for some time.

import { id } from "../page/api.js";
import { byId, el, show } from "../page/dom.js";
import { fact, seconds } from "../page/format.js";
import { commandButton } from "../page/problem.js";

/** @param {Store} store @param {() => void} refresh */
export function mountNotes(store, refresh) {
  const container = byId("unknown", HTMLElement);
  const problem = el("div", { role: "alert" });
  let drawn = "";
  store.subscribe(({ unknown, holds }) => {
    const key = JSON.stringify([unknown, holds]);
    if (key === drawn) return; // a button must not be replaced under the pointer
    drawn = key;
    show(container, [unknown.length ? unknownList(unknown) : null, holds.length ? holdList(holds, problem, refresh) : null]);
  });
}

/** @param {Hold[]} holds @param {Element} problem @param {() => void} refresh */
function holdList(holds, problem, refresh) {
  const lines = holds.map(({ id: hold, world, places, ends, text }) => {
    const path = `/v1/worlds/${id(world)}/holds/${id(hold)}:end`;
    const end = commandButton("End", path, problem, refresh, { "data-testid": "hold-end", "aria-label": `End keeping ${places.join(", ")} empty` });
    return el("li", { class: "row" }, el("span", { class: "grow", title: text }, el("b", {}, places.join(", ")), ` ${ends}`), end);
  });
  return el("details", { open: true, "data-testid": "holds" }, el("summary", {}, `Kept empty (${holds.length})`), el("ul", {}, lines), problem);
}

/** Samples without a known place, robots that are lost or do not answer. @param {UnknownThing[]} things */
function unknownList(things) {
  const lines = things.map(({ name, reason, since_s: since, last_believed: last, earlier_believed: earlier = [] }) => {
    const when = typeof since === "number" ? `, since ${seconds(since)}` : "";
    const [believed = "", ...before] = [...(last ? [last] : []), ...earlier].map(
      (known) => `${fact(known)}, ${known.source} at ${seconds(known.at_s)}`,
    );
    const lately = believed && `; last believed ${believed}`;
    return [el("dt", {}, name), el("dd", {}, [`${reason}${when}${lately}`, ...before].join("; before that "))];
  });
  return el("details", { open: true, "data-testid": "unknown" }, el("summary", {}, `Not known (${things.length})`), el("dl", {}, lines));
}
