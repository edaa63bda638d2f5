// The page's three panes: the outer two can be resized, by pointer or arrow keys, and put away.

import { recall, remember } from "./remembered.js";

const STEP_PX = 24;
const NARROWEST_PX = { left: 200, right: 260 };
const MIDDLE_PX = 360;

export function mountPanes() {
  const panes = document.getElementById("panes");
  const widths = recall("panes", {});
  const sides = ["left", "right"].map((side) => mountSide(side, panes, widths));
  const fitAll = () => sides.forEach((fit) => fit());
  addEventListener("resize", fitAll);
  fitAll();
}

function mountSide(side, panes, widths) {
  const pane = document.getElementById(side);
  const divider = document.getElementById(`${side}-divider`);
  const button = document.getElementById(`${side}-toggle`);
  const most = () => {
    const other = document.getElementById(side === "left" ? "right" : "left");
    return Math.max(NARROWEST_PX[side], panes.clientWidth - MIDDLE_PX - other.offsetWidth);
  };
  const set = (width) => {
    widths[side] = Math.round(Math.min(most(), Math.max(NARROWEST_PX[side], width)));
    remember("panes", widths);
    fit();
  };
  const fit = () => {
    const away = Boolean(widths[`${side}Away`]);
    pane.hidden = divider.hidden = away;
    button.setAttribute("aria-pressed", String(!away));
    const width = away ? "0px" : widths[side] ? `${Math.min(widths[side], most())}px` : "";
    if (width) panes.style.setProperty(`--${side}`, width);
    else panes.style.removeProperty(`--${side}`);
    panes.style.setProperty(`--${side}-divider`, away ? "0px" : "7px");
    divider.setAttribute("aria-valuemin", NARROWEST_PX[side]);
    divider.setAttribute("aria-valuemax", most());
    divider.setAttribute("aria-valuenow", pane.offsetWidth || NARROWEST_PX[side]);
  };
  const outwards = side === "left" ? 1 : -1;
  divider.addEventListener("pointerdown", (event) => {
    divider.setPointerCapture(event.pointerId);
    const [from, width] = [event.clientX, pane.offsetWidth];
    const drag = (moved) => set(width + outwards * (moved.clientX - from));
    divider.addEventListener("pointermove", drag);
    divider.addEventListener("lostpointercapture", () => divider.removeEventListener("pointermove", drag), { once: true });
  });
  divider.addEventListener("keydown", (event) => {
    const steps = { ArrowRight: outwards, ArrowLeft: -outwards }[event.key];
    if (steps) set(pane.offsetWidth + steps * STEP_PX);
    else if (event.key === "Home") set(0);
    else if (event.key === "End") set(most());
    else return;
    event.preventDefault();
  });
  button.addEventListener("click", () => {
    widths[`${side}Away`] = !widths[`${side}Away`];
    remember("panes", widths);
    dispatchEvent(new Event("resize"));
  });
  return fit;
}
