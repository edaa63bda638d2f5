// The right column: the robots in a line each, and the world in three dimensions.

import { el, show } from "./dom.js";
import { tone, words } from "./format.js";

const VIEWER = "/viewer/";
const AGAIN_MS = 1500;
// Narrower than this, viser's page takes itself for a telephone's and covers the world with its panel.
const NARROWEST_PX = 600;

export function mountWorld(store) {
  store.subscribe((state) => {
    const mine = state.robots.filter((robot) => !robot.world || robot.world === state.world);
    show(document.getElementById("robots"), mine.map(robotLine));
  });
  const stage = document.getElementById("stage");
  new ResizeObserver(([entry]) => fit(stage, entry.contentRect)).observe(stage.parentElement);
  openStage(stage);
}

function fit(frame, { width }) {
  const scale = Math.min(1, width / NARROWEST_PX) || 1;
  const whole = `${100 / scale}%`;
  Object.assign(frame.style, { width: whole, height: whole, transform: scale < 1 ? `scale(${scale})` : "" });
}

function robotLine(robot) {
  const doing = [robot.packet && packetName(robot.packet), robot.holding && `holds ${robot.holding}`].filter(Boolean);
  return el(
    "div",
    { class: "robot", "data-testid": "robot" },
    el("span", { class: `dot ${tone(robot.connection)}`, title: words(robot.connection) }),
    el("b", {}, robot.name ?? robot.id),
    el("span", { class: "quiet" }, doing.join(", ") || (robot.connection === "online" ? "idle" : words(robot.connection))),
    typeof robot.battery === "number" ? el("span", { class: "quiet battery" }, `${Math.round(robot.battery * 100)} %`) : null,
  );
}

function packetName(packet) {
  return typeof packet === "string" ? packet : packet.tag ?? packet.id ?? "";
}

// The view is a process of its own and may come later than the page, or be started anew.
async function openStage(frame) {
  const note = document.getElementById("stage-note");
  frame.addEventListener("load", () => stayConnected(frame));
  while (!(await answers())) {
    note.textContent = "The view of the world is not there yet.";
    await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
  }
  frame.src = matchMedia("(prefers-color-scheme: dark)").matches ? `${VIEWER}?darkMode` : VIEWER;
  frame.hidden = false;
  note.hidden = true;
}

async function answers() {
  try {
    return (await fetch(VIEWER, { credentials: "same-origin" })).ok;
  } catch {
    return false;
  }
}

// viser's page reconnects only while it has the focus; inside ours it shall whenever ours is seen.
function stayConnected(frame) {
  const inner = frame.contentDocument;
  if (!inner) return;
  inner.hasFocus = () => !document.hidden;
  frame.contentWindow.dispatchEvent(new Event("focus"));
  document.addEventListener("visibilitychange", () => frame.contentWindow?.dispatchEvent(new Event("focus")));
}
