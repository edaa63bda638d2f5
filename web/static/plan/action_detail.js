// The action under the pointer or selected: its conditions and effects, and why this robot performs it.

import { get, id } from "../page/api.js";
import { el, show } from "../page/dom.js";

export function createActionDetail() {
  const node = el("div", { class: "detail", "data-testid": "action-detail", role: "status" });
  /** @type {Map<string, Promise<ActionExplanation | null>>} */
  const explanations = new Map();
  /** @type {string | null} */
  let shown = null;

  /** @param {Plan} plan @param {PlannedAction} action */
  function explanation(plan, action) {
    const path = `/v1/plans/${id(plan.id)}/actions/${id(action.id)}/explanation`;
    const known = explanations.get(path) ?? get(path).catch(() => null);
    explanations.set(path, known);
    return known;
  }

  return {
    node,
    /** @param {Plan} plan @param {PlannedAction | null} action @param {ActionChange} [change] */
    async show(plan, action, change) {
      shown = action?.id ?? null;
      if (!action) {
        show(node, hint());
        return;
      }
      const asked = explanation(plan, action);
      const { description, reasonList } = await import("./action_text.js"); // fetched when first needed
      if (shown === action.id) show(node, description(action, change));
      const reasons = await asked;
      if (shown === action.id) show(node, description(action, change), reasons ? reasonList(reasons) : null);
    },
  };
}

function hint() {
  return el("p", { class: "quiet small" }, "Point at an action, or go there with the arrow keys, to see what it needs and why it is there.");
}
