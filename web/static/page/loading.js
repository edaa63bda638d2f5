// Asks the service for what the page shows, and after an event only for what that has changed.

import { newestFirst } from "../goals/list.js";
import { get, id, list } from "./api.js";
import { createListing, thereOrNull } from "./listing.js";
import { gathered, inOrder } from "./state.js";

const AGAIN_MS = 1000;

export function createLoading(store, asked) {
  // What has changed since it was last asked for, beside goals and missions.
  const news = { all: true, plan: false, robots: false, world: false };
  const robotsAsked = inOrder();
  let again = 0;
  const goalsListed = createListing("goals");
  const missionsListed = createListing("missions");
  const refresh = gathered(() => document.hidden || asked("lists", load));
  document.addEventListener("visibilitychange", refresh); // what came while the page was hidden was only noted

  async function load() {
    const changed = { ...news };
    Object.assign(news, { all: false, plan: false, robots: false, world: false });
    try {
      await loadChanged(changed);
    } catch (problem) {
      news.all = true;
      clearTimeout(again);
      again = setTimeout(refresh, AGAIN_MS); // no event may come for long
      throw problem;
    }
  }

  async function loadChanged({ all, ...changed }) {
    const was = store.get();
    const [goalPage, missionPage] = await Promise.all([goalsListed.fetch(), missionsListed.fetch(), (all || changed.robots) && loadRobots()]);
    const [goals, missions] = [goalPage.items, missionPage.items];
    const more = { goals: goalPage.more, missions: missionPage.more };
    if (was.goal === undefined) store.update({ goals, missions, more }); // the rest takes longer
    const wanted = store.get().selected;
    const goal = (wanted && (goals.find((one) => one.id === wanted) ?? (await thereOrNull(`/v1/goals/${id(wanted)}`)))) ?? newestFirst(goals)[0] ?? null;
    const selected = goal?.id ?? null;
    const { world } = store.get();
    const [around, unknown] = await Promise.all([
      aboutGoal(goal, missions, was, !all && !changed.plan && was.goal?.id === selected),
      !world ? [] : all || changed.world ? list(`/v1/worlds/${id(world)}/unknown`) : was.unknown,
    ]);
    if (store.get().selected !== wanted) return store.update({ unknown }); // another goal was chosen meanwhile, and is asked about next
    store.update({ goals, missions, more, selected, goal, unknown, ...around });
  }

  async function loadRobots() {
    const isNews = robotsAsked();
    const robots = await list("/v1/robots");
    if (isNews()) store.update({ robots });
  }

  // The selected goal's plan, that which it takes the place of, those to choose from, and its mission.
  async function aboutGoal(goal, missions, was, isSame) {
    // A mission of the same goal may be followed by another after a replan: the latest counts.
    const missionId = goal?.mission_id ?? newestFirst(missions.filter((mission) => mission.goal_id === goal?.id))[0]?.id;
    const choices = !goal?.alternatives ? [] : isSame && was.goal === goal && was.choices.length ? was.choices : await list(`/v1/goals/${id(goal.id)}/plans`);
    const looked = choices.find((choice) => choice.id === store.get().look)?.id ?? goal?.plan_id;
    const [plan, mission] = await Promise.all([
      !looked ? null : isSame && was.plan?.id === looked ? was.plan : get(`/v1/plans/${id(looked)}`),
      !missionId ? null : missions.find((one) => one.id === missionId) ?? get(`/v1/missions/${id(missionId)}`),
    ]);
    return { plan, choices, mission, before: plan?.repairs ? await replaced(plan.repairs.plan_id) : null };
  }

  // A plan that was replaced changes no more.
  function replaced(planId) {
    const { before } = store.get();
    return before?.id === planId ? before : thereOrNull(`/v1/plans/${id(planId)}`);
  }

  function refreshAll() {
    news.all = true;
    goalsListed.all();
    missionsListed.all();
    refresh();
  }

  // Notes what an event has changed. Without a time it tells how things stand: too much was missed meanwhile.
  function note({ type = "", subject = "", time, data }) {
    if (time === null) return refreshAll();
    const [kind] = type.split(".");
    const mission = data?.mission ?? (/^mission-[^-:]+/.exec(subject)?.[0] ?? null); // a script is called by its mission and robot
    const goal = data?.goal ?? (kind === "goal" ? subject : kind === "mission" && store.get().missions.find((one) => one.id === mission)?.goal_id);
    if (mission) missionsListed.changed(mission);
    if (goal) goalsListed.changed(goal);
    else if (kind === "plan") goalsListed.all();
    if (kind === "plan") news.plan = true;
    else if (kind === "world") {
      news.world = true;
      news.plan ||= store.get().plan?.state === "proposed"; // it may be overtaken by now
    } else if (!mission && kind !== "goal") news.all = true;
    if (kind === "mission" || kind === "script") news.robots = true;
    refresh();
  }

  return {
    refresh,
    refreshAll,
    note,
    loadRobots,
    worldChanged() {
      news.world = true;
      refresh();
    },
    older(which) {
      (which === "goals" ? goalsListed : missionsListed).older();
      refresh();
    },
  };
}
