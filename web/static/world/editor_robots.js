// Robots in the editor of a world: speed, packets and who speaks for them are changed, robots that have announced themselves are admitted or refused.

import { get, id, post } from "../page/api.js";
import { el, quiet, replace, show } from "../page/dom.js";
import { attempt } from "../page/problem.js";

/**
 * @param {() => string} path the world's @param {Element} box shows an error
 * @param {{add: (edit: WorldEdit) => unknown, reload: () => unknown}} actions `add`: to the changes that are drafted
 */
export function createRobotEditor(path, box, { add, reload }) {
  /** @type {EditedRobot[]} */
  let robots = [];
  const name = el("select", { "aria-label": "Robot to change", "data-testid": "edit-robot", onchange: fill });
  const speed = el("input", { type: "number", required: true, min: 0.01, max: 2, step: "any", "aria-label": "Speed in metres a second" });
  const tags = el("input", { pattern: "[A-Z0-9_ ]*", "aria-label": "Packets, separated by spaces" });
  const speaker = el("select", { "aria-label": "Who speaks for the robot", "data-testid": "edit-speaker" }, el("option", { value: "" }, "simulated"), el("option", { value: "external" }, "real: its own software"));
  const announced = el("div", { hidden: true }, el("h3", { class: "small" }, "Announced, not admitted"));
  const listed = el("ol", { class: "edits", "data-testid": "announced" });
  announced.append(listed);
  const form = el("form", { class: "row", onsubmit: change }, name, speed, "m/s", tags, speaker, el("button", { type: "submit", "data-testid": "edit-change-robot" }, "Change robot"));

  const known = () => robots.find((robot) => robot.name === name.value);

  function fill() {
    const robot = known();
    speed.value = String(robot?.speed_m_s ?? "");
    tags.value = robot?.repertoire.join(" ") ?? "";
    speaker.value = robot?.external ? "external" : "";
  }

  /** @param {Event} event */
  function change(event) {
    event.preventDefault();
    const robot = known();
    if (!robot) return;
    const wanted = tags.value.split(" ").filter(Boolean);
    /** @type {WorldEdit} */
    const edit = { edit: "change_robot", name: robot.name };
    if (Number(speed.value) !== robot.speed_m_s) edit.speed_m_s = Number(speed.value);
    if (wanted.join(" ") !== robot.repertoire.join(" ")) edit.repertoire = wanted;
    const isExternal = speaker.value === "external";
    if (isExternal !== (robot.external ?? false)) edit.external = isExternal;
    if (Object.keys(edit).length > 2) add(edit);
  }

  /** @param {Factsheet} one */
  function line({ robot, reason, state, sheet }) {
    const address = `${path()}/robots/${id(robot)}`;
    const said = `${sheet.repertoire.join(", ")} · ${sheet.speed_m_s} m/s`;
    const admit = button("Admit", "admit", () => post(`${address}:admit`));
    const refuse = button("Refuse", "refuse", () => post(`${address}:refuse`, { reason: "refused on the page" }));
    /** @param {string} label @param {string} verb @param {() => Promise<unknown>} request */
    function button(label, verb, request) {
      /** @type {HTMLButtonElement} */
      const made = el("button", { "data-testid": `${verb}-${robot}`, onclick: () => decide(made, request) }, label);
      return made;
    }
    const words = el("span", { class: "grow" }, el("b", {}, robot), ` ${said} `, quiet(state === "refused" ? `refused: ${reason}` : reason));
    return el("li", {}, words, admit, state === "announced" ? refuse : null);
  }

  /** @param {HTMLButtonElement} button @param {() => Promise<unknown>} request */
  async function decide(button, request) {
    await attempt([button], box, async () => {
      await request();
      await reload();
    });
  }

  return {
    node: el("div", {}, form, announced),
    /** @param {EditedRobot[]} now the world's */
    async load(now) {
      robots = now;
      const chosen = name.value;
      show(name, robots.map((robot) => el("option", {}, robot.name)));
      if (robots.some((robot) => robot.name === chosen)) name.value = chosen;
      fill();
      /** @type {{items: Factsheet[]}} */
      const { items } = await get(`${path()}/factsheets`);
      const outside = items.filter(({ state }) => state === "announced" || state === "refused");
      announced.hidden = outside.length === 0;
      replace(listed, outside.map(line));
    },
    /** @param {string} robot */
    choose(robot) {
      name.value = robot;
      fill();
    },
  };
}
