"""How long the engine improves a schedule where the request leaves it to the engine.

Counted in schedules tried, so that the same request gives the same plan on a machine of any speed; the seconds only
end what takes far too long.
"""

from planner.problem.interface import PlanningRequest

MAX_EFFORT_S = 4.0
UNLIMITED_TRIALS = 10**9
"""Trials where the request says how long."""
TRIALS = 40
TRIALS_A_LEG = 3
MAX_LEGS_DECODED = 3_500_000
MAX_TRIALS_INTERACTING = 40_000


def effort(request: PlanningRequest, legs: int, choices: int) -> tuple[int, float]:
    """The schedules to try, and the seconds after which to stop in any case.

    :param legs: of a schedule.
    :param choices: fragments to choose from where tasks interact, else 0.
    """
    if request.effort_s is not None:
        return UNLIMITED_TRIALS, request.effort_s
    if choices:
        return min(MAX_TRIALS_INTERACTING, TRIALS * legs * max(legs, choices)), MAX_EFFORT_S
    # By the square of the legs, of many by their cube, up to so many legs decoded.
    trials = legs**2 * max(TRIALS, TRIALS_A_LEG * legs)
    return min(trials, MAX_LEGS_DECODED // max(1, legs)), MAX_EFFORT_S
