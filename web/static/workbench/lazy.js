// The button that opens the workbench in place of goal and plan. Its modules and style are fetched when first needed.

import { byId, show } from "../page/dom.js";
import { part } from "../page/part.js";
import { problemBox } from "../page/problem.js";

const fetchWorkbench = part(() => import("./workbench.js"), "workbench");

/** @param {Store} store @param {Telemetry} telemetry @returns {Workbench} */
export function mountWorkbenchButton(store, telemetry) {
  const button = byId("workbench-toggle", HTMLButtonElement);
  const middle = byId("middle", HTMLElement);
  const root = byId("workbench", HTMLElement);
  /** @type {Workbench | null} */
  let workbench = null;
  let isOpen = false;
  /** @type {Promise<unknown> | undefined} */
  let opening; // events that come meanwhile are passed on afterwards

  /** What was shown stays until the workbench is there. @param {string} [name] of its part */
  async function load(name) {
    setPressed(true);
    try {
      const { mountWorkbench } = await fetchWorkbench();
      if (!isOpen) return; // closed meanwhile
      workbench ??= mountWorkbench(root, store, telemetry);
      await workbench.open(name);
      middle.classList.toggle("benched", isOpen);
    } catch (error) {
      show(root, problemBox(error));
    }
    root.hidden = !isOpen;
  }

  function close() {
    setPressed(false);
    root.hidden = true;
    middle.classList.remove("benched");
    workbench?.close();
  }

  /** @param {boolean} isPressed */
  function setPressed(isPressed) {
    isOpen = isPressed;
    button.setAttribute("aria-pressed", String(isPressed));
  }

  /** @param {string} [name] */
  const open = (name) => (opening = load(name));
  button.addEventListener("click", () => (isOpen ? close() : open()));
  return {
    open,
    close,
    async onEvent(event) {
      await opening;
      workbench?.onEvent(event);
    },
  };
}
