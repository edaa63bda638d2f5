// What happened, beside a recording: a list that goes along with it, and a mark of each event along its time line.

import { el, svg } from "../page/dom.js";
import { seconds, words } from "../page/format.js";

const KINDS = { plan: "decided", goal: "decided", mission: "decided", packet: "done", script: "done" };

// `seek(at)` is called with the instant of the event that was chosen.
export function createEvents(recording, seek) {
  const list = el("ol", { class: "events", "aria-label": "What happened" }, recording.events.map(item));
  const strip = svg("svg", { viewBox: "0 0 1000 6", preserveAspectRatio: "none", class: "event-marks", "aria-hidden": "true" }, recording.events.map(mark));
  let now = -1;

  function item({ at_s, type, data }) {
    const after = at_s - recording.from;
    const about = [data?.robot, data?.packet, data?.actor, data?.source, data?.text, data?.reason, data?.detail].filter(Boolean).join(" · ");
    return el("li", {}, el("button", { type: "button", tabindex: -1, onclick: () => seek(at_s) }, el("span", { class: "number quiet" }, `${after < 0 ? "−" : ""}${seconds(Math.abs(after))}`), " ", words(type.replace(".", ": ")), about ? el("span", { class: "quiet" }, ` ${about}`) : null));
  }

  function mark({ at_s, type }) {
    const share = (at_s - recording.from) / (recording.to - recording.from || 1);
    return share < 0 ? null : svg("rect", { x: 1000 * share, y: 0, width: 2, height: 6, class: KINDS[type.split(".")[0]] ?? "other" });
  }

  // The event so many places on from the one that is marked.
  function step(by) {
    const at = Math.min(recording.events.length - 1, Math.max(0, now + by));
    if (recording.events[at]) seek(recording.events[at].at_s, at);
    return list.children[at]?.firstChild;
  }

  list.addEventListener("keydown", (event) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    step(by)?.focus();
  });
  return {
    list,
    strip,
    step,
    // Mark the event that was the last at that instant; `at`, if it is known which of several.
    show(time, at = recording.event(time)) {
      if (at === now) return;
      list.children[now]?.removeAttribute("aria-current");
      if (list.children[now]) list.children[now].firstChild.tabIndex = -1;
      now = at;
      const line = list.children[now];
      line?.setAttribute("aria-current", "true");
      (line ?? list.firstElementChild)?.firstChild.setAttribute("tabindex", "0");
      list.scrollTop = line ? line.offsetTop - list.clientHeight + line.offsetHeight : 0;
    },
  };
}
