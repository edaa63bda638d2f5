// The role of one robot: what it is recruited for, where it is charged, and the rules that it follows in it.

import { get, put, send } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { deliveryText, ofRobot } from "./of_robot.js";

/** @param {Element} root */
export function mountRole(root) {
  /** @type {Robot | null} */
  let robot = null;
  /** @type {RobotRole | null} */
  let role = null;
  const state = el("span", { class: "quiet small", role: "status", "data-testid": "role-state" });
  const problem = el("div", { role: "alert" });
  const name = el("input", { type: "text", "aria-label": "Role", placeholder: "guard", pattern: "[a-z][a-z0-9_]*", size: 12, required: true });
  const home = el("input", { type: "text", "aria-label": "Home in this role", placeholder: "home: as it was", pattern: "[a-z][a-z0-9_]*", size: 16, list: "role-places" });
  const places = el("datalist", { id: "role-places" });
  const tags = el("fieldset", {});
  const rules = el("textarea", { "aria-label": "Rules of the role", placeholder: "ROLE guard; – left empty: the file of its name, if there is one", rows: 4, spellcheck: "false" });
  const give = el("button", { class: "primary", onclick: giveRole }, "Give the role");
  const end = el("button", { onclick: endRole }, "End the role");
  const known = ofRobot("role", problem, draw);
  replace(root, state, problem, el("div", { class: "head" }, name, home, places, give, end), tags, rules);

  /** @param {RobotRole} answer */
  function draw(answer) {
    role = answer;
    drawState();
    name.value = answer.role ?? "";
    home.value = answer.home ?? "";
    rules.value = answer.rules ?? "";
    replace(places, (robot?.reach ?? []).map((place) => el("option", { value: place })));
    replace(
      tags,
      el("legend", { class: "small" }, "Recruited for"),
      (robot?.repertoire ?? []).map((tag) => el("label", { class: "small" }, el("input", { type: "checkbox", value: tag, checked: answer.tags === null || answer.tags.includes(tag) }), ` ${tag}`)),
    );
  }

  function drawState() {
    if (role === null) return;
    const { role: played, decided_by: by } = role;
    const what = played === null ? "plays no role" : `plays ${words(played)}`;
    replace(state, `${what}; ${deliveryText(role, "rules ")}${by ? `; by ${by}` : ""}`);
    give.disabled = false;
    end.disabled = played === null;
  }

  /** @param {() => Promise<RobotRole>} request */
  async function change(request) {
    await known.answer(request, [give, end]);
    drawState();
  }

  function giveRole() {
    if (robot === null || role === null || !name.reportValidity() || !home.reportValidity()) return;
    const boxes = [...tags.querySelectorAll("input")];
    const chosen = boxes.filter((box) => box.checked).map((box) => box.value);
    const body = { role: name.value, tags: chosen.length === boxes.length ? null : chosen, home: home.value || null, rules: rules.value || null };
    const ifMatch = { "if-match": `"${role.version}"` };
    return change(() => put(known.path(), body, ifMatch));
  }

  function endRole() {
    if (role === null) return;
    const ifMatch = { "if-match": `"${role.version}"` };
    return change(() => send("DELETE", known.path(), {}, ifMatch));
  }

  return {
    /** @param {Robot | null} shown */
    setRobot(shown) {
      robot = shown;
      role = null;
      replace(state);
      return known.select(shown?.name ?? null);
    },
    /** Read how the robot has answered; what is being typed stays. */
    async refresh() {
      const wanted = robot?.name;
      if (wanted === undefined) return;
      /** @type {RobotRole | null} */
      const answer = await get(known.path()).catch(() => null);
      if (answer === null || robot?.name !== wanted) return;
      if (role !== null && answer.version === role.version) {
        role = answer;
        drawState();
      } else draw(answer);
    },
  };
}
