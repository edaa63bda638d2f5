// What robots, the service and persons have said to each other, put together from events and from missions' conversations.

export const SERVICE = "service";
const LATE_S = 2; // a robot says it again after this time at the earliest

/**
 * The sayings that a report tells of: what was heard, and the answer if it is told with it. What the service says for a person,
 * the person says.
 * @param {Speech} speech @returns {Saying[]}
 */
export function sayingsOf({ sender, robot, performative, content, protocol, conversation, sent_at_s: said, at_s: heard, attempt, answer, answer_content: words, speaker }) {
  const shared = { protocol, conversation, isAnswered: false };
  const first = { ...shared, from: speaker || sender, to: robot, performative, content, said_s: said, heard_s: sender === SERVICE ? null : heard, attempt: attempt ?? 1 };
  if (!answer) return [first];
  return [first, { ...shared, from: robot, to: sender, performative: answer, content: words ?? "", said_s: heard, heard_s: null, attempt: 1 }];
}

/**
 * The sayings of an event; of a script's clearance the service's.
 * @param {ServiceEvent} event @param {number} now world's clock, if the event does not say
 * @returns {Saying[]}
 */
export function sayingsOfEvent({ type, subject = "", data }, now) {
  if (type === "speech.heard") return sayingsOf(/** @type {Speech} */ (data));
  if (type === "speech.said") return sayingsOf(/** @type {Speech} */ ({ ...data, robot: data?.receiver }));
  if (type !== "script.cleared" || !data?.robot) return [];
  const shared = { from: SERVICE, to: data.robot, performative: "inform", protocol: "clearance", conversation: subject, said_s: now, heard_s: null, attempt: 1, isAnswered: false };
  return (data.ended ?? []).map((action) => ({ ...shared, content: `ended(${subject}, ${action})` }));
}

/**
 * The sayings of a conversation of the service, in its own name or a person's.
 * @param {ServiceConversation} conversation @returns {Saying[]}
 */
export function sayingsWithService({ id, protocol, speaker, said }) {
  return said.flatMap((one) => sayingsOf({ ...one, robot: one.receiver, protocol, conversation: id, speaker: one.sender === SERVICE ? speaker : "" }));
}

/**
 * In order of time, each once, with whether it was answered.
 * @param {Saying[]} sayings @returns {Saying[]}
 */
export function merged(sayings) {
  /** Who speaks through the service, by conversation. @type {Map<string, string>} */
  const persons = new Map();
  for (const one of sayings) if (one.to !== SERVICE && !persons.has(one.conversation)) persons.set(one.conversation, one.from);
  const addressed = sayings.map((one) => (one.to === SERVICE ? { ...one, to: persons.get(one.conversation) ?? SERVICE } : one));
  const known = new Map(addressed.map((one) => [JSON.stringify([one.conversation, one.from, one.to, one.performative, one.content, one.said_s]), one]));
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
