// The body of one robot: which one its mind is in, and its moves into another one.

import { post } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { words } from "../page/format.js";
import { attempt } from "../page/problem.js";
import { ofRobot } from "./of_robot.js";

const REAL = "real";
const KINDS = ["velocity", "wheeled", "avatar", REAL];

/** @param {Element} root */
export function mountBody(root) {
  const problem = el("div", { role: "alert" });
  const row = el("div", { class: "head", "data-testid": "embodiment" });
  const embodiment = ofRobot("embodiment", problem, (/** @type {Embodiment} */ one) => replace(row, draw(one)));
  replace(root, problem, row);

  /** @param {Embodiment} one */
  function draw({ kind, body, attempts, lease_until_s: lease }) {
    const [move] = attempts;
    const isMoving = move !== undefined && move.ended_at === null;
    const said = [
      kind,
      lease === null ? null : `until ${lease.toFixed(0)} s unless renewed`,
      isMoving ? `a move to ${move.body.kind} is ${words(move.state)}` : move?.reason ? `not moved to ${move.body.kind}: ${move.reason}` : null,
    ];
    const note = el("span", { class: "quiet small", role: "status" }, said.filter(Boolean).join("; "));
    const now = kind === REAL ? REAL : body.kind;
    const kinds = KINDS.includes(now) ? KINDS : [now, ...KINDS];
    const choice = el("select", { "aria-label": "Body", disabled: isMoving }, kinds.map((each) => el("option", { value: each, selected: each === now }, each)));
    choice.addEventListener("change", () => moveTo(choice.value));
    return [el("label", { class: "small" }, "body ", choice), note];
  }

  /** @param {string} kind */
  async function moveTo(kind) {
    await attempt([], problem, () => post(embodiment.path().replace("/embodiment", ":embody"), { body: kind }));
    if (problem.childElementCount === 0) await embodiment.load();
  }

  return {
    /** @param {string | null} name */
    setRobot(name) {
      replace(row);
      return embodiment.select(name);
    },
    refresh: embodiment.load,
  };
}
