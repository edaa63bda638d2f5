// Where the readings of one robot's sensors come from: from the sensors, or from their virtual counterparts.

import { id, put } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { attempt } from "../page/problem.js";
import { ofRobot } from "./of_robot.js";

/** @param {Element} root */
export function mountSensors(root) {
  const problem = el("div", { role: "alert" });
  const rows = el("div", { class: "head", "data-testid": "sensor-sources" });
  const sensors = ofRobot("sensors", problem, (/** @type {{items: SourcedSensor[]}} */ { items }) => replace(rows, items.map(drawSensor)));
  replace(root, problem, rows);

  /** @param {SourcedSensor} one */
  function drawSensor({ sensor, source }) {
    const options = ["real", "virtual"].map((each) => el("option", { value: each, selected: each === source }, each));
    const choice = el("select", { "aria-label": `Source of ${words(sensor)}` }, options);
    choice.addEventListener("change", () => set(sensor, choice.value));
    const note = source === "virtual" ? "virtual: the echoes of the map's walls" : "";
    return [el("label", { class: "small" }, `${words(sensor)} `, choice), el("span", { class: "quiet small", role: "status" }, note)];
  }

  /** @param {string} sensor @param {string} source */
  async function set(sensor, source) {
    await attempt([], problem, () => put(`${sensors.path()}/${id(sensor)}`, { source }));
    if (problem.childElementCount === 0) await sensors.load();
  }

  return {
    /** @param {string | null} name */
    setRobot(name) {
      replace(rows);
      return sensors.select(name);
    },
    refresh: sensors.load,
  };
}
