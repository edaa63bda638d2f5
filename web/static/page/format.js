// Formats the service's values as text.

/** @param {Fact} fact */
export function fact({ predicate, args }) {
  return `${predicate}(${(args ?? []).join(", ")})`;
}

/** @param {Fact[]} [list] */
export function facts(list = []) {
  return list.map(fact).join(", ");
}

/** @param {number | null | undefined} value */
export function seconds(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  const positive = Math.max(0, value);
  if (positive < 60) return `${positive.toFixed(1)} s`;
  const whole = Math.round(positive);
  return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, "0")} s`;
}

/** A duration to one unit: 43 s, 2 min, 3 h. @param {number} span_s */
export function roughly(span_s) {
  if (span_s < 59.5) return `${Math.round(span_s)} s`;
  return span_s < 5400 ? `${Math.round(span_s / 60)} min` : `${Math.round(span_s / 3600)} h`;
}

/**
 * How far a makespan may be from the optimum, by its lower bound; empty without one.
 * @param {number} makespan_s @param {number | null | undefined} bound_s
 */
export function gap(makespan_s, bound_s) {
  if (typeof bound_s !== "number" || bound_s <= 0) return "";
  if (makespan_s <= bound_s + 0.05) return "no plan is quicker";
  return `at most ${Math.ceil((100 * (makespan_s - bound_s)) / bound_s)} % over the quickest possible (${seconds(bound_s)})`;
}

/** @param {unknown} identifier */
export function words(identifier) {
  return String(identifier ?? "").replaceAll("_", " ");
}

/** The tone of a badge: its colour, and for an unknown state also its shape. @type {Record<string, string[]>} */
const TONES = {
  good: ["completed", "finished", "approved", "online"],
  bad: ["failed", "unsolvable", "no_plan_found", "rejected", "cancelled", "expired", "partially_completed", "connection_broken"],
  busy: ["running", "planning", "dispatching", "recovering", "initializing", "committed", "retriable"],
  unknown: ["unknown"],
  warn: ["paused", "planned", "proposed", "offline", "hibernating"],
};

/** @param {string | undefined} state */
export function tone(state) {
  return Object.keys(TONES).find((name) => TONES[name].includes(state ?? "")) ?? "idle";
}

/**
 * The state on a goal's badge: a finished goal shows its outcome, and only a proven one is called unsolvable.
 * @param {Goal} goal
 */
export function displayState(goal) {
  if (goal.state === "unsolvable" && goal.outcome && goal.outcome !== "unsolvable") return "no_plan_found";
  return goal.state === "finished" && goal.outcome ? goal.outcome : goal.state;
}

/** A wall-clock time, with the date unless that is today. @param {string} iso */
export function instant(iso) {
  const when = new Date(iso);
  if (Number.isNaN(when.getTime())) return iso;
  const day = when.toDateString() === new Date().toDateString() ? "" : `${when.toLocaleDateString()} `;
  return `${day}${when.toLocaleTimeString()}`;
}

/** @template {{created_at: string}} T @param {T[]} list */
export function newestFirst(list) {
  return [...list].sort((one, other) => other.created_at.localeCompare(one.created_at));
}

/** yard_2 before yard_10. @param {string} one @param {string} other */
export const byNumber = (one, other) => one.localeCompare(other, undefined, { numeric: true });
