// The interactive picture of a plan, graph and Gantt chart in one: pointer and arrow keys select actions, and the mission's
// progress is drawn beneath them.

import { elapsed, planStart } from "../mission/timing.js";
import { badge, closest, el, replace, show, svg } from "../page/dom.js";
import { byNumber } from "../page/format.js";
import { LANE_PX, TOP_PX, actionBar, actualTimes, background, causalLinks, definitions, pictureScale, silentLanes } from "./drawing.js";

const MIN_WIDTH_PX = 260;
const ZOOM = 1.5;
const MAX_ZOOM = 16;
/** @type {PlanChanges} */
export const NO_CHANGES = { byAction: new Map(), previous: [], draw: () => [] };

/** @param {(action: PlannedAction | null) => void} onSelect @returns {Picture} */
export function createPicture(onSelect) {
  const names = el("ul", { class: "lane-names", "aria-hidden": "true" });
  const scroller = el("div", { class: "picture-scroller" });
  /** @param {string} sign @param {string} label @param {number} factor */
  const zoomButton = (sign, label, factor) => el("button", { "aria-label": label, title: label, onclick: () => zoomBy(factor) }, sign);
  const node = el("div", { class: "picture", "data-testid": "picture" }, names, scroller, el("div", { class: "zoom" }, zoomButton("−", "Narrower", 1 / ZOOM), zoomButton("+", "Wider", ZOOM)));
  const layers = { silent: svg("g"), links: svg("g", { class: "links" }), previous: svg("g"), bars: svg("g"), actual: svg("g"), selectedLinks: svg("g", { class: "links chosen" }) };
  /** @type {Plan | null} */
  let plan = null;
  let changes = NO_CHANGES;
  /** @type {Mission | null} */
  let mission = null;
  /** @type {number | null} */
  let spent = null; // seconds since the plan's start
  /** @type {Silence[]} */
  let silences = [];
  let zoom = 1;
  /** @type {string | null} */
  let selected = null;
  /** @type {PictureScale | null} */
  let scale = null;
  /** @type {number | null} */
  let drawnDeadline = null;

  function draw() {
    if (!plan || !scroller.clientWidth) return;
    drawnDeadline = deadline();
    const focused = bars().find((bar) => bar === document.activeElement)?.dataset.action;
    const drawn = pictureScale(plan, Math.max(MIN_WIDTH_PX, (scroller.clientWidth - 1) * zoom), spent, changes.previous, drawnDeadline);
    scale = drawn;
    replace(layers.links, causalLinks(plan, drawn));
    replace(layers.previous, changes.draw(drawn));
    replace(layers.bars, inOrder().map((action) => actionBar(action, drawn, changes.byAction.get(action.id))));
    replace(scroller, svg(
      "svg",
      { width: drawn.width, height: drawn.height, class: "lanes", role: "group", "aria-label": "The plan's actions over time, a lane a robot; arrow keys go from one to the next" },
      definitions(),
      background(drawn),
      Object.values(layers),
    ));
    replace(names, drawn.robots.map((robot) => {
      const name = el("li", { title: robot });
      name.style.height = `${LANE_PX}px`;
      return name;
    }));
    names.style.paddingTop = `${TOP_PX}px`;
    setTabStop(selected ?? inOrder()[0]?.id);
    highlight(selected);
    drawProgress(drawn);
    if (focused) focus(focused);
  }

  const deadline = () => (mission && typeof mission.deadline_s === "number" && spent !== null ? mission.deadline_s - planStart(mission) : null);
  const inOrder = () => [...(plan?.actions ?? [])].sort((one, other) => one.earliest_start_s - other.earliest_start_s || byNumber(one.id, other.id));
  const bars = () => [...layers.bars.children].filter((bar) => bar instanceof SVGElement);

  /** @param {PictureScale} drawn */
  function drawProgress(drawn) {
    const lanes = silentLanes(silences, drawn, spent ?? 0);
    replace(layers.actual, mission ? actualTimes(mission, drawn, spent, silences) : [], lanes.map(({ words }) => words));
    replace(layers.silent, lanes.map(({ hatch }) => hatch));
    drawn.robots.forEach((robot, lane) => {
      const silence = silences.find((one) => one.robot === robot);
      show(names.children[lane], el("span", {}, robot), silence ? badge(silence.tone, silence.word) : null);
    });
  }

  /** @param {string | null} action */
  function highlight(action) {
    for (const bar of bars()) {
      bar.setAttribute("aria-pressed", String(bar.dataset.action === selected));
      bar.classList.toggle("looked-at", bar.dataset.action === action);
    }
    layers.links.classList.toggle("faint", Boolean(action));
    replace(layers.selectedLinks, action && plan && scale ? causalLinks(plan, scale, action) : []);
  }

  /** @param {string | null} action */
  function view(action) {
    highlight(action);
    onSelect(scale?.actions.get(action ?? "") ?? null);
  }

  /** @param {string | null} action */
  function toggle(action) {
    selected = selected === action ? null : action;
    view(selected);
  }

  /** @param {string | undefined} action */
  const focus = (action) => bars().find((bar) => bar.dataset.action === action)?.focus();

  /** One bar is reached by the tab key; the arrow keys go on from there. @param {string | undefined} action */
  function setTabStop(action) {
    for (const bar of bars()) bar.setAttribute("tabindex", bar.dataset.action === action ? "0" : "-1");
  }

  /** @param {string} name @param {string} key */
  function neighbour(name, key) {
    const from = scale?.actions.get(name);
    if (!scale || !from) return undefined;
    const lane = scale.robots.indexOf(from.agents[0]);
    /** @param {string | undefined} robot */
    const inLane = (robot) => inOrder().filter((other) => other.agents.includes(robot ?? ""));
    if (key === "ArrowRight" || key === "ArrowLeft") {
      const row = inLane(scale.robots[lane]);
      return row[row.indexOf(from) + (key === "ArrowRight" ? 1 : -1)];
    }
    /** @param {PlannedAction} other */
    const distance = (other) => Math.abs(other.earliest_start_s - from.earliest_start_s);
    return inLane(scale.robots[lane + (key === "ArrowDown" ? 1 : -1)]).sort((one, other) => distance(one) - distance(other))[0];
  }

  /** @param {Event} event */
  const actionOf = (event) => closest(event, "[data-action]")?.dataset.action ?? null;
  scroller.addEventListener("click", (event) => toggle(actionOf(event)));
  scroller.addEventListener("pointerover", (event) => {
    const action = actionOf(event);
    if (action) view(action);
  });
  scroller.addEventListener("pointerleave", () => scale && view(selected));
  scroller.addEventListener("focusin", (event) => {
    const action = actionOf(event);
    if (!action) return;
    setTabStop(action);
    view(action);
  });
  scroller.addEventListener("keydown", (event) => {
    const action = actionOf(event);
    if (!action) return;
    if (event.key === "Enter" || event.key === " ") toggle(action);
    else if (event.key === "Escape") toggle(null);
    else if (event.key.startsWith("Arrow")) {
      const next = neighbour(action, event.key);
      focus(next?.id);
    } else return;
    event.preventDefault();
  });
  new ResizeObserver(() => requestAnimationFrame(draw)).observe(scroller);

  /** @param {number} factor */
  function zoomBy(factor) {
    zoom = Math.min(MAX_ZOOM, Math.max(1, zoom * factor));
    draw();
  }

  return {
    node,
    show(shownPlan, shownChanges = NO_CHANGES) {
      if (plan?.id !== shownPlan.id) {
        selected = null;
        zoom = 1;
      }
      plan = shownPlan;
      changes = shownChanges;
      draw();
    },
    // Draw the mission as it was at `time` of the world's clock; null without one.
    showProgress(shownMission, time, shownSilences = []) {
      mission = shownMission;
      spent = mission && elapsed(mission, time, planStart(mission));
      silences = shownSilences;
      if (!scale || !plan) return;
      const isBeyond = spent !== null && spent > scale.end * 1.001 && mission?.ended_at_s === null;
      if (isBeyond || deadline() !== drawnDeadline) draw();
      else drawProgress(scale);
    },
  };
}
