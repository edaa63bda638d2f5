// What is picked in the world, on the map or in three dimensions: a robot to look at; a sample and then a place, a goal.

export function createPicking(store, { onPick }) {
  const note = document.getElementById("pick-note");
  store.subscribe(({ sample, replaying }) => {
    note.textContent = replaying ? "This is a recording." : sample ? `${sample}: pick the place it is to go to.` : "";
  });
  return ({ kind, name }) => {
    const { robot, sample } = store.get();
    if (kind === "robot") store.update({ robot: robot === name ? null : name });
    else if (kind === "sample") store.update({ sample: sample === name ? null : name });
    else if (sample) {
      onPick(`move ${sample} to ${name}`);
      store.update({ sample: null });
    } else note.textContent = "Pick a sample first, then the place it is to go to.";
  };
}
