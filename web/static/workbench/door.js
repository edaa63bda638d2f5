// The way into the workbench, which takes the place of goal and plan. Its modules and style are fetched at the first time.

import { el } from "../page/dom.js";

export function mountDoor(store, telemetry) {
  const [button, middle, root] = ["workbench-toggle", "middle", "workbench"].map((name) => document.getElementById(name));
  let bench = null;
  const fetched = async () => {
    document.head.append(el("link", { rel: "stylesheet", href: "style/workbench.css" }));
    return (await import("./workbench.js")).mountWorkbench(root, store, telemetry);
  };
  const set = async (isOpen, part) => {
    root.hidden = !isOpen;
    middle.classList.toggle("benched", isOpen);
    button.setAttribute("aria-pressed", String(isOpen));
    if (isOpen) (await (bench ??= fetched())).open(part);
    else (await bench)?.close();
  };
  button.addEventListener("click", () => set(root.hidden));
  return {
    open: (part) => set(true, part),
    close: () => root.hidden || set(false),
    heard: async (event) => (await bench)?.heard(event),
  };
}
