// The button that opens the workbench in place of goal and plan. Its modules and style are fetched when first needed.

import { byId, fetchStyle } from "../page/dom.js";

/** @param {Store} store @param {Telemetry} telemetry @returns {Workbench} */
export function mountWorkbenchButton(store, telemetry) {
  const button = byId("workbench-toggle", HTMLButtonElement);
  const middle = byId("middle", HTMLElement);
  const root = byId("workbench", HTMLElement);
  /** @type {Promise<Workbench> | null} */
  let workbench = null;

  async function load() {
    const [{ mountWorkbench }] = await Promise.all([import("./workbench.js"), fetchStyle("style/workbench.css")]);
    return mountWorkbench(root, store, telemetry);
  }

  /** @param {boolean} isOpen @param {string} [part] */
  async function setOpen(isOpen, part) {
    root.hidden = !isOpen;
    middle.classList.toggle("benched", isOpen);
    button.setAttribute("aria-pressed", String(isOpen));
    if (isOpen) (await (workbench ??= load())).open(part);
    else (await workbench)?.close();
  }

  button.addEventListener("click", () => setOpen(Boolean(root.hidden)));
  return {
    open: (part) => setOpen(true, part),
    close: () => root.hidden || setOpen(false),
    onEvent: async (event) => (await workbench)?.onEvent(event),
  };
}
