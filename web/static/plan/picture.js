// The picture of a plan, graph and Gantt chart in one: drawn to the pane's width, walked through by pointer or arrow
// keys, and filled from beneath by what truly happens once its mission runs.

import { begun, elapsed } from "../mission/elapsed.js";
import { el, replace, show, svg } from "../page/dom.js";
import { LANE_PX, TOP_PX, actual, backdrop, bar, definitions, ghost, layout, links, unheard } from "./drawing.js";

const NARROWEST_PX = 260;
const ZOOM = 1.5;
const NOTHING = { of: new Map(), ghosts: [] };

// `onChoose` hears of the action that is looked at, or of null.
export function createPicture({ onChoose }) {
  const names = el("ul", { class: "lane-names", "aria-hidden": "true" });
  const scroller = el("div", { class: "picture-scroller" });
  const zoom = el("div", { class: "zoom" }, [["−", "Narrower", 1 / ZOOM], ["+", "Wider", ZOOM]].map(([sign, label, factor]) => el("button", { type: "button", "aria-label": label, title: label, onclick: () => zoomBy(factor) }, sign)));
  const node = el("div", { class: "picture", "data-testid": "picture" }, names, scroller, zoom);
  const still = { plan: null, changes: null, mission: null, elapsed: null, silent: [], zoom: 1, chosen: null, focused: null };
  let at = null;
  let drawnDue = null;
  let parts = {};

  function draw() {
    if (!still.plan || !scroller.clientWidth) return;
    drawnDue = due();
    const width = Math.max(NARROWEST_PX, (scroller.clientWidth - 1) * still.zoom);
    at = layout(still.plan, width, still.elapsed, still.changes.ghosts, due());
    parts = { links: svg("g", { class: "links" }, links(still.plan, at)), bars: svg("g", {}, inOrder().map((action) => bar(action, at, still.changes.of.get(action.id)))), chosen: svg("g", { class: "links chosen" }), actual: svg("g"), unheard: svg("g"), ghosts: svg("g", {}, still.changes.ghosts.map((one) => ghost(one, at))) };
    const drawing = svg(
      "svg",
      { width, height: at.height, class: "lanes", role: "group", "aria-label": "The plan's actions over time, a lane a robot; arrow keys go from one to the next" },
      definitions(),
      backdrop(at),
      parts.unheard,
      parts.links,
      parts.ghosts,
      parts.bars,
      parts.actual,
      parts.chosen,
    );
    replace(scroller, drawing);
    replace(names, at.robots.map((robot) => el("li", { title: robot })));
    names.style.paddingTop = `${TOP_PX}px`;
    for (const name of names.children) name.style.height = `${LANE_PX}px`;
    reachable(still.chosen ?? inOrder()[0]?.id);
    mark(still.chosen);
    fill();
  }

  const due = () => (typeof still.mission?.deadline_s === "number" && still.elapsed !== null ? still.mission.deadline_s - begun(still.mission) : null);
  const inOrder = () => [...still.plan.actions].sort((one, other) => one.earliest_start_s - other.earliest_start_s || one.id.localeCompare(other.id, undefined, { numeric: true }));
  const barOf = (action) => parts.bars?.querySelector(`[data-action="${CSS.escape(action ?? "")}"]`);

  function fill() {
    const silences = unheard(still.silent, at, still.elapsed);
    replace(parts.actual, still.mission ? actual(still.mission, at, still.elapsed, still.silent) : [], silences.map(({ words }) => words));
    replace(parts.unheard, silences.map(({ hatch }) => hatch));
    at.robots.forEach((robot, lane) => {
      const silence = still.silent.find((one) => one.robot === robot);
      show(names.children[lane], el("span", {}, robot), silence ? el("span", { class: `badge ${silence.tone}` }, silence.word) : null);
    });
  }

  function mark(action) {
    for (const bar of parts.bars.children) {
      bar.setAttribute("aria-pressed", String(bar.dataset.action === still.chosen));
      bar.classList.toggle("looked-at", bar.dataset.action === action);
    }
    parts.links.classList.toggle("faint", Boolean(action));
    parts.chosen.replaceChildren(...(action ? links(still.plan, at, action) : []));
  }

  function look(action) {
    mark(action);
    onChoose(at.actions.get(action) ?? null);
  }

  function choose(action) {
    still.chosen = still.chosen === action ? null : action;
    look(still.chosen);
  }

  // One stop on the way of the tab key; the arrow keys go on from there.
  function reachable(action) {
    still.focused = action;
    for (const bar of parts.bars.children) bar.setAttribute("tabindex", bar.dataset.action === action ? "0" : "-1");
  }

  function neighbour(action, move) {
    const here = at.actions.get(action);
    const lane = at.robots.indexOf(here.agents[0]);
    const [along, across] = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] }[move];
    const row = (robot) => inOrder().filter((other) => other.agents.includes(robot));
    if (along) return row(at.robots[lane])[row(at.robots[lane]).findIndex((other) => other.id === action) + along];
    const there = row(at.robots[lane + across] ?? "");
    const far = (other) => Math.abs(other.earliest_start_s - here.earliest_start_s);
    return there.sort((one, other) => far(one) - far(other))[0];
  }

  scroller.addEventListener("click", (event) => choose(event.target.closest("[data-action]")?.dataset.action ?? null));
  scroller.addEventListener("pointerover", (event) => {
    const over = event.target.closest("[data-action]")?.dataset.action;
    if (over) look(over);
  });
  scroller.addEventListener("pointerleave", () => parts.bars && look(still.chosen));
  scroller.addEventListener("focusin", (event) => {
    const action = event.target.closest("[data-action]")?.dataset.action;
    if (!action) return;
    reachable(action);
    look(action);
  });
  scroller.addEventListener("keydown", (event) => {
    const action = event.target.closest("[data-action]")?.dataset.action;
    if (!action) return;
    if (event.key === "Enter" || event.key === " ") choose(action);
    else if (event.key === "Escape") choose(null);
    else if (event.key.startsWith("Arrow")) barOf(neighbour(action, event.key)?.id)?.focus();
    else return;
    event.preventDefault();
  });
  new ResizeObserver(() => requestAnimationFrame(draw)).observe(scroller);

  function zoomBy(factor) {
    still.zoom = Math.min(16, Math.max(1, still.zoom * factor));
    draw();
  }

  return {
    node,
    // `changes`: what it differs in from the plan before it.
    show(plan, changes = NOTHING) {
      if (still.plan?.id !== plan.id) Object.assign(still, { chosen: null, zoom: 1 });
      Object.assign(still, { plan, changes });
      draw();
    },
    // How the mission stands at `time`, world's clock; null without one. `silent`: which robots are not heard, and
    // since when.
    happens(mission, time, silent = []) {
      const spent = mission && elapsed(mission, time, begun(mission));
      Object.assign(still, { mission, elapsed: spent, silent });
      if (!at || !still.plan || !parts.actual) return;
      if ((spent > at.end * 1.001 && mission.ended_at_s === null) || due() !== drawnDue) draw();
      else fill();
    },
  };
}
