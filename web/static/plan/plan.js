// The middle pane's plan: what would happen, when, how good that is, why by these robots; and the decision on it.

import { el, replace } from "../page/dom.js";
import { fact, gap, instant, seconds, tone, words } from "../page/format.js";
import { recall, remember } from "../page/remembered.js";
import { begun } from "../mission/elapsed.js";
import { unheardOn } from "../robots/contact.js";
import { choices } from "./choices.js";
import { decision, mountDecisionKeys } from "./decision.js";
import { createDetail } from "./detail.js";
import { createPicture } from "./picture.js";
import { changes, repair } from "./repair.js";
import { actionTable } from "./table.js";
import { why } from "./why.js";

export function mountPlan(store, { look, refresh }) {
  const body = document.getElementById("plan");
  const detail = createDetail();
  let changed = null;
  const picture = createPicture({
    onChoose(action) {
      if (store.get().plan) detail.look(store.get().plan, action, changed.of.get(action?.id));
      if (store.get().action !== (action?.id ?? null)) store.update({ action: action?.id ?? null });
    },
  });
  const views = { picture: el("div", {}, picture.node, detail.node), table: el("div") };
  let drawn = null;
  mountDecisionKeys();
  store.subscribe((state) => {
    const { goal, plan, before, mission } = state;
    const key = JSON.stringify([goal?.state, goal?.alternatives, plan, before?.id, state.choices]);
    // A comment being written survives other news.
    if (key !== drawn) {
      drawn = key;
      const held = document.activeElement?.dataset.keep;
      replace(body, plan ? card(plan, before, views, refresh, choices(goal, plan, state.choices, { look, refresh })) : null);
      if (plan) {
        changed = changes(plan, before);
        replace(views.table, actionTable(plan, changed));
        picture.show(plan, changed);
        detail.look(plan, null);
        const again = held && body.querySelector(`[data-keep="${CSS.escape(held)}"]`);
        again?.focus({ preventScroll: true });
        again?.setSelectionRange?.(again.value.length, again.value.length);
      }
    }
    if (state.replaying) return; // the player says what happens then
    const runs = plan && mission?.plan_id === plan.id ? mission : null;
    picture.happens(runs, runs && state.worldTimes[runs.world], runs ? notHeard(runs, state) : []);
  });
  return picture;
}

function card(plan, before, views, refresh, alternatives) {
  return el(
    "article",
    { class: "card", "data-testid": "plan" },
    el(
      "div",
      { class: "head" },
      el("h3", {}, `Plan: ${plan.actions.length} actions, ${seconds(plan.makespan_s)}`),
      el("span", { class: `badge ${tone(plan.state)}`, "data-testid": "plan-state" }, words(plan.state)),
    ),
    el("p", { class: "quiet small" }, provenance(plan)),
    figures(plan),
    late(plan),
    repair(plan, before),
    plan.label ? el("p", { class: "quiet small" }, [plan.label, plan.comparison].filter(Boolean).join(": ")) : null,
    plan.state === "proposed" ? decision(plan, refresh) : decided(plan),
    alternatives,
    switched(views),
    legend(plan),
    why(plan),
    recruitment(plan),
    linkList(plan),
  );
}

// The robots at work that are not heard, with the seconds of their plan since when.
function notHeard(mission, state) {
  const start = begun(mission);
  return typeof start !== "number" ? [] : unheardOn(mission, state.robots, state.worldTimes[mission.world]).map((one) => ({ ...one, since: one.since - start }));
}

// The picture or the table, as the operator likes it.
function switched(views) {
  const buttons = {};
  const turn = (name) => {
    remember("plan-view", name);
    for (const [other, view] of Object.entries(views)) {
      view.hidden = other !== name;
      buttons[other].setAttribute("aria-pressed", String(other === name));
    }
  };
  for (const name of Object.keys(views)) buttons[name] = el("button", { type: "button", "data-testid": `plan-as-${name}`, onclick: () => turn(name) }, name === "picture" ? "Picture" : "Table");
  turn(recall("plan-view", "picture") === "table" ? "table" : "picture");
  return [el("div", { class: "switch", role: "group", "aria-label": "Show the plan as" }, Object.values(buttons)), Object.values(views)];
}

function legend(plan) {
  const told = [["bar-key", "planned"], ["window-key", "may start as late as this"], ["critical-key", "critical"], ["link-key", "causal link between robots"]];
  if (plan.repairs) told.push(["new-key", "new"]);
  if (plan.repairs && plan.state !== "approved") told.push(["dropped-key", "dropped"], ["window-key", "as it was before"]);
  if (plan.state === "approved") told.push(["actual-key", "what happened"], ["overrun-key", "longer than planned"]);
  return el("ul", { class: "legend", "aria-label": "Legend" }, told.map(([key, text]) => el("li", {}, el("span", { class: key }), text)));
}

function provenance(plan) {
  return [plan.engine && `by ${plan.engine}`, typeof plan.planning_s === "number" && `in ${plan.planning_s.toFixed(2)} s`, plan.robots?.length && `with ${plan.robots.join(", ")}`]
    .filter(Boolean)
    .join(" ");
}

function figures(plan) {
  const told = [
    gap(plan.makespan_s, plan.lower_bound_s),
    plan.distance_m ? `${plan.distance_m.toFixed(1)} m to drive` : "",
    plan.energy_j ? `${Math.round(plan.energy_j)} J` : "",
    plan.clearances ? `${plan.clearances} ${plan.clearances === 1 ? "wait" : "waits"} to be cleared` : "",
  ].filter(Boolean);
  return told.length ? el("p", { class: "small", "data-testid": "figures" }, told.join(" · ")) : null;
}

function late(plan) {
  if (!plan.late?.length) return null;
  return el("ul", { class: "problem", "data-testid": "late" }, plan.late.map(({ goal, late_s }) => el("li", {}, `${fact(goal)} comes ${seconds(late_s)} after its deadline`)));
}

// Who decided what, when and why; of a plan that nobody may decide on any more, what has become of it.
function decided(plan) {
  const by = plan.decided_by ? `${words(plan.state)} by ${plan.decided_by}${plan.decided_at ? `, ${instant(plan.decided_at)}` : ""}` : "";
  const told = [by, plan.comment ? `“${plan.comment}”` : "", plan.reason ?? ""].filter(Boolean);
  return told.length ? el("p", { class: "note", "data-testid": "plan-decided" }, told.join(": ")) : null;
}

function recruitment(plan) {
  const reasons = Object.entries(plan.recruitment ?? {});
  if (!reasons.length) return null;
  return el(
    "details",
    {},
    el("summary", {}, "Why these robots"),
    el("dl", {}, reasons.map(([robot, reason]) => [el("dt", {}, robot), el("dd", {}, String(reason))])),
  );
}

function linkList(plan) {
  const links = plan.causal_links ?? [];
  if (!links.length) return null;
  return el(
    "details",
    { "data-testid": "causal-links" },
    el("summary", {}, `Causal links (${links.length})`),
    el("ul", { class: "links" }, links.map((link) => el(
      "li",
      {},
      el("span", { class: "quiet" }, link.producer),
      " → ",
      el("code", {}, fact(link.fact)),
      " → ",
      el("span", { class: "quiet" }, link.consumer),
    ))),
  );
}
