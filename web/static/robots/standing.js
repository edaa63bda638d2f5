// How a door, hatch or lift stands, and what is wrong with it, in words.

/** @type {Record<string, string>} */
const MOVES = { OPEN: "opening", CLOSE: "closing", MOVE_TO_LEVEL: "moving" };

/** @param {Robot} robot */
export const isPeripheral = ({ kind = "robot" }) => kind !== "robot";

/** `opening`, `closing` or `moving`; empty while it stands. @param {Robot} peripheral */
export function movement({ packet, packet_state: progress }) {
  return (progress === "running" && MOVES[packet ?? ""]) || "";
}

/** @param {Robot} peripheral */
export function standing(peripheral) {
  const { kind, state } = peripheral;
  const moves = movement(peripheral);
  if (moves) return moves;
  if (!state) return "state unknown";
  return kind === "lift" ? `at ${state}` : state.replace("opened", "open");
}

/** Of a robot or peripheral: that nobody counts on it, or that it did not do its last packet. @param {Robot} robot */
export function outOfUse({ lost, out_of_service: resting, packet_state: progress }) {
  return lost ? "lost" : resting ? "out of service" : progress === "failed" ? "failed" : "";
}

/** Its kind and how it stands; null of a robot. @param {Robot} robot */
export function doing(robot) {
  if (!isPeripheral(robot)) return null;
  return [robot.kind, standing(robot), robot.packet_state === "failed" && "failed"].filter(Boolean).join(", ");
}
