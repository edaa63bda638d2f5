// What the colours of the view in three dimensions mean.

import { el } from "../page/dom.js";

const COLOURS = [
  ["robot, each its own colour", "#1f6f8b"],
  ["selected", "#ff7a18"],
  ["sample", "#e4ba28"],
  ["bay, free", "#6886b0"],
  ["place with a sample", "#2c4a7c"],
  ["door", "#dea042"],
  ["interchange", "#469b91"],
  ["home", "#a0a09e"],
  ["charger", "#d6b83c"],
  ["beacon", "#be3c3c"],
  ["whisker that meets something", "#ce5c3c"],
];

export function createLegend() {
  const keys = COLOURS.map(([text, colour]) => {
    const swatch = el("span", { class: "swatch" });
    swatch.style.background = colour;
    return el("li", {}, swatch, text);
  });
  const lines = el("li", {}, "Arrows: planned ways, in the robots' colours. Lines behind robots: where they were.");
  return el("ul", { class: "legend" }, keys, lines);
}
