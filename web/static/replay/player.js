// Replays a past mission's recording on the page in place of the live state.

import { get, id } from "../page/api.js";
import { byId, el, replace, show } from "../page/dom.js";
import { problemBox } from "../page/problem.js";
import { createControls } from "./controls.js";
import { createRecording } from "./recording.js";

/**
 * @param {Store} store @param {Telemetry} telemetry
 * @param {{picture: Picture, world: ReturnType<typeof import("../world/world.js").mountWorld>}} parts
 */
export function mountPlayer(store, telemetry, { picture, world }) {
  const panel = byId("player", HTMLElement);
  /** @type {ReturnType<typeof createControls> | null} */
  let controls = null;

  /** @param {Record<string, RobotTelemetry>} robots @param {number} time */
  function onSeek(robots, time) {
    telemetry.replay(robots);
    world.replayTo(time);
  }

  function close() {
    panel.hidden = true;
    if (controls === null) return;
    controls.pause();
    controls = null;
    telemetry.replay(null);
    world.showLive();
    store.update({ replaying: null });
  }

  /** @param {Mission} mission */
  async function open(mission) {
    close();
    panel.hidden = false;
    show(panel, el("p", { class: "quiet" }, "Fetching the recording …"));
    const path = `/v1/missions/${id(mission.id)}`;
    try {
      const recording = createRecording(await get(`${path}/replay`));
      store.update({ replaying: mission.id });
      const drawing = await world.showReplay(recording.layout, mission.id);
      const more = [
        el("a", { href: `${path}/recording`, download: "" }, "MCAP file"),
        el("a", { href: `${path}/replay.html`, download: "" }, "HTML file"),
        el("button", { "data-testid": "replay-close", onclick: close }, "Back to live"),
      ];
      controls = createControls({ recording, picture, drawing, more, onSeek });
    } catch (error) {
      replace(panel, problemBox(error), el("button", { onclick: close }, "Close"));
      return;
    }
    replace(panel, controls.nodes);
    controls.focus();
    picture.node.scrollIntoView({ block: "center" });
  }

  store.subscribe((state) => {
    if (state.replaying && state.mission && state.mission.id !== state.replaying) close();
  });
  return { open };
}
