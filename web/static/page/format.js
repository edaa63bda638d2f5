// Words for what the service says.

export function fact({ predicate, args }) {
  return `${predicate}(${(args ?? []).join(", ")})`;
}

export function facts(list) {
  return (list ?? []).map(fact).join(", ");
}

export function seconds(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  const rounded = Math.max(0, value);
  if (rounded < 60) return `${rounded.toFixed(1)} s`;
  const whole = Math.round(rounded);
  return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, "0")} s`;
}

// A span that need not be told exactly: 43 s, 2 min, 3 h.
export function roughly(span) {
  if (span < 59.5) return `${Math.round(span)} s`;
  return span < 5400 ? `${Math.round(span / 60)} min` : `${Math.round(span / 3600)} h`;
}

// How far a makespan may be from the best there is, by the bound that no plan can beat; nothing without one.
export function gap(makespan, bound) {
  if (typeof bound !== "number" || bound <= 0) return "";
  if (makespan <= bound + 0.05) return "no plan is quicker";
  return `at most ${Math.ceil((100 * (makespan - bound)) / bound)} % over the quickest possible (${seconds(bound)})`;
}

export function words(identifier) {
  return String(identifier ?? "").replaceAll("_", " ");
}

// One of these, or idle: the colour of a badge, and its shape where nothing is known.
const TONES = {
  good: ["completed", "finished", "approved", "online"],
  bad: ["failed", "unsolvable", "no_plan_found", "rejected", "cancelled", "expired", "partially_completed", "connection_broken"],
  busy: ["running", "planning", "dispatching", "recovering", "initializing", "committed", "retriable"],
  unknown: ["unknown"],
  warn: ["paused", "planned", "proposed", "offline", "hibernating"],
};

export function tone(state) {
  return Object.keys(TONES).find((name) => TONES[name].includes(state)) ?? "idle";
}

// The word of a goal's badge, which is also what its colour goes by: a finished goal is as good as what came of it,
// and none is called unsolvable unless that is proven.
export function standing(goal) {
  if (goal.state === "unsolvable" && goal.outcome && goal.outcome !== "unsolvable") return "no_plan_found";
  return goal.state === "finished" && goal.outcome ? goal.outcome : goal.state;
}

// When something was, by the clock on the wall; with the day if that is another.
export function instant(iso) {
  const when = new Date(iso);
  if (Number.isNaN(when.getTime())) return String(iso ?? "");
  const day = when.toDateString() === new Date().toDateString() ? "" : `${when.toLocaleDateString()} `;
  return `${day}${when.toLocaleTimeString()}`;
}
