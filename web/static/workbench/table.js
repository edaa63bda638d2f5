// All robots of all worlds, found by any word that is said of them, and everything that is known of one.

import { get, id } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { words } from "../page/format.js";
import { contact } from "../robots/contact.js";
import { grid, row } from "./strip.js";

const COLUMNS = ["robot", "world", "link", "does", "battery", "mission", "body", "can, and reaches"];
const NEWS = 4;

export function mountTable(root, store) {
  const files = {}; // by world, its robots as its file has them
  const tunings = {};
  const links = {}; // each robot's link as last seen
  const news = []; // robots that appeared or vanished since this was opened
  const search = el("input", { type: "search", placeholder: "Find by world, state, place…", "aria-label": "Find robots", "data-testid": "bench-search", oninput: () => draw(store.get()) });
  const count = el("span", { class: "quiet small", role: "status" });
  const changes = el("p", { class: "small", role: "status", "data-testid": "bench-changes" });
  const rows = el("tbody", { onclick: ({ target }) => target.dataset.robot && choose(target.dataset.robot) });
  const about = el("dl", { class: "slots small", "data-testid": "bench-properties" });
  replace(root, el("div", { class: "head" }, search, count), changes, grid("Robots found", COLUMNS, rows), about);

  function choose(name) {
    store.update({ robot: name, world: store.get().robots.find((robot) => robot.name === name).world });
  }

  // Asked for once, whatever comes of it.
  async function fetched(into, key, path) {
    if (key in into) return;
    into[key] = {};
    into[key] = await get(path).catch(() => ({}));
    draw(store.get());
  }

  function draw(state) {
    const lines = state.robots.map((robot) => line(robot, files[robot.world]?.layout?.robots.find((one) => one.name === robot.name), contact(robot, state.worldTimes[robot.world])));
    for (const { robot: { name }, cells: [, , link] } of lines) {
      const word = link.split(",")[0];
      if (word !== (links[name] ??= word)) news.unshift(`${name} is ${word}`);
      links[name] = word;
    }
    news.length = Math.min(news.length, NEWS);
    show(changes, news.join("; "));
    const wanted = search.value.toLowerCase().split(/\s+/);
    const found = lines.filter(({ cells }) => wanted.every((word) => cells.join(" ").toLowerCase().includes(word)));
    show(count, `${found.length} of ${lines.length}`);
    show(rows, found.map(({ cells: [name, ...rest] }) => row([el("button", { type: "button", "data-robot": name, "aria-pressed": String(name === state.robot) }, name), ...rest])));
    const mine = lines.find(({ cells }) => cells[0] === state.robot);
    const { packets, ...tuning } = tunings[state.robot] ?? {};
    const known = Object.entries({ ...mine?.file, radio: files[mine?.robot.world]?.layout?.link, ...mine?.robot, tuning });
    show(about, known.map(([name, value]) => [name, inWords(value)]).filter(([, text]) => text).map(([name, text]) => [el("dt", {}, words(name)), el("dd", {}, text)]));
  }

  return {
    update(state) {
      for (const { world } of state.robots) fetched(files, world, `/v1/worlds/${id(world)}`);
      if (state.robot) fetched(tunings, state.robot, `/v1/robots/${id(state.robot)}/tuning`);
      draw(state);
    },
    close() {},
  };
}

function line(robot, file, link) {
  const does = robot.driven_by ? `driven by ${robot.driven_by}` : robot.packet ?? "idle";
  const level = typeof robot.battery === "number" ? `${Math.round(robot.battery * 100)} %` : "–";
  const can = [...(robot.repertoire ?? []), ...(robot.reach ?? [])].join(" ");
  return { robot, file, cells: [robot.name, robot.world, [link.word, link.note].filter(Boolean).join(", "), does, level, robot.mission_id ?? "–", file?.body.kind ?? "–", can] };
}

function inWords(value) {
  if (Array.isArray(value)) return value.map(inWords).join(", ");
  if (typeof value === "number") return String(Math.round(value * 100) / 100);
  if (value === null || typeof value !== "object") return value === null || value === false ? "" : String(value ?? "");
  return Object.entries(value).map(([name, one]) => [words(name), inWords(one)]).filter(([, text]) => text).map((pair) => pair.join(" ")).join("; ");
}
