// Where the readings of one robot's sensors come from: from the sensors, or from their virtual counterparts.

import { id, list, put } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { attempt } from "../page/problem.js";

/** @param {Element} root */
export function mountSensors(root) {
  /** @type {string | null} */
  let robot = null;
  const problem = el("div", { role: "alert" });
  const rows = el("div", { class: "head", "data-testid": "sensor-sources" });
  replace(root, problem, rows);

  async function load() {
    const name = robot;
    if (name === null) return;
    await attempt([], problem, async () => {
      /** @type {SourcedSensor[]} */
      const sensors = await list(`/v1/robots/${id(name)}/sensors`);
      if (robot === name) replace(rows, sensors.map(drawSensor));
    });
  }

  /** @param {SourcedSensor} one */
  function drawSensor({ sensor, source }) {
    const options = ["real", "virtual"].map((each) => el("option", { value: each, selected: each === source }, each));
    const choice = el("select", { "aria-label": `Source of ${words(sensor)}` }, options);
    choice.addEventListener("change", () => set(sensor, choice));
    const note = source === "virtual" ? "virtual: the echoes of the map's walls" : "";
    return [el("label", { class: "small" }, `${words(sensor)} `, choice), el("span", { class: "quiet small", role: "status" }, note)];
  }

  /** @param {string} sensor @param {HTMLSelectElement} choice */
  async function set(sensor, choice) {
    const name = robot;
    if (name === null) return;
    await attempt([], problem, () => put(`/v1/robots/${id(name)}/sensors/${id(sensor)}`, { source: choice.value }));
    if (problem.childElementCount === 0) await load();
  }

  return {
    /** @param {string | null} name */
    setRobot(name) {
      robot = name;
      replace(rows);
      return load();
    },
    refresh: load,
  };
}
