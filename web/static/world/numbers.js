// The world's numbers below its map: batteries, loads, samples in places, readings; each with who told it and when.

import { get, id } from "../page/api.js";
import { el, quiet, show } from "../page/dom.js";
import { seconds } from "../page/format.js";
import { responseOrder } from "../page/store.js";

/** The numbers are fetched while they are open. @param {Store} store */
export function createNumbers(store) {
  const lines = el("dl", { "data-testid": "numbers" });
  const node = el("details", { class: "numbers", ontoggle: load }, el("summary", {}, "Numbers"), lines);
  const order = responseOrder();
  let shown = ""; // the world and version that are shown or asked for

  async function load() {
    const world = store.get().worlds.find((one) => one.id === store.get().world);
    const newest = world ? `${world.id} ${world.numbers_version}` : "";
    if (!node.open || !world || newest === shown) return;
    shown = newest;
    const isCurrent = order();
    try {
      /** @type {{items: NumericFact[]}} */
      const { items } = await get(`/v1/worlds/${id(world.id)}/numbers`);
      if (isCurrent() && store.get().world === world.id) show(lines, items.map(line));
    } catch {
      shown = ""; // the next change of the page's state tries again
    }
  }

  store.subscribe(load);
  return node;
}

/** @param {NumericFact} number */
function line({ quantity, args, text, source, at_s: at }) {
  return [el("dt", {}, `${quantity}(${args.join(", ")})`), el("dd", {}, text, quiet(` · ${source} at ${seconds(at)}`))];
}
