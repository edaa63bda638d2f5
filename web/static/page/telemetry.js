// The robots' telemetry stream, open only while something listens and the page is visible.

import { id } from "./api.js";

/** @returns {Telemetry} */
export function createTelemetry() {
  /** @type {Set<(message: TelemetryMessage) => void>} */
  const listeners = new Set();
  /** @type {{path: string, stream: EventSource} | null} */
  let source = null;
  /** @type {string | null} */
  let world = null;
  /** @type {Record<string, RobotTelemetry> | null} */
  let replayed = null; // the telemetry at the shown instant of a recording
  /** @param {TelemetryMessage} message */
  const publish = (message) => listeners.forEach((listener) => listener(message));

  function adjust() {
    const path = listeners.size > 0 && !document.hidden && world !== null ? `/v1/telemetry?world=${id(world)}` : null;
    if (source && source.path === path) return;
    source?.stream.close();
    source = path === null ? null : { path, stream: new EventSource(path) };
    if (source) {
      source.stream.onmessage = (message) => {
        if (!replayed) publish(JSON.parse(message.data));
      };
    }
  }

  document.addEventListener("visibilitychange", adjust);
  addEventListener("pagehide", () => source?.stream.close());
  return {
    setWorld(name) {
      world = name;
      adjust();
    },
    // Publishes recorded telemetry in place of the live one; null ends that.
    replay(robots) {
      replayed = robots;
      if (replayed) publish({ robots: replayed });
    },
    // Calls `listener` with all robots' telemetry until the function that it returns is called.
    follow(listener) {
      listeners.add(listener);
      adjust();
      if (replayed) listener({ robots: replayed }); // nothing more comes while the recording is paused
      return () => {
        listeners.delete(listener);
        adjust();
      };
    },
  };
}
