// Editing a world on its map: samples are added and removed, places dragged, zones drawn; the changes so far, each to be undone.

import { get, id, post, send } from "../page/api.js";
import { closest, el, quiet, replace, show, svg } from "../page/dom.js";
import { attempt } from "../page/problem.js";
import { responseOrder } from "../page/store.js";
import { ruleInWords } from "./drawing.js";
import { createRobotEditor } from "./editor_robots.js";

const STEP_M = 0.05; // of dragged places
const LEAST_ZONE_M = 0.2; // what is drawn smaller is a click
const RULES = { keep_out: "keep out", one_robot: "one robot at a time", slow: "slow", named: "only a name" };

/** @param {HTMLElement} drawing where the map is drawn @param {() => string | null} world the name of the world that is shown */
export function createEditor(drawing, world) {
  /** @type {{edits: WorldEdit[], edition: number, places: Map<string, Place>}} */
  const draft = { edits: [], edition: 0, places: new Map() };
  const checkOrder = responseOrder();
  const box = el("div", { "data-testid": "edit-problem" });
  const listed = el("ol", { class: "edits", "data-testid": "edits" });
  const history = el("ol", { class: "edits", "data-testid": "changes" });
  const name = el("input", { required: true, maxlength: 64, pattern: "[a-z][a-z0-9_]*", placeholder: "sample_9", "aria-label": "Name of the new sample" });
  const place = el("select", { "aria-label": "Place of the new sample" });
  const zoneName = el("input", { maxlength: 64, pattern: "[a-z][a-z0-9_]*", placeholder: "zone_1", "aria-label": "Name of the next zone" });
  const rule = el("select", { "aria-label": "Rule of the next zone", onchange: () => { speed.hidden = rule.value !== "slow"; } }, Object.entries(RULES).map(([value, words]) => el("option", { value }, words)));
  const speed = el("input", { type: "number", min: 0.05, max: 2, step: 0.05, value: 0.2, hidden: true, "aria-label": "Speed in the next zone, m/s" });
  const reason = el("input", { required: true, maxlength: 2000, placeholder: "Reason", "aria-label": "Reason for the changes", "data-testid": "edit-reason" });
  const make = el("button", { type: "submit", class: "primary", "data-testid": "edit-make" }, "Make the changes");
  const robots = createRobotEditor(() => path(), box, { add, reload: () => load() });
  const node = el(
    "section",
    { class: "editor", "aria-label": "Editing the world", hidden: true, "data-testid": "editor" },
    el("p", { class: "quiet small" }, "Drag a place to move it, pick a sample to remove it, a robot to change it. Draw a zone on the floor, with the name and rule below; pick one to remove it."),
    el("form", { class: "row", onsubmit: addSample }, name, "at", place, el("button", { type: "submit", "data-testid": "edit-add" }, "Add sample")),
    el("div", { class: "row" }, "Zone", zoneName, rule, speed),
    robots.node,
    listed,
    el("form", { class: "row", onsubmit: submit }, reason, make),
    box,
    el("h3", { class: "small" }, "Changes so far"),
    history,
  );

  const path = () => `/v1/worlds/${id(world() ?? "")}`;

  async function load() {
    const [known, { items }] = await Promise.all([get(path()), get(`${path()}/changes`)]);
    draft.edition = known.edition;
    draft.places = new Map(known.layout.locations.map((/** @type {Place} */ one) => [one.name, one]));
    const storing = known.layout.locations.filter((/** @type {Place & {capacity: number}} */ one) => one.capacity > 0);
    show(place, storing.map((/** @type {Place} */ one) => el("option", {}, one.name)));
    replace(history, items.map(change));
    await robots.load(known.layout.robots);
  }

  /** @param {WorldEdition} made */
  function change({ edition, edits, actor, reason: why, undone_by: undone, delivery, detail }) {
    const words = edits.length ? edits.map(inWords).join(", ") : "another world file";
    const state = undone ? `undone by ${undone}` : delivery === "taken_up" ? "" : delivery === "pending" ? "on its way" : `refused: ${detail}`;
    /** @type {HTMLButtonElement} */
    const undo = el("button", { "data-testid": `undo-${edition}`, onclick: () => apply([undo], () => post(`${path()}/changes/${edition}:undo`)) }, "Undo");
    return el("li", { value: edition, class: undone ? "undone" : null }, el("span", { class: "grow" }, words, quiet(` · ${why} (${actor}) ${state}`)), !undone && edits.length ? undo : null);
  }

  /** @param {WorldEdit} edit */
  function add(edit) {
    const isOther = (/** @type {WorldEdit} */ one) => one.edit !== edit.edit || one.name !== edit.name || edit.name === undefined;
    draft.edits = [...draft.edits.filter(isOther), edit];
    list();
    return check();
  }

  function list() {
    replace(listed, draft.edits.map((edit) => el(
      "li",
      {},
      el("span", { class: "grow" }, inWords(edit)),
      el("button", { "aria-label": `Leave out: ${inWords(edit)}`, onclick: () => drop(edit) }, "×"),
    )));
    make.disabled = draft.edits.length === 0;
  }

  /** @param {WorldEdit} edit */
  function drop(edit) {
    draft.edits = draft.edits.filter((one) => one !== edit);
    if (edit.edit === "move_place") mark(edit.name ?? "")?.removeAttribute("transform");
    if (edit.zone) zoneMarked(edit.zone.name)?.remove();
    list();
    return check();
  }

  /** Says what is wrong with the changes, before they are made. */
  function check() {
    const isCurrent = checkOrder();
    return attempt([], box, async () => {
      try {
        if (draft.edits.length) await post(`${path()}/changes:check`, { edits: draft.edits });
        isCurrent(); // what was asked before says no more
      } catch (error) {
        if (isCurrent()) throw error;
      }
    });
  }

  /** @param {Event} event */
  function addSample(event) {
    event.preventDefault();
    add({ edit: "add_sample", sample: { name: name.value, at: place.value } });
    name.value = "";
  }

  /** @param {Event} event */
  async function submit(event) {
    event.preventDefault();
    await apply([make], async () => {
      await send("POST", `${path()}/changes`, { edits: draft.edits, reason: reason.value }, { "if-match": `"${draft.edition}"` });
      draft.edits = [];
      reason.value = "";
      list();
    });
  }

  /** @param {HTMLButtonElement[]} buttons @param {() => Promise<unknown>} request */
  async function apply(buttons, request) {
    await attempt(buttons, box, () => request().finally(load));
    make.disabled = draft.edits.length === 0;
  }

  /** @param {string} placed */
  const mark = (placed) => drawing.querySelector(`.place-mark[data-name="${placed}"]`);

  /** @param {string} drawn */
  const zoneMarked = (drawn) => drawing.querySelector(`.zone[data-name="${drawn}"]`);

  /** @param {PointerEvent} start */
  function begin(start) {
    const space = closest(start, ".map-drawing");
    if (node.hidden || !(space instanceof SVGSVGElement)) return;
    const moved = closest(start, ".place-mark");
    const known = draft.places.get(moved?.dataset.name ?? "");
    if (moved && known) drag(start, space, moved, known);
    else if (!moved && !closest(start, ".sample-mark, .robot-mark, .peripheral-mark")) outline(start, space);
    else return;
    start.preventDefault();
  }

  /** @param {PointerEvent} start @param {SVGSVGElement} space @param {Element} moved @param {Place} known */
  function drag(start, space, moved, known) {
    let way = [0, 0];
    track(start, space, (from, to) => {
      way = [to.x - from.x, to.y - from.y];
      moved.setAttribute("transform", `translate(${way[0]} ${way[1]})`);
    }, () => {
      if (Math.hypot(...way) < STEP_M) moved.removeAttribute("transform");
      else add({ edit: "move_place", name: known.name, at: known.at.map((value, axis) => inSteps(value + (axis ? -way[1] : way[0]))) });
    });
  }

  /** Draws a zone, or picks the one below if the pointer does not move. @param {PointerEvent} start @param {SVGSVGElement} space */
  function outline(start, space) {
    const picked = closest(start, ".zone")?.dataset.name;
    const shape = svg("rect", { class: "zone-area" });
    const zone = svg("g", { class: `zone ${rule.value}` }, shape);
    /** @type {{x: Point, y: Point}} */
    let sides = { x: [0, 0], y: [0, 0] };
    track(start, space, (from, to) => {
      sides = { x: interval(from.x, to.x), y: interval(-from.y, -to.y) };
      const drawn = { x: sides.x[0], y: -sides.y[1], width: sides.x[1] - sides.x[0], height: sides.y[1] - sides.y[0] };
      for (const [side, value] of Object.entries(drawn)) shape.setAttribute(side, String(value));
      space.append(zone);
    }, () => {
      if (Math.min(sides.x[1] - sides.x[0], sides.y[1] - sides.y[0]) < LEAST_ZONE_M) {
        zone.remove();
        if (picked && !draft.edits.some((edit) => edit.zone?.name === picked)) add({ edit: "remove_zone", name: picked });
        return;
      }
      const drawn = nextName();
      zone.setAttribute("data-name", drawn);
      zoneName.value = "";
      add({ edit: "add_zone", zone: { name: drawn, ...sides, rule: rule.value, ...(rule.value === "slow" ? { max_speed_m_s: Number(speed.value) } : {}) } });
    });
  }

  /** The name that is given, or the first free number. */
  function nextName() {
    if (zoneName.value && zoneName.checkValidity()) return zoneName.value;
    let number = 1;
    while (zoneMarked(`zone_${number}`)) number += 1;
    return `zone_${number}`;
  }
  drawing.addEventListener("pointerdown", (event) => begin(/** @type {PointerEvent} */ (event)));

  list();
  return {
    node,
    load,
    /** @param {boolean} isOpen */
    open(isOpen) {
      node.hidden = !isOpen;
      return isOpen ? attempt([], box, load) : undefined;
    },
    /** What is picked on the map is edited; true if so. @param {Picked} picked */
    pick({ kind, name: picked }) {
      if (node.hidden) return false;
      if (kind === "sample") add({ edit: "remove_sample", name: picked });
      else if (kind === "place") place.value = picked;
      else robots.choose(picked);
      return true;
    },
  };
}

/**
 * Follows the pointer until it is released. @param {PointerEvent} start @param {SVGSVGElement} space in whose units
 * @param {(from: DOMPoint, to: DOMPoint) => void} move @param {() => unknown} release
 */
function track(start, space, move, release) {
  const at = (/** @type {PointerEvent} */ event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(space.getScreenCTM()?.inverse());
  const from = at(start);
  const moved = (/** @type {PointerEvent} */ event) => move(from, at(event));
  const released = () => {
    removeEventListener("pointermove", moved);
    removeEventListener("pointerup", released);
    release();
  };
  addEventListener("pointermove", moved);
  addEventListener("pointerup", released);
}

/** @param {number} value metres */
const inSteps = (value) => Number((Math.round(value / STEP_M) * STEP_M).toFixed(2));
/** @param {number} one @param {number} other @returns {Point} */
const interval = (one, other) => [inSteps(Math.min(one, other)), inSteps(Math.max(one, other))];

/** @param {WorldEdit} edit */
function inWords({ edit, name, sample, robot, place, zone, at, ...values }) {
  const [verb, ...words] = edit.split("_");
  const zoneRule = zone && ruleInWords(zone);
  const what = verb === "change" ? `: ${Object.keys(values).join(", ")}` : at ? ` to (${at.join(", ")})` : sample ? ` at ${sample.at}` : zoneRule ? `: ${zoneRule}` : "";
  return `${verb} ${words.join(" ")} ${name ?? (sample ?? robot ?? place ?? zone)?.name}${what}`;
}
