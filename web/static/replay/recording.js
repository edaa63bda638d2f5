// A recording, queried at any instant: robots' poses and telemetry, samples' places, the mission's state.

/** @param {Replay} replay @returns {Recording} */
export function createRecording(replay) {
  const times = [...Object.values(replay.robots).flatMap((rows) => [rows[0]?.[0], rows.at(-1)?.[0]]), ...replay.missions.map((one) => one.at_s)].filter((time) => typeof time === "number");
  // These are drawn from the start, where they were first heard from; others have come later.
  const present = new Set(replay.world.layout.robots.map(({ name }) => name));
  return {
    from: Math.min(...times),
    to: Math.max(...times),
    layout: replay.world.layout,
    events: replay.events,
    results: replay.results ?? [],
    robots(time) {
      const started = Object.entries(replay.robots).filter(([name, rows]) => rows.length && (present.has(name) || rows[0][0] <= time));
      return Object.fromEntries(started.map(([name, rows]) => [name, { ...lastRow(replay.telemetry?.[name] ?? [], time), ...pose(rows, time), at_s: time }]));
    },
    samples: (time) => new Map(Object.entries(lastRow(replay.samples, time)?.lying ?? {})),
    minds: Object.keys(replay.minds ?? {}),
    mind(robot, time) {
      const rows = replay.minds?.[robot] ?? [];
      return rows[lastIndex(rows, (row) => row.at_s, time)] ?? null; // nothing is known before the first
    },
    mission: (time) => lastRow(replay.missions, time)?.mission ?? null,
    // The index in `events` of the last one until `time`; -1 before the first.
    event: (time) => lastIndex(replay.events, (row) => row.at_s, time),
  };
}

/** The last row until `time`; before the first, the first. @template {{at_s: number}} T @param {T[]} rows @param {number} time @returns {T | undefined} */
function lastRow(rows, time) {
  return rows[Math.max(0, lastIndex(rows, (row) => row.at_s, time))];
}

/**
 * The index of the last row, in order of time, that is not later than `time`; -1 if all are.
 * @template T @param {T[]} rows @param {(row: T) => number} timeOf @param {number} time
 */
function lastIndex(rows, timeOf, time) {
  let low = 0;
  let high = rows.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timeOf(rows[middle]) <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** The pose at an instant, interpolated between two rows. @param {RecordedPose[]} rows @param {number} time */
function pose(rows, time) {
  const index = Math.max(0, lastIndex(rows, ([at]) => at, time));
  const [fromTime, fromX, fromY, fromHeading, holding, packet_tag] = rows[index];
  const [toTime, toX, toY, toHeading] = rows[index + 1] ?? rows[index];
  const share = toTime > fromTime ? Math.max(0, (time - fromTime) / (toTime - fromTime)) : 0;
  const turn = Math.atan2(Math.sin(toHeading - fromHeading), Math.cos(toHeading - fromHeading));
  return { x_m: fromX + share * (toX - fromX), y_m: fromY + share * (toY - fromY), heading_rad: fromHeading + share * turn, holding, packet_tag };
}
