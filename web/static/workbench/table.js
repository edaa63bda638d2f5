// A searchable table of all robots of all worlds, which of them come and go, and everything that is known of the selected one.

import { get, id, list } from "../page/api.js";
import { badge, closest, el, replace, show } from "../page/dom.js";
import { seconds, words } from "../page/format.js";
import { responseOrder } from "../page/store.js";
import { contact } from "../robots/contact.js";
import { table, tableRow } from "./charts.js";

const COLUMNS = ["robot", "world", "link", "does", "battery", "mission", "body", "can, and reaches"];
const MAX_CHANGES = 4;
const FACTSHEETS = /^(robot\.(announced|admitted|refused)|world\.changed)$/;

/** @param {Element} root @param {Store} store @returns {WorkbenchPart} */
export function mount(root, store) {
  /** @type {Record<string, {layout?: WorldLayout}>} */
  const worlds = {};
  /** @type {Record<string, Partial<Tuning>>} */
  const tunings = {};
  /** Each robot's link when last drawn. @type {Map<string, string>} */
  let links = new Map();
  /** What robots that no world has yet have told, by world. @type {Map<string, Factsheet[]>} */
  const announced = new Map();
  /** @type {Map<string, ReturnType<typeof responseOrder>>} */
  const orders = new Map();
  /** @type {string[]} */
  const changes = [];
  const search = el("input", { type: "search", placeholder: "Find by world, state, place…", "aria-label": "Find robots", "data-testid": "bench-search", oninput: () => draw(store.get()) });
  const count = el("span", { class: "quiet small", role: "status" });
  const changeNote = el("p", { class: "small", role: "status", "data-testid": "bench-changes" });
  const arrivals = el("ul", { class: "small", "data-testid": "bench-arrivals" });
  const rows = el("tbody", { onclick: (event) => select(closest(event, "[data-robot]")?.dataset.robot) });
  const properties = el("dl", { class: "slots small", "data-testid": "bench-properties" });
  replace(root, el("div", { class: "head" }, search, count), changeNote, arrivals, table("Robots found", COLUMNS, rows), properties);

  /** @param {string | undefined} name */
  function select(name) {
    const robot = store.get().robots.find((one) => one.name === name);
    if (robot) store.update({ robot: robot.name, world: robot.world });
  }

  /** Request once, whether it succeeds or not. @template T @param {Record<string, T | {}>} cache @param {string} key @param {string} path */
  async function load(cache, key, path) {
    if (key in cache) return;
    cache[key] = {};
    cache[key] = await get(path).catch(() => ({}));
    draw(store.get());
  }

  /** @param {State} state */
  function draw({ robots, robot: selected, worldTimes }) {
    noteChanges(robots, worldTimes);
    show(changeNote, changes.join("; "));
    show(arrivals, [...announced].flatMap(([world, sheets]) => sheets.map((one) => el("li", {}, badge("warn", "announced"), ` ${one.robot} in ${world} since ${seconds(one.at_s)}: ${one.reason}. It can ${one.sheet.repertoire.join(", ")}`))));
    const wanted = search.value.toLowerCase().split(/\s+/);
    const lines = robots.map((robot) => cellTexts(robot, fileEntry(robot), worldTimes[robot.world]));
    const found = lines.filter((cells) => wanted.every((word) => cells.join(" ").toLowerCase().includes(word)));
    show(count, `${found.length} of ${lines.length}`);
    show(rows, found.map(([name, ...rest]) => tableRow([el("button", { "data-robot": name, "aria-pressed": String(name === selected) }, name), ...rest])));
    const robot = robots.find((one) => one.name === selected);
    const tuning = { ...tunings[selected ?? ""], packets: undefined };
    const known = { ...(robot && fileEntry(robot)), radio: worlds[robot?.world ?? ""]?.layout?.link, ...robot, tuning };
    const texts = Object.entries(known).map(([name, value]) => [words(name), format(value)]);
    show(properties, texts.filter(([, text]) => text).map(([name, text]) => [el("dt", {}, name), el("dd", {}, text)]));
  }

  /** Robots that have come or gone, and links that have changed, since they were last drawn. @param {Robot[]} robots @param {Record<string, number>} worldTimes */
  function noteChanges(robots, worldTimes) {
    const now = new Map(robots.map((robot) => [robot.name, contact(robot, worldTimes[robot.world]).word]));
    for (const { name, world, repertoire } of links.size ? robots : []) {
      const word = now.get(name);
      if (word === links.get(name)) continue;
      const what = links.has(name) ? `is ${word}` : `has come and can ${(repertoire ?? []).join(", ")}`;
      changes.unshift(`${seconds(worldTimes[world])}: ${name} ${what}`);
    }
    for (const name of links.keys()) if (!now.has(name)) changes.unshift(`${name} is gone`);
    changes.length = Math.min(changes.length, MAX_CHANGES);
    links = now;
  }

  /** @param {string} world */
  async function loadArrivals(world) {
    announced.set(world, announced.get(world) ?? []);
    const order = orders.get(world) ?? responseOrder();
    orders.set(world, order);
    const isCurrent = order();
    /** @type {Factsheet[]} */
    const sheets = await list(`/v1/worlds/${id(world)}/factsheets`).catch(() => []);
    if (!isCurrent()) return;
    announced.set(world, sheets.filter((one) => one.state === "announced"));
    draw(store.get());
  }

  /** The robot's entry in its world's file. @param {Robot} robot */
  function fileEntry({ name, world }) {
    return worlds[world]?.layout?.robots.find((one) => one.name === name);
  }

  return {
    update(state) {
      for (const { world } of state.robots) load(worlds, world, `/v1/worlds/${id(world)}`);
      if (state.robot) load(tunings, state.robot, `/v1/robots/${id(state.robot)}/tuning`);
      for (const { id: world } of state.worlds) if (!announced.has(world)) loadArrivals(world);
      draw(state);
    },
    onEvent({ type = "", subject = "", data = {} }) {
      const world = data.world ?? subject;
      if (FACTSHEETS.test(type) && announced.has(world)) loadArrivals(world);
    },
    close() {},
  };
}

/** @param {Robot} robot @param {WorldLayout["robots"][number] | undefined} file @param {number} now */
function cellTexts(robot, file, now) {
  const link = contact(robot, now);
  return [
    robot.name,
    robot.world,
    [link.word, link.note].filter(Boolean).join(", "),
    robot.driven_by ? `driven by ${robot.driven_by}` : (robot.packet ?? "idle"),
    typeof robot.battery === "number" ? `${Math.round(robot.battery * 100)} %` : "–",
    robot.mission_id ?? "–",
    [robot.body, robot.body === "real" ? null : file?.body.kind].filter(Boolean).join(", ") || "–",
    [...(robot.repertoire ?? []), ...(robot.reach ?? [])].join(" "),
  ];
}

/** @param {unknown} value @returns {string} */
function format(value) {
  if (value === null || value === undefined || value === false) return "";
  if (Array.isArray(value)) return value.map(format).join(", ");
  if (typeof value === "number") return String(Math.round(value * 100) / 100);
  if (typeof value !== "object") return String(value);
  const pairs = Object.entries(value).map(([name, one]) => [words(name), format(one)]);
  return pairs.filter(([, text]) => text).map((pair) => pair.join(" ")).join("; ");
}
