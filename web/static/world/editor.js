// Editing a world on its map: samples are added and removed, places dragged; the changes so far, each to be undone.

import { get, id, post, send } from "../page/api.js";
import { closest, el, replace, show } from "../page/dom.js";
import { attempt } from "../page/problem.js";

const STEP_M = 0.05; // of dragged places

/** @param {Node} drawing where the map is drawn @param {() => string | null} world the name of the world that is shown */
export function createEditor(drawing, world) {
  /** @type {{edits: WorldEdit[], edition: number, places: Map<string, Place>}} */
  const draft = { edits: [], edition: 0, places: new Map() };
  const box = el("div", { "data-testid": "edit-problem" });
  const listed = el("ol", { class: "edits", "data-testid": "edits" });
  const history = el("ol", { class: "edits", "data-testid": "changes" });
  const name = el("input", { required: true, maxlength: 64, pattern: "[a-z][a-z0-9_]*", placeholder: "sample_9", "aria-label": "Name of the new sample" });
  const place = el("select", { "aria-label": "Place of the new sample" });
  const reason = el("input", { required: true, maxlength: 2000, placeholder: "Reason", "aria-label": "Reason for the changes", "data-testid": "edit-reason" });
  const make = el("button", { class: "primary", "data-testid": "edit-make" }, "Make the changes");
  const node = el(
    "section",
    { class: "editor", "aria-label": "Editing the world", hidden: true, "data-testid": "editor" },
    el("p", { class: "quiet small" }, "Drag a place to move it, pick a sample to remove it."),
    el("form", { class: "row", onsubmit: addSample }, name, "at", place, el("button", { "data-testid": "edit-add" }, "Add sample")),
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
  }

  /** @param {WorldEdition} made */
  function change({ edition, edits, actor, reason: why, undone_by: undone, delivery, detail }) {
    const words = edits.length ? edits.map(inWords).join(", ") : "another world file";
    const state = undone ? `undone by ${undone}` : delivery === "taken_up" ? "" : delivery === "pending" ? "on its way" : `refused: ${detail}`;
    /** @type {HTMLButtonElement} */
    const undo = el("button", { type: "button", "data-testid": `undo-${edition}`, onclick: () => apply([undo], () => post(`${path()}/changes/${edition}:undo`)) }, "Undo");
    return el("li", { value: edition, class: undone ? "undone" : null }, el("span", { class: "grow" }, words, el("span", { class: "quiet" }, ` · ${why} (${actor}) ${state}`)), !undone && edits.length ? undo : null);
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
      el("button", { type: "button", "aria-label": `Leave out: ${inWords(edit)}`, onclick: () => drop(edit) }, "×"),
    )));
    make.disabled = draft.edits.length === 0;
  }

  /** @param {WorldEdit} edit */
  function drop(edit) {
    draft.edits = draft.edits.filter((one) => one !== edit);
    if (edit.edit === "move_place") mark(edit.name ?? "")?.removeAttribute("transform");
    list();
    return check();
  }

  /** Says what is wrong with the changes, before they are made. */
  function check() {
    return attempt([], box, async () => draft.edits.length && post(`${path()}/changes:check`, { edits: draft.edits }));
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
    await attempt(buttons, box, request);
    await load();
    make.disabled = draft.edits.length === 0;
  }

  /** @param {string} placed */
  const mark = (placed) => /** @type {Element} */ (drawing).querySelector(`.place-mark[data-name="${placed}"]`);

  /** @param {PointerEvent} start */
  function drag(start) {
    const moved = closest(start, ".place-mark");
    const known = draft.places.get(moved?.dataset.name ?? "");
    const space = moved instanceof SVGGraphicsElement ? moved.ownerSVGElement : null;
    if (node.hidden || !moved || !known || !space) return;
    const at = (/** @type {PointerEvent} */ event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(space.getScreenCTM()?.inverse());
    const from = at(start);
    let way = [0, 0];
    const move = (/** @type {PointerEvent} */ event) => {
      const to = at(event);
      way = [to.x - from.x, to.y - from.y];
      moved.setAttribute("transform", `translate(${way[0]} ${way[1]})`);
    };
    const release = () => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", release);
      const target = known.at.map((value, axis) => Math.round((value + (axis ? -way[1] : way[0])) / STEP_M) * STEP_M);
      if (Math.hypot(...way) < STEP_M) moved.removeAttribute("transform");
      else add({ edit: "move_place", name: known.name, at: target.map((value) => Number(value.toFixed(2))) });
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", release);
    start.preventDefault();
  }
  drawing.addEventListener("pointerdown", (event) => drag(/** @type {PointerEvent} */ (event)));

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
      return true;
    },
  };
}

/** @param {WorldEdit} edit */
function inWords({ edit, name, sample, robot, place, at }) {
  const [verb, kind] = edit.split("_");
  const where = at ? ` to (${at.join(", ")})` : sample ? ` at ${sample.at}` : "";
  return `${verb} ${kind} ${name ?? (sample ?? robot ?? place)?.name}${where}`;
}
