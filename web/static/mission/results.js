// What a mission's packets have brought: images as thumbnails, which open large, and readings.

import { id, list } from "../page/api.js";
import { el, quiet, show } from "../page/dom.js";
import { problemBox } from "../page/problem.js";

/** Show the results of a mission, requested again when there are more. @param {HTMLElement} container @param {Mission} mission */
export async function showResults(container, mission) {
  const of = `${mission.id} ${mission.results}`;
  if (container.dataset.of === of) return;
  container.dataset.of = of;
  const path = `/v1/missions/${id(mission.id)}/results`;
  const time = (/** @type {Result} */ one) => new Date(one.created_at).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
  /** @type {Child} */
  const shown = await list(path).then((results) => resultList(results, (one) => `${path}/${id(one.id)}`, time), problemBox);
  if (container.dataset.of === of) show(container, shown);
}

/**
 * @param {Result[]} results @param {(result: Result) => string} address of an image @param {(result: Result) => string} when in words
 * @returns {Child}
 */
export function resultList(results, address, when) {
  if (!results.length) return null;
  return el("ul", { class: "results", "aria-label": "Results", "data-testid": "results" }, results.map((result) => el("li", { class: result.kind }, content(result, address, when))));
}

/** @param {Result} result @param {(result: Result) => string} address @param {(result: Result) => string} when */
function content(result, address, when) {
  const about = `${result.of}, by ${result.robot}, ${when(result)}`;
  if (result.kind === "reading") return [el("b", {}, result.name), ` ${Number(result.value?.toPrecision(4))} ${result.unit} `, quiet(about)];
  const image = { src: address(result), alt: `${result.of} as the ${result.name} of ${result.robot} sees it` };
  return el(
    "figure",
    {},
    el("button", { title: "Show it large", onclick: () => enlarge(image, about) }, el("img", { ...image, loading: "lazy" })),
    el("figcaption", { class: "quiet small" }, about),
  );
}

/** @param {{src: string, alt: string}} image @param {string} about */
function enlarge(image, about) {
  const dialog = el(
    "dialog",
    { class: "enlarged", "aria-label": about, "data-testid": "result-dialog" },
    el("img", image),
    el("form", { method: "dialog", class: "row" }, el("span", { class: "spring" }, about), el("button", { type: "submit" }, "Close")),
  );
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}
