// The page's three panes: the outer two can be resized, by pointer or arrow keys, and hidden.

import { byId } from "./dom.js";
import { loadPreference, savePreference } from "./preferences.js";

const STEP_PX = 24;
const MIN_WIDTH_PX = { left: 200, right: 260 };
const MIDDLE_PX = 360;
/** @typedef {"left" | "right"} Side @typedef {{left?: number, right?: number, leftAway?: boolean, rightAway?: boolean}} Widths */

export function mountPanes() {
  const panes = byId("panes", HTMLElement);
  /** @type {Widths} */
  const widths = loadPreference("panes", {});
  const sides = [mountSide("left", panes, widths), mountSide("right", panes, widths)];
  const fitAll = () => sides.forEach((fit) => fit());
  addEventListener("resize", fitAll);
  fitAll();
}

/** @param {Side} side @param {HTMLElement} panes @param {Widths} widths */
function mountSide(side, panes, widths) {
  const pane = byId(side, HTMLElement);
  const divider = byId(`${side}-divider`, HTMLElement);
  const button = byId(`${side}-toggle`, HTMLButtonElement);
  const otherPane = byId(side === "left" ? "right" : "left", HTMLElement);
  const outwards = side === "left" ? 1 : -1;
  const hiddenKey = /** @type {const} */ (`${side}Away`);
  const maxWidth = () => Math.max(MIN_WIDTH_PX[side], panes.clientWidth - MIDDLE_PX - otherPane.offsetWidth);
  /** @param {number} width */
  const setWidth = (width) => {
    widths[side] = Math.round(Math.min(maxWidth(), Math.max(MIN_WIDTH_PX[side], width)));
    savePreference("panes", widths);
    fit();
  };
  const fit = () => {
    const isHidden = Boolean(widths[hiddenKey]);
    const chosen = widths[side];
    pane.hidden = isHidden;
    divider.hidden = isHidden;
    button.setAttribute("aria-pressed", String(!isHidden));
    const width = isHidden ? "0px" : chosen ? `${Math.min(chosen, maxWidth())}px` : "";
    if (width) panes.style.setProperty(`--${side}`, width);
    else panes.style.removeProperty(`--${side}`);
    panes.style.setProperty(`--${side}-divider`, isHidden ? "0px" : "7px");
    divider.setAttribute("aria-valuemin", String(MIN_WIDTH_PX[side]));
    divider.setAttribute("aria-valuemax", String(maxWidth()));
    divider.setAttribute("aria-valuenow", String(pane.offsetWidth || MIN_WIDTH_PX[side]));
  };
  divider.addEventListener("pointerdown", (event) => {
    divider.setPointerCapture(event.pointerId);
    const start = event.clientX;
    const width = pane.offsetWidth;
    /** @param {PointerEvent} moved */
    const drag = (moved) => setWidth(width + outwards * (moved.clientX - start));
    divider.addEventListener("pointermove", drag);
    divider.addEventListener("lostpointercapture", () => divider.removeEventListener("pointermove", drag), { once: true });
  });
  divider.addEventListener("keydown", (event) => {
    if (event.key === "ArrowRight") setWidth(pane.offsetWidth + outwards * STEP_PX);
    else if (event.key === "ArrowLeft") setWidth(pane.offsetWidth - outwards * STEP_PX);
    else if (event.key === "Home") setWidth(0);
    else if (event.key === "End") setWidth(maxWidth());
    else return;
    event.preventDefault();
  });
  button.addEventListener("click", () => {
    widths[hiddenKey] = !widths[hiddenKey];
    savePreference("panes", widths);
    dispatchEvent(new Event("resize"));
  });
  return fit;
}
