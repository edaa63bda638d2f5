// How likely a plan keeps its deadlines.

import { el } from "../page/dom.js";
import { percent } from "./percent.js";

/**
 * How likely all deadlines are kept: of a plan that waits for a decision, if it starts now.
 * @param {Plan} plan @param {PlanForecast} forecast @param {number | undefined} now by the world's clock
 */
export function chance({ state }, forecast, now) {
  const isOpen = state === "proposed" && typeof now === "number";
  const share = isOpen ? probabilityUpTo(forecast, forecast.made_at_s - now) : (forecast.on_time ?? 1);
  return el("p", { class: share < 0.5 ? "problem" : "small", "data-testid": "on-time" }, `${percent(share)} likely on time${isOpen ? " if it starts now" : ""}`);
}

/** The probability of at most so much lateness, linear between the quantiles. @param {PlanForecast} forecast @param {number} late_s */
function probabilityUpTo({ lateness_quantiles_s: quantiles, probabilities }, late_s) {
  const above = quantiles.findIndex((value) => value > late_s);
  if (above <= 0) return above === 0 ? 0 : 1;
  const part = (late_s - quantiles[above - 1]) / (quantiles[above] - quantiles[above - 1]);
  return probabilities[above - 1] + part * (probabilities[above] - probabilities[above - 1]);
}
