// Below the robots: what is not known of the world, and what is kept as it is for some time.

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
  const lines = holds.map(({ id: hold, world, words, lost, ends, text }) => {
    const path = `/v1/worlds/${id(world)}/holds/${id(hold)}:end`;
    const end = commandButton("End", path, problem, refresh, { "data-testid": "hold-end", "aria-label": `End keeping ${words}` });
    return el("li", { class: "row" }, el("span", { class: "grow", title: text }, el("b", {}, words), ` ${ends}`, lost.map(lostNote)), end);
  });
  return el("details", { open: true, "data-testid": "holds" }, el("summary", {}, `Kept (${holds.length})`), el("ul", {}, lines), problem);
}

/** What has ceased to be true though it is kept, and what is done about it. @param {Hold["lost"][number]} lost */
function lostNote({ now, goal, reason }) {
  const then = goal ? `; ${goal} is to bring it about again` : reason && `; no goal brings it about again: ${reason}`;
  return el("div", { class: "problem", "data-testid": "hold-lost" }, `No longer true: ${now}${then}`);
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
