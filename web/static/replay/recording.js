// A recording, asked for any instant: where robots were and what they told, where samples lay, how the mission stood.

export function createRecording(replay) {
  const times = [...Object.values(replay.robots).flatMap((rows) => [rows[0]?.[0], rows.at(-1)?.[0]]), ...replay.missions.map((one) => one.at_s)].filter((time) => typeof time === "number");
  const [from, to] = [Math.min(...times), Math.max(...times)];
  const known = (rows, time) => rows[Math.max(0, latest(rows, time))];
  return {
    from,
    to,
    layout: replay.world.layout,
    events: replay.events,
    robots: (time) => Object.fromEntries(Object.entries(replay.robots).filter(([, rows]) => rows.length && rows[0][0] <= time + 0.5).map(([name, rows]) => [name, { ...known(replay.telemetry?.[name] ?? [], time), ...pose(rows, time) }])),
    samples: (time) => new Map(Object.entries(known(replay.samples, time)?.lying ?? {})),
    mission: (time) => known(replay.missions, time)?.mission ?? null,
    // The place in `events` of the last one until then; -1 before the first.
    event: (time) => latest(replay.events, time),
  };
}

const instant = (row) => row.at_s ?? row[0];

// The place of the last row that is not later, -1 if all are; rows are in order.
function latest(rows, time) {
  let [low, high] = [0, rows.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (instant(rows[middle]) <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

// Between two rows a robot is where a straight line between them says.
function pose(rows, time) {
  const here = latest(rows, time);
  const before = rows[Math.max(0, here)];
  const after = rows[here + 1] ?? before;
  const share = after[0] > before[0] ? (time - before[0]) / (after[0] - before[0]) : 0;
  const between = (column) => before[column] + share * (after[column] - before[column]);
  const turn = Math.atan2(Math.sin(after[3] - before[3]), Math.cos(after[3] - before[3]));
  return { x_m: between(1), y_m: between(2), heading_rad: before[3] + share * turn, holding: before[4], packet_tag: before[5] };
}
