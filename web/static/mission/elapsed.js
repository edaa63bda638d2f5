// How long a mission has been under way, by the world's clock.

// When the plan that it carries out now began: a repaired one begins later than its mission.
export function begun(mission) {
  return mission.revised_at_s ?? mission.started_at_s;
}

// Seconds between `from` and `time`, or the mission's end; null before it has begun.
export function elapsed(mission, time, from = mission.started_at_s) {
  const until = mission.ended_at_s ?? time;
  return typeof from === "number" && typeof until === "number" ? Math.max(0, until - from) : null;
}
