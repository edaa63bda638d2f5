// What robots, the service and persons have said to each other, put together from events and from missions' conversations.

export const SERVICE = "service";
const LATE_S = 2; // a robot says it again after this time at the earliest

/**
 * The sayings that a robot's report tells of: what it has heard, and its answer.
 * @param {Speech} speech @returns {Saying[]}
 */
export function sayingsOf({ sender, robot, performative, content, protocol, conversation, sent_at_s: said, at_s: heard, attempt, answer, answer_content: words }) {
  const shared = { protocol, conversation, isAnswered: false };
  return [
    { ...shared, from: sender, to: robot, performative, content, said_s: said, heard_s: heard, attempt: attempt ?? 1 },
    { ...shared, from: robot, to: sender, performative: answer, content: words ?? "", said_s: heard, heard_s: null, attempt: 1 },
  ];
}

/**
 * The sayings of an event; of a script's clearance the service's.
 * @param {ServiceEvent} event @param {number} now world's clock, if the event does not say
 * @returns {Saying[]}
 */
export function sayingsOfEvent({ type, subject = "", data }, now) {
  if (type === "speech.heard") return sayingsOf(/** @type {Speech} */ (data));
  if (type !== "script.cleared" || !data?.robot) return [];
  const shared = { from: SERVICE, to: data.robot, performative: "inform", protocol: "clearance", conversation: subject, said_s: now, heard_s: null, attempt: 1, isAnswered: false };
  return (data.ended ?? []).map((action) => ({ ...shared, content: `ended(${subject}, ${action})` }));
}

/**
 * In order of time, each once, with whether it was answered.
 * @param {Saying[]} sayings @returns {Saying[]}
 */
export function merged(sayings) {
  const known = new Map(sayings.map((one) => [JSON.stringify([one.conversation, one.from, one.to, one.performative, one.content, one.said_s]), one]));
  const all = [...known.values()].sort((one, other) => one.said_s - other.said_s);
  /** When somebody last said something to somebody in a conversation. @type {Map<string, number>} */
  const last = new Map(all.map((one) => [JSON.stringify([one.conversation, one.from, one.to]), one.said_s]));
  return all.map((one) => ({ ...one, isAnswered: (last.get(JSON.stringify([one.conversation, one.to, one.from])) ?? -1) >= one.said_s }));
}

/** What is known of how it arrived, in words; empty if it was heard at once. @param {Saying} one @returns {string} */
export function fate({ said_s: said, heard_s: heard, attempt, isAnswered }) {
  if (heard === null) return isAnswered ? "" : "whether it was heard is not reported";
  const later = heard - said >= LATE_S ? `heard ${(heard - said).toFixed(1)} s later` : "";
  const lost = attempt === 2 ? "the first copy was lost or overtaken" : `${attempt - 1} copies were lost or overtaken`;
  return [attempt > 1 && `said ${attempt} times: ${lost}`, later].filter(Boolean).join(", ");
}
