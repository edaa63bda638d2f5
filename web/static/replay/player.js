// Opens a past mission's recording on the page, in the place of what is. What plays it is fetched at the first time.

import { get, id } from "../page/api.js";
import { el, replace, show } from "../page/dom.js";
import { problemBox } from "../page/problem.js";

export function mountPlayer(store, telemetry, { picture, world }) {
  const panel = document.getElementById("player");
  let controls = null;
  const shown = (robots, time) => (telemetry.replay(robots), world.replayTo(time));

  function close() {
    panel.hidden = true;
    controls?.pause();
    if (controls === null) return;
    controls = null;
    telemetry.replay(null);
    world.showLive();
    store.update({ replaying: null });
  }

  async function open(mission) {
    close();
    panel.hidden = false;
    show(panel, el("p", { class: "quiet" }, "Fetching the recording …"));
    const path = `/v1/missions/${id(mission.id)}`;
    try {
      const [said, { createControls }, { createRecording }] = await Promise.all([get(`${path}/replay`), import("./controls.js"), import("./recording.js")]);
      const recording = createRecording(said);
      store.update({ replaying: mission.id });
      const drawing = await world.showReplay(recording.layout, mission.id);
      controls = createControls({ recording, picture, onRobots: shown, drawing, more: [file(`${path}/recording`, "MCAP file"), file(`${path}/replay.html`, "HTML file"), el("button", { type: "button", "data-testid": "replay-close", onclick: close }, "Back to live")] });
    } catch (problem) {
      replace(panel, problemBox(problem), el("button", { type: "button", onclick: close }, "Close"));
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

function file(address, name) {
  return el("a", { href: address, download: "" }, name);
}
