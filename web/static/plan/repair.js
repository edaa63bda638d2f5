// What a repaired plan differs in from the one it takes the place of: in words, and for picture and table.

import { el } from "../page/dom.js";
import { roughly, words } from "../page/format.js";

export function repair(plan, before) {
  if (!plan.repairs) return null;
  const [summary, ...details] = plan.repairs.difference.words;
  return el(
    "details",
    { class: "note", "data-testid": "repairs", open: plan.state === "proposed" },
    el("summary", {}, `Repaired (${words(plan.repairs.course)}): ${summary ?? "nothing is different"}`),
    before?.reason ? el("p", { class: "small" }, `The plan before was overtaken: ${before.reason}`) : null,
    details.length ? el("ul", { class: "links" }, details.map((line) => el("li", {}, line))) : null,
  );
}

// `of`: by action, what is different about it. `ghosts`: what the plan `before` had instead, on this plan's time axis.
export function changes(plan, before) {
  const { kept = {}, reassigned = {}, dropped = [], added = [], shifted = {}, elapsed_s = 0 } = plan.repairs?.difference ?? {};
  const old = new Map((before?.actions ?? []).map((action) => [action.id, action]));
  const now = new Map(plan.actions.map((action) => [action.id, action]));
  const of = new Map(added.map((action) => [action, { kind: "new", words: "new" }]));
  const ghosts = [];
  const ghost = (name, kind, told, heir) => {
    const action = old.get(name);
    if (!action || plan.state === "approved") return; // what happens takes their room
    const from = action.earliest_start_s - elapsed_s;
    if (from + action.duration_s > 0) ghosts.push({ kind, words: told, agents: action.agents, tag: action.tag, from: Math.max(0, from), to: from + action.duration_s, heir });
  };
  for (const name of dropped) ghost(name, "dropped", "dropped");
  for (const [name, heir] of Object.entries(reassigned)) {
    of.set(heir, { kind: "new", words: `instead of ${(old.get(name)?.agents ?? ["another"]).join(" and ")}` });
    ghost(name, "dropped", `now by ${now.get(heir)?.agents.join(" and ")}`);
  }
  for (const [name, heir] of Object.entries(kept)) {
    if (!(heir in shifted)) continue;
    const told = `${roughly(Math.abs(shifted[heir]))} ${shifted[heir] > 0 ? "later" : "earlier"}`;
    of.set(heir, { kind: "moved", words: `${told} than before` });
    ghost(name, "moved", told, now.get(heir));
  }
  return { of, ghosts };
}
