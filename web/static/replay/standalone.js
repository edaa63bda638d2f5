// A recording as a page of its own: its data lies in the page, nothing is asked of anybody.

import { el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { createPicture } from "../plan/picture.js";
import { createDrawing } from "../world/drawing.js";
import { createControls } from "./controls.js";
import { createRecording } from "./recording.js";

const replay = JSON.parse(document.getElementById("replay").textContent);
const recording = createRecording(replay);
const drawing = createDrawing();
const picture = createPicture({ onChoose: () => {} });
const last = replay.missions.at(-1)?.mission;
const plan = replay.plans[last?.plan_id] ?? Object.values(replay.plans).at(-1);
const player = el("div", { class: "card" });

replace(
  document.body,
  el("header", { class: "bar" }, el("h1", {}, "Macta"), el("span", {}, `${replay.goal?.text || last?.id || "mission"}: ${words(last?.state)}`)),
  el("main", { class: "standalone" }, drawing.node, el("div", {}, player, picture.node)),
);
drawing.ground(recording.layout);
if (plan) picture.show(plan);
replace(player, createControls({ recording, drawing, picture }).nodes);
