// The middle pane's plan: its actions and their times, how good it is, why these robots; and the decision on it.

import { planStart, silences } from "../mission/timing.js";
import { get, id } from "../page/api.js";
import { badge, byId, el, replace, show } from "../page/dom.js";
import { gap, instant, seconds, tone, words } from "../page/format.js";
import { part, whenOpened } from "../page/part.js";
import { loadPreference, savePreference } from "../page/preferences.js";
import { problemBox } from "../page/problem.js";
import { NO_CHANGES, createPicture } from "./picture.js";

/** @typedef {{viewPlan: (planId: string) => void, refresh: () => void}} Actions */
/** What some plans need in addition. @typedef {{decision?: typeof import("./decision.js"), chance?: typeof import("./chance.js"), comparison?: typeof import("./comparison.js"), repair?: typeof import("./repair.js"), shortfalls?: typeof import("./shortfalls.js")}} Extras */

const fetchAction = part(() => import("./action_detail.js"));
const fetchDetails = part(() => import("./details.js"));
const fetchTable = part(() => import("./table.js"));
const fetchEdit = part(() => import("./edit.js"), "edit");
const fetchExtra = {
  decision: part(() => import("./decision.js")),
  chance: part(() => import("./chance.js")),
  comparison: part(() => import("./comparison.js"), "comparison"),
  repair: part(() => import("./repair.js")),
  shortfalls: part(() => import("./shortfalls.js")),
};
const HINT = "Point at an action, or go there with the arrow keys, to see what it needs and why it is there.";

/** @param {Store} store @param {Actions} actions */
export function mountPlan(store, actions) {
  const body = byId("plan", HTMLElement);
  const detail = el("div", { class: "detail", "data-testid": "action-detail", role: "status" });
  /** @type {string | null} */
  let lookedAt = null;
  let changes = NO_CHANGES;
  /** Fetched when a plan that needs them is first shown. @type {Extras} */
  const extras = {};
  const picture = createPicture((action) => {
    const { plan, action: selected } = store.get();
    if (plan) showDetail(plan, action);
    if (selected !== (action?.id ?? null)) store.update({ action: action?.id ?? null });
  });
  const chance = el("div");
  const views = { picture: el("div", {}, picture.node, detail), table: el("div") };
  let drawn = "";

  /** The action under the pointer or selected. @param {Plan} plan @param {PlannedAction | null} action */
  async function showDetail(plan, action) {
    lookedAt = action?.id ?? null;
    if (!action) {
      show(detail, el("p", { class: "quiet small" }, HINT));
      return;
    }
    const isShown = () => lookedAt === action.id;
    try {
      const { showAction } = await fetchAction();
      if (isShown()) await showAction(detail, plan, action, changes.byAction.get(action.id), isShown);
    } catch (error) {
      if (isShown()) show(detail, problemBox(error));
    }
  }

  async function showTable() {
    try {
      const { actionTable } = await fetchTable();
      const { plan } = store.get();
      replace(views.table, plan && actionTable(plan, changes));
    } catch (error) {
      replace(views.table, problemBox(error));
    }
  }

  /** @param {(keyof Extras)[]} names */
  async function fetchExtras(names) {
    try {
      const modules = await Promise.all(names.map(async (name) => [name, await fetchExtra[name]()]));
      const isFirst = !extras.decision;
      Object.assign(extras, Object.fromEntries(modules));
      if (isFirst) extras.decision?.mountDecisionKeys();
      store.update({});
    } catch (error) {
      drawn = "";
      show(body, problemBox(error));
    }
  }

  /** @param {State} state @param {Plan | null} plan */
  function draw(state, plan) {
    const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.keep : undefined;
    replace(body, plan ? card(plan, state, chance, views, showTable, actions, extras) : null);
    if (!plan) return;
    changes = (plan.repairs && extras.repair?.planChanges(plan, state.previousPlan)) ?? NO_CHANGES;
    picture.show(plan, changes);
    showDetail(plan, null);
    // A comment that is being written keeps the focus and its cursor.
    const again = focused && body.querySelector(`[data-keep="${CSS.escape(focused)}"]`);
    if (again instanceof HTMLElement) again.focus({ preventScroll: true });
    if (again instanceof HTMLInputElement) again.setSelectionRange(again.value.length, again.value.length);
  }

  store.subscribe((state) => {
    const { goal, plan, previousPlan, mission, replaying, worldTimes } = state;
    const key = JSON.stringify([goal?.state, goal?.alternatives, mission?.plan_id, plan, previousPlan?.id, state.alternatives], steady);
    const wanted = extrasOf(state).filter((name) => !extras[name]);
    if (wanted.length) {
      fetchExtras(wanted);
      return;
    }
    if (key !== drawn) {
      drawn = key;
      draw(state, plan);
    }
    show(chance, typeof plan?.forecast?.on_time === "number" && extras.chance?.chance(plan, plan.forecast, worldTimes[goal?.world ?? ""])); // it sinks while the plan waits
    if (replaying) return; // the player draws the recorded progress
    const isExecuted = plan && mission?.plan_id === plan.id;
    if (isExecuted) picture.showProgress(mission, worldTimes[mission.world], planSilences(mission, state));
    else picture.showProgress(null, null);
  });
  return picture;
}

/** @param {State} state @returns {(keyof Extras)[]} */
function extrasOf({ plan, alternatives }) {
  const isProposed = plan?.state === "proposed";
  const needs = { decision: isProposed, chance: typeof plan?.forecast?.on_time === "number", comparison: isProposed && alternatives.length > 1, repair: Boolean(plan?.repairs), shortfalls: Boolean(plan?.late?.length || plan?.left_out?.length || plan?.preferences?.outcomes.length) };
  return /** @type {(keyof Extras)[]} */ (Object.keys(needs)).filter((name) => needs[name]);
}

/** @param {Plan} plan @param {State} state @param {HTMLElement} chance @param {Record<string, HTMLElement>} views @param {() => void} showTable @param {Actions} actions @param {Extras} extras */
function card(plan, state, chance, views, showTable, { viewPlan, refresh }, { decision, comparison, repair, shortfalls }) {
  return el(
    "article",
    { class: "card", "data-testid": "plan" },
    el(
      "div",
      { class: "head" },
      el("h3", {}, `Plan: ${plan.actions.length} actions, ${seconds(plan.makespan_s)}`),
      badge(tone(plan.state), words(plan.state), { "data-testid": "plan-state" }),
    ),
    el("p", { class: "quiet small" }, provenance(plan)),
    figures(plan),
    chance,
    shortfalls?.shortfalls(plan),
    repair?.repairNote(plan, state.previousPlan),
    plan.label ? el("p", { class: "quiet small" }, [plan.label, plan.comparison].filter(Boolean).join(": ")) : null,
    plan.state === "proposed" ? decision?.decision(plan, state, refresh, state.alternatives.length > 1 && comparison?.comparison(plan, state.alternatives, viewPlan)) : decisionTaken(plan),
    isChangeable(plan, state) ? whenOpened(el("details", { "data-testid": "edit" }, el("summary", {}, "Change this plan")), async () => (await fetchEdit()).editForm(plan, state, refresh)) : null,
    viewChoice(views, showTable),
    legend(plan),
    later("why", "Why this plan", async ({ reasons }) => reasons(await get(`/v1/plans/${id(plan.id)}/explanation`))),
    plan.forecast?.goals.length ? later("forecast", "When goals are likely achieved", ({ likelyTimes }) => likelyTimes(/** @type {PlanForecast} */ (plan.forecast))) : null,
    later("robots", "Why these robots", ({ robots }) => robots(plan)),
    plan.causal_links?.length ? later("causal-links", `Causal links (${plan.causal_links.length})`, ({ links }) => links(plan)) : null,
  );
}

/** It is proposed, or its mission carries it out. @param {Plan} plan @param {State} state */
function isChangeable(plan, { goal, mission }) {
  return plan.state === "proposed" || (goal?.state === "committed" && mission?.plan_id === plan.id);
}

/** Leaves out of a key what sinks while a plan waits. @param {string} name @param {unknown} value */
function steady(name, value) {
  if (name === "forecast") return undefined;
  return name === "on_time" && typeof value === "number" ? Math.round(100 * value) : value;
}

/** The mission's silent robots, with the seconds since the plan's start. @param {Mission} mission @param {State} state */
function planSilences(mission, { robots, worldTimes }) {
  const start = planStart(mission);
  if (typeof start !== "number") return [];
  return silences(mission, robots, worldTimes[mission.world]).map((one) => ({ ...one, since: one.since - start }));
}

/** Picture or table, as the operator prefers. @param {Record<string, HTMLElement>} views @param {() => void} showTable */
function viewChoice(views, showTable) {
  const buttons = Object.keys(views).map((name) => el("button", { "data-testid": `plan-as-${name}`, onclick: () => choose(name) }, name === "picture" ? "Picture" : "Table"));
  /** @param {string} chosen */
  function choose(chosen) {
    savePreference("plan-view", chosen);
    Object.entries(views).forEach(([name, view], index) => {
      view.hidden = name !== chosen;
      buttons[index].setAttribute("aria-pressed", String(name === chosen));
    });
    if (chosen === "table") showTable();
  }
  choose(loadPreference("plan-view", "picture") === "table" ? "table" : "picture");
  return [el("div", { class: "switch", role: "group", "aria-label": "Show the plan as" }, buttons), Object.values(views)];
}

/** @param {Plan} plan */
function legend(plan) {
  const isApproved = plan.state === "approved";
  const keys = [["bar-key", "planned"], ["window-key", "may start as late as this"], ["critical-key", "critical"], ["link-key", "causal link between robots"]];
  if (plan.repairs) keys.push(["new-key", "new"]);
  if (plan.repairs && !isApproved) keys.push(["dropped-key", "dropped"], ["window-key", "as it was before"]);
  if (isApproved) keys.push(["actual-key", "what happened"], ["overrun-key", "longer than planned"]);
  return el("ul", { class: "legend", "aria-label": "Legend" }, keys.map(([key, text]) => el("li", {}, el("span", { class: key }), text)));
}

/** @param {Plan} plan */
function provenance({ engine, planning_s: duration, robots }) {
  return [engine && `by ${engine}`, typeof duration === "number" && `in ${duration.toFixed(2)} s`, robots?.length && `with ${robots.join(", ")}`].filter(Boolean).join(" ");
}

/** @param {Plan} plan */
function figures(plan) {
  const texts = [
    gap(plan.makespan_s, plan.lower_bound_s),
    plan.distance_m ? `${plan.distance_m.toFixed(1)} m to drive` : "",
    plan.energy_j ? `${Math.round(plan.energy_j)} J` : "",
    plan.clearances ? `${plan.clearances} ${plan.clearances === 1 ? "wait" : "waits"} to be cleared` : "",
  ].filter(Boolean);
  return texts.length ? el("p", { class: "small", "data-testid": "figures" }, texts.join(" · ")) : null;
}

/** Who decided what, when and why; for a plan that can no longer be decided on, the reason. @param {Plan} plan */
function decisionTaken(plan) {
  const by = plan.decided_by ? `${words(plan.state)} by ${plan.decided_by}${plan.decided_at ? `, ${instant(plan.decided_at)}` : ""}` : "";
  const texts = [by, plan.comment ? `“${plan.comment}”` : "", plan.reason ?? ""].filter(Boolean);
  return texts.length ? el("p", { class: "note", "data-testid": "plan-decided" }, texts.join(": ")) : null;
}

/** What is drawn once it is opened. @param {string} name @param {string} title @param {(drawn: typeof import("./details.js")) => Child | Promise<Child>} draw */
function later(name, title, draw) {
  return whenOpened(el("details", { "data-testid": name }, el("summary", {}, title)), async () => draw(await fetchDetails()));
}
