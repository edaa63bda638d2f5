"""Whole missions through doors, hatches and lifts, from the operator's sentence to the simulated truth.

`python -m benchmarks.peripherals` prints the rates of all cases over seeds.
"""

from app.planning.pool.pool import PlanningWorker
from benchmarks.peripherals.trial import CASES, Outcome, Trial


def outcome_of(name: str, worker: PlanningWorker) -> Outcome:
    (case,) = [case for case in CASES if str(case) == name]
    outcome = Trial(case, seed=1).run(worker)
    assert outcome.left_open == [], outcome
    return outcome


def test_a_sample_goes_through_a_hatch_and_a_gate_and_up_a_lift(worker: PlanningWorker) -> None:
    outcome = outcome_of("nothing fails, hatch, gate and lift", worker)
    assert outcome.how == "came true", outcome
    assert {"hatch_1", "lift_1"} < set(outcome.ways)


def test_a_mission_takes_another_gate_and_the_one_that_does_not_open_is_out_of_service(
    worker: PlanningWorker,
) -> None:
    outcome = outcome_of("gate jams", worker)
    assert outcome.how == "came true", outcome
    assert (outcome.ways, outcome.out_of_service) == (["gate_2"], ["gate_1"])


def test_a_mission_without_another_way_ends_and_says_what_does_not_open(worker: PlanningWorker) -> None:
    outcome = outcome_of("hatch jams", worker)
    assert outcome.how == "ended", outcome
    assert "hatch_1: OPEN its motor does not move" in outcome.reason
