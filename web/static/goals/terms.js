// The terms of a goal: what its sentence was resolved to, and how it is to be carried out.

import { el } from "../page/dom.js";
import { fact, facts } from "../page/format.js";

/** @type {["robots" | "without" | "avoid" | "keep_empty", string][]} */
const PREFERABLE = [
  ["robots", "only with"],
  ["without", "without"],
  ["avoid", "avoiding"],
  ["keep_empty", "keeping empty"],
];
/** @type {["robots" | "without" | "avoid" | "keep_empty" | "after", string][]} */
const WORDS = [...PREFERABLE, ["after", "after"]];

/** The terms as list items; empty if there are none. @param {Terms & { preferences?: CheckedSentence["preferences"] }} terms */
export function termItems({ readings = [], constraints, holds = [], preferences = [] }) {
  const items = readings.map(({ said, means }) => item(`“${said}”`, means.join(said === "then" ? ", then " : ", ")));
  for (const [name, words] of WORDS) {
    const names = constraints?.[name] ?? [];
    if (names.length) items.push(item(words, names.join(", ")));
  }
  if (constraints?.keep?.length) items.push(item("keeping", facts(constraints.keep)));
  for (const [index, preference] of (constraints?.preferences ?? []).entries()) {
    const conflict = preferences[index]?.conflict;
    items.push(item(`preferably ${preferred(preference)}`, `cost ${preference.cost_s} s${conflict ? `; it cannot be kept: ${conflict}` : ""}`));
  }
  for (const { places, facts: kept = [], words } of holds) items.push(item("hold", words ?? [...places, ...kept.map(fact)].join(", ")));
  return items;
}

/** What a preference says, in words. @param {Preference} preference */
function preferred(preference) {
  for (const [name, words] of PREFERABLE) {
    if (preference[name].length) return `${words} ${preference[name].join(", ")}`;
  }
  return `only with robots of ${Object.entries(preference.at_least).map(([name, least]) => `${name} >= ${least}`).join(", ")}`;
}

/** @param {string} what @param {string} means */
function item(what, means) {
  return el("li", {}, el("b", {}, what), `: ${means}`);
}
