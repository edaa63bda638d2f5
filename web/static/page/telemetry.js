// What robots tell of themselves ten times a second, followed only while somebody looks and the page is seen.

import { id } from "./api.js";

export function createTelemetry() {
  const listeners = new Set();
  let source = null;
  let world = null;
  let replayed = null; // what robots told at the instant of a recording that is shown
  const tell = (told) => listeners.forEach((listener) => listener(told));

  function adjust() {
    const wanted = listeners.size > 0 && !document.hidden && world !== null;
    const path = wanted ? `/v1/telemetry?world=${id(world)}` : null;
    if (source && source.path === path) return;
    source?.stream.close();
    source = path && { path, stream: new EventSource(path) };
    if (source) {
      source.stream.onmessage = (message) => {
        if (!replayed) tell(JSON.parse(message.data));
      };
    }
  }

  document.addEventListener("visibilitychange", adjust);
  addEventListener("pagehide", () => source?.stream.close());
  return {
    of(name) {
      world = name;
      adjust();
    },
    // Tells what robots told once, instead of what they tell; null ends that.
    replay(robots) {
      replayed = robots;
      if (replayed) tell({ robots });
    },
    // Calls `listener` with all robots' telemetry until the function that it answers is called.
    follow(listener) {
      listeners.add(listener);
      adjust();
      if (replayed) listener({ robots: replayed }); // nothing more comes while the recording stands still
      return () => {
        listeners.delete(listener);
        adjust();
      };
    },
  };
}
