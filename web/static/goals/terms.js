// The terms of a goal: what its sentence was resolved to, and how it is to be carried out.

import { el } from "../page/dom.js";

/** @type {[keyof Constraints, string][]} */
const WORDS = [
  ["robots", "only with"],
  ["without", "without"],
  ["avoid", "avoiding"],
  ["keep_empty", "keeping empty"],
  ["after", "after"],
];

/** The terms as list items; empty if there are none. @param {Terms} terms */
export function termItems({ readings = [], constraints, holds = [] }) {
  const items = readings.map(({ said, means }) => item(`“${said}”`, means.join(said === "then" ? ", then " : ", ")));
  for (const [name, words] of WORDS) {
    const names = constraints?.[name] ?? [];
    if (names.length) items.push(item(words, names.join(", ")));
  }
  for (const { places, words } of holds) items.push(item("hold", words ?? places.join(", ")));
  return items;
}

/** @param {string} what @param {string} means */
function item(what, means) {
  return el("li", {}, el("b", {}, what), `: ${means}`);
}
