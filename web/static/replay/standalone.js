// A recording as a page of its own: its data is part of the page, nothing is requested.

import { byId, el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { createPicture } from "../plan/picture.js";
import { createDrawing } from "../world/drawing.js";
import { createControls } from "./controls.js";
import { createRecording } from "./recording.js";

/** @type {Replay} */
const replay = JSON.parse(byId("replay", HTMLElement).textContent ?? "");
const recording = createRecording(replay);
const drawing = createDrawing();
const picture = createPicture(() => {});
const mission = replay.missions.at(-1)?.mission;
const plan = replay.plans[mission?.plan_id ?? ""] ?? Object.values(replay.plans).at(-1);
const player = el("div", { class: "card" });

replace(
  document.body,
  el("header", { class: "bar" }, el("h1", {}, "Macta"), el("span", {}, `${replay.goal?.text || mission?.id || "mission"}: ${words(mission?.state)}`)),
  el("main", { class: "standalone" }, drawing.node, el("div", {}, player, picture.node)),
);
drawing.showLayout(recording.layout);
if (plan) picture.show(plan);
replace(player, createControls({ recording, drawing, picture }).nodes);
