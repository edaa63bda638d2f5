// Draws a world from above: its ground once, samples and robots as often as they change.

import { el, replace, svg } from "../page/dom.js";

const EDGE_M = 0.3;
const LETTERS_PX = 11;
const ROBOT_M = 0.2;
const TRAIL = 150; // points kept of each robot's way
const TRAIL_STEP_M = 0.1;

export function createDrawing() {
  const node = el("div", { class: "map-holder" });
  const trails = new Map();
  const marks = new Map();
  let size = [1, 1];
  let layers = null;
  let places = new Map();

  function ground(layout) {
    const floors = layout.compartments;
    const low = [0, 1].map((axis) => Math.min(...floors.map((floor) => floor[axis ? "y" : "x"][0])) - EDGE_M);
    const high = [0, 1].map((axis) => Math.max(...floors.map((floor) => floor[axis ? "y" : "x"][1])) + EDGE_M);
    size = [high[0] - low[0], high[1] - low[1]];
    places = new Map((layout.locations ?? []).map((location) => [location.name, location.at]));
    trails.clear();
    marks.clear();
    layers = { trails: svg("g"), samples: svg("g"), robots: svg("g") };
    // North is up: y is turned round once, here, and back for letters.
    replace(node, svg(
      "svg",
      { viewBox: `${low[0]} ${-high[1]} ${size[0]} ${size[1]}`, class: "map-drawing", role: "group", "aria-label": "The world from above" },
      floors.map((floor) => rect(floor, "floor")),
      floors.flatMap((floor) => (floor.aisles ?? []).map((aisle) => rect(aisle, "aisle"))),
      (layout.locations ?? []).map(place),
      (layout.walls ?? []).map(wall),
      (layout.obstacles ?? []).map((rock) => svg("circle", { cx: rock.at[0], cy: -rock.at[1], r: rock.radius_m, class: "rock" })),
      layers.trails,
      layers.samples,
      layers.robots,
    ));
    fitLetters();
  }

  // Letters are as high as the page's, however small the map is; a small map has no room for all.
  function fitLetters() {
    const pixels = Math.min(node.clientWidth / size[0], node.clientHeight / size[1]);
    if (pixels > 0) node.style.setProperty("--letters", `${Math.min(0.3, LETTERS_PX / pixels)}px`);
  }

  // `lying`: by sample, the place it lies in; those in grippers are drawn with their robots.
  function samples(lying) {
    layers?.samples.replaceChildren(...[...lying].filter(([, where]) => places.has(where)).map(([name, where]) => sampleMark(name, places.get(where))));
  }

  // `now`: by name, {x_m, y_m, heading_rad, holding}; `chosen`: the one looked at. Marks stay, and keep the focus.
  function robots(now, chosen = null) {
    if (!layers) return;
    for (const [name, mark] of marks) {
      if (now[name]) continue;
      mark.node.remove();
      marks.delete(name);
    }
    for (const [name, told] of Object.entries(now)) {
      const mark = marks.get(name) ?? marks.set(name, robotMark(name)).get(name);
      const place = `translate(${told.x_m} ${-told.y_m})`;
      const turned = `${place} rotate(${(-told.heading_rad * 180) / Math.PI})`;
      mark.node.setAttribute("class", name === chosen ? "robot-mark chosen" : "robot-mark");
      if (told.holding) mark.body.append(mark.held);
      else mark.held.remove();
      if (mark.turned === turned) continue;
      mark.turned = turned;
      mark.body.setAttribute("transform", turned);
      mark.label.setAttribute("transform", place);
      leaveTrail(name, told);
    }
  }

  function robotMark(name) {
    const held = svg("rect", { x: 0.24, y: -0.1, width: 0.2, height: 0.2, class: "held" });
    const body = svg("g", {}, svg("circle", { r: ROBOT_M }), svg("path", { d: `M${ROBOT_M * 0.9},0 L-0.06,0.1 L-0.06,-0.1 z`, class: "nose" }));
    const label = letters(name, 0, -0.28);
    const node = svg("g", { "data-robot": name, role: "button", tabindex: 0, "aria-label": `robot ${name}` }, body, label);
    layers.robots.append(node);
    return { node, body, label, held };
  }

  function leaveTrail(name, { x_m: x, y_m: y }) {
    const trail = trails.get(name) ?? { way: [], line: svg("polyline", { class: "trail" }) };
    if (!trails.has(name)) layers.trails.append(trail.line);
    trails.set(name, trail);
    const last = trail.way.at(-1);
    if (last && Math.hypot(last[0] - x, last[1] - y) <= TRAIL_STEP_M) return;
    trail.way = [...trail.way, [x, y]].slice(-TRAIL);
    trail.line.setAttribute("points", trail.way.map(([east, north]) => `${east},${-north}`).join(" "));
  }

  function forgetTrails() {
    trails.clear();
    layers?.trails.replaceChildren();
  }

  new ResizeObserver(fitLetters).observe(node);
  return { node, ground, samples, robots, forgetTrails };
}

// Where samples lie, by the facts of the world model.
export function lyingIn(facts) {
  return new Map(facts.filter((fact) => fact.predicate === "in").map(({ args: [sample, where] }) => [sample, where]));
}

function sampleMark(name, [x, y]) {
  return button("sample-mark", name, `sample ${name}`, svg("rect", { x: x - 0.12, y: -y - 0.12, width: 0.24, height: 0.24, rx: 0.04 }), letters(name, x, -y - 0.16));
}

function place(location) {
  const [x, y] = location.at;
  const mark = svg("rect", { x: x - 0.24, y: -y - 0.24, width: 0.48, height: 0.48, rx: 0.05 });
  const name = location.kind === "home" ? null : letters(location.name, x, -y + 0.3, "0.8em");
  return button(`place-mark ${location.kind}`, location.name, `place ${location.name}`, mark, name);
}

function button(kind, name, label, ...marks) {
  return svg("g", { class: kind, "data-name": name, role: "button", tabindex: 0, "aria-label": label }, svg("title", {}, label), marks);
}

function rect({ x, y }, kind) {
  return svg("rect", { x: x[0], y: -y[1], width: x[1] - x[0], height: y[1] - y[0], class: kind });
}

function letters(text, x, y, dy = null) {
  return svg("text", { x, y, dy, class: "map-name" }, text);
}

// The wall, and over it its openings, each in its kind's colour.
function wall({ start, end, openings }) {
  const length = Math.hypot(end[0] - start[0], end[1] - start[1]) || 1;
  const at = (metres) => [start[0] + ((end[0] - start[0]) * metres) / length, start[1] + ((end[1] - start[1]) * metres) / length];
  const line = (from, to, kind) => svg("line", { x1: from[0], y1: -from[1], x2: to[0], y2: -to[1], class: kind });
  return [line(start, end, "wall"), (openings ?? []).map((opening) => line(at(opening.at_m - opening.width_m / 2), at(opening.at_m + opening.width_m / 2), `opening ${opening.kind}`))];
}
