// Requests what the page shows, and after an event only what it has changed.

import { get, getOrNull, id, list } from "./page/api.js";
import { newestFirst } from "./page/format.js";
import { responseOrder, throttled } from "./page/store.js";

const RETRY_MS = 1000;
const PAGE = 50;
const MAX_SINGLE_REQUESTS = 8; // beyond, the whole page is quicker
const MAX_LIMIT = 1000;

/**
 * The newest goals or missions: a page of them is requested once, and then only those that have changed.
 * @template {{id: string, created_at: string}} T
 * @param {string} path
 */
function createListing(path) {
  /** @type {Set<string>} */
  const changed = new Set();
  /** @type {{items: T[], hasOlder: boolean}} */
  let known = { items: [], hasOlder: false };
  let limit = PAGE;
  let wantsPage = true;

  async function page() {
    const { items, next } = await get(`${path}?limit=${Math.min(limit, MAX_LIMIT)}`);
    return { items, hasOlder: Boolean(next) };
  }

  /** @param {string[]} ids */
  async function updated(ids) {
    /** @type {(T | null)[]} */
    const answers = await Promise.all(ids.map((one) => getOrNull(`${path}/${id(one)}`)));
    const fresh = new Map(answers.filter((one) => one !== null).map((one) => [one.id, one]));
    const kept = known.items.filter((one) => fresh.has(one.id) || !ids.includes(one.id)).map((one) => fresh.get(one.id) ?? one);
    const oldest = known.hasOlder ? kept.reduce((least, one) => (one.created_at < least ? one.created_at : least), "~") : "";
    const added = [...fresh.values()].filter((one) => one.created_at > oldest && !kept.some((other) => other.id === one.id));
    return { items: [...added, ...kept], hasOlder: known.hasOlder };
  }

  return {
    requestOlder() {
      limit += PAGE;
      wantsPage = true;
    },
    /** @param {string} one */
    markChanged: (one) => changed.add(one),
    markAll() {
      wantsPage = true;
    },
    async fetch() {
      const ids = [...changed];
      if (!wantsPage && !ids.length) return known;
      const isWhole = wantsPage || ids.length > MAX_SINGLE_REQUESTS;
      changed.clear();
      wantsPage = false;
      try {
        known = isWhole ? await page() : await updated(ids);
      } catch (problem) {
        wantsPage = true;
        throw problem;
      }
      return known;
    },
  };
}

/**
 * @param {Store} store
 * @param {(kind: string, request: () => Promise<void>) => Promise<void>} track runs a request and shows whether it succeeded
 */
export function createLoading(store, track) {
  // What has changed since it was last requested, beside goals and missions.
  const none = { all: false, plan: false, robots: false, world: false, holds: false };
  const changes = { ...none, all: true };
  const robotsOrder = responseOrder();
  /** @type {number | undefined} */
  let retry;
  /** @type {ReturnType<typeof createListing<Goal>>} */
  const goalList = createListing("/v1/goals");
  /** @type {ReturnType<typeof createListing<Mission>>} */
  const missionList = createListing("/v1/missions");
  const refresh = throttled(() => document.hidden || track("lists", load));
  document.addEventListener("visibilitychange", refresh); // changes are only noted while the page is hidden

  async function load() {
    const noted = { ...changes };
    Object.assign(changes, none);
    try {
      await loadChanged(noted);
    } catch (problem) {
      changes.all = true;
      clearTimeout(retry);
      retry = setTimeout(refresh, RETRY_MS); // does not wait for the next event
      throw problem;
    }
  }

  /** @param {typeof changes} noted */
  async function loadChanged({ all, ...changed }) {
    const before = { ...store.get() };
    const [{ items: goals, hasOlder: olderGoals }, { items: missions, hasOlder: olderMissions }] = await Promise.all([
      goalList.fetch(),
      missionList.fetch(),
      all || changed.robots ? loadRobots() : null,
    ]);
    const lists = { goals, missions, hasOlder: { goals: olderGoals, missions: olderMissions } };
    if (before.goal === undefined) store.update(lists); // the rest takes longer
    const wanted = store.get().selected;
    /** @type {Goal | null} */
    const goal = (wanted && (goals.find((one) => one.id === wanted) ?? (await getOrNull(`/v1/goals/${id(wanted)}`)))) || newestFirst(goals)[0] || null;
    const { world } = store.get();
    const isSamePlan = !all && !changed.plan && before.goal?.id === goal?.id;
    const about = `/v1/worlds/${id(world ?? "")}`;
    const [details, unknown, holds] = await Promise.all([
      goalDetails(goal, missions, before, isSamePlan),
      world && (all || changed.world) ? list(`${about}/unknown`) : before.unknown,
      world && (all || changed.holds) ? list(`${about}/holds`) : before.holds,
    ]);
    if (store.get().selected !== wanted) store.update({ unknown, holds }); // another goal was selected meanwhile and is requested next
    else store.update({ ...lists, selected: goal?.id ?? null, goal, unknown, holds, ...details });
  }

  async function loadRobots() {
    const isCurrent = robotsOrder();
    const [robots, peripherals] = await Promise.all(["/v1/robots", "/v1/peripherals"].map(list));
    if (isCurrent()) store.update({ robots, peripherals });
  }

  /**
   * The selected goal's plan, the one that it replaces, the alternatives, and its mission.
   * @param {Goal | null} goal @param {Mission[]} missions @param {State} before @param {boolean} isSamePlan
   */
  async function goalDetails(goal, missions, before, isSamePlan) {
    // After a replan a goal has several missions: the newest counts.
    const missionId = goal?.mission_id ?? newestFirst(missions.filter((mission) => mission.goal_id === goal?.id))[0]?.id;
    const areSame = isSamePlan && before.goal === goal && before.alternatives.length > 0;
    /** @type {Plan[]} */
    const alternatives = !goal?.alternatives ? [] : areSame ? before.alternatives : await list(`/v1/goals/${id(goal.id)}/plans`);
    const planId = alternatives.find((one) => one.id === store.get().viewedPlan)?.id ?? goal?.plan_id;
    /** @type {[Plan | null, Mission | null]} */
    const [plan, mission] = await Promise.all([
      !planId ? null : isSamePlan && before.plan?.id === planId ? before.plan : get(`/v1/plans/${id(planId)}`),
      !missionId ? null : (missions.find((one) => one.id === missionId) ?? get(`/v1/missions/${id(missionId)}`)),
    ]);
    return { plan, alternatives, mission, previousPlan: plan?.repairs ? await replacedPlan(plan.repairs.plan_id) : null };
  }

  /** A replaced plan changes no more. @param {string} planId */
  function replacedPlan(planId) {
    const { previousPlan } = store.get();
    return previousPlan?.id === planId ? previousPlan : getOrNull(`/v1/plans/${id(planId)}`);
  }

  function refreshAll() {
    changes.all = true;
    goalList.markAll();
    missionList.markAll();
    refresh();
  }

  /** Note what an event has changed. One without a time reports a state: events were missed. @param {ServiceEvent} event */
  function onEvent({ type = "", subject = "", time, data }) {
    if (time === null) {
      refreshAll();
      return;
    }
    const [kind] = type.split(".");
    const mission = data?.mission ?? /^mission-[^-:]+/.exec(subject)?.[0]; // a script's id contains its mission's
    const missionGoal = kind === "mission" ? store.get().missions.find((one) => one.id === mission)?.goal_id : undefined;
    const goal = data?.goal ?? (kind === "goal" ? subject : missionGoal);
    if (mission) missionList.markChanged(mission);
    if (goal) goalList.markChanged(goal);
    else if (kind === "plan") goalList.markAll();
    if (kind === "plan") changes.plan = true;
    else if (kind === "world" || kind === "hold") {
      changes[kind === "hold" ? "holds" : "world"] = true;
      changes.plan ||= store.get().plan?.state === "proposed"; // the change may have outdated it
    } else if (!mission && kind !== "goal") changes.all = true;
    if (/^(mission|script|world.(changed|added|removed))/.test(type)) changes.robots = true;
    refresh();
  }

  return {
    refresh,
    refreshAll,
    onEvent,
    loadRobots,
    onWorldChange() {
      changes.world = true;
      changes.holds = true;
      refresh();
    },
    /** @param {"goals" | "missions"} name */
    loadOlder(name) {
      (name === "goals" ? goalList : missionList).requestOlder();
      refresh();
    },
  };
}
