// Formats probabilities.

/** A probability; only what is certain is 0 or 100 %. @param {number} chance */
export function percent(chance) {
  if (chance > 0 && chance < 0.005) return "< 1 %";
  return chance > 0.995 && chance < 1 ? "> 99 %" : `${Math.round(100 * chance)} %`;
}
