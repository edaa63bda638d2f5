"""Whole missions that something befalls, from the operator's sentence to the simulated truth.

`python -m benchmarks.recoveries` prints the rates of all cases over seeds.
"""

from app.planning.pool.pool import PlanningWorker
from benchmarks.recoveries.cases import cases
from benchmarks.recoveries.trial import Outcome, Trial


def befalls(name: str, worker: PlanningWorker) -> Outcome:
    """What becomes of the mission. Nothing is called done that is not, nothing false believed, nobody left at work."""
    (case,) = [case for case in cases() if str(case) == name]
    outcome = Trial(case, seed=1).run(worker)
    assert outcome.took_s is not None, "nothing befell"
    assert outcome.how in ("came true", "ended"), outcome
    assert (outcome.beliefs, outcome.unsafe) == ([], []), outcome
    return outcome


def test_a_sample_that_was_taken_away_is_not_believed_where_it_was(worker: PlanningWorker) -> None:
    outcome = befalls("sample taken away, NAVIGATE of yard", worker)
    assert outcome.how == "ended"
    assert "does not see sample_1" in outcome.reason
    assert "it is not known where sample_1 is" in outcome.reason


def test_another_robot_takes_over_from_one_whose_jaws_do_not_close(worker: PlanningWorker) -> None:
    outcome = befalls("jaws do not close, NAVIGATE of yard", worker)
    assert outcome.how == "came true"
    assert outcome.measures == ["retry approved", "replan approved"]


def test_another_robot_takes_over_from_one_that_was_switched_off_and_declared_lost(
    worker: PlanningWorker,
) -> None:
    outcome = befalls("switched off, NAVIGATE of yard", worker)
    assert outcome.how == "came true"
    assert (len(outcome.lost), outcome.measures) == (1, ["replan approved"])


def test_a_mission_goes_on_from_where_its_robot_has_stopped_between_two_places(
    worker: PlanningWorker,
) -> None:
    outcome = befalls("infra-red dead 30 s, TRANSPORT_UP of yard", worker)
    assert outcome.how == "came true"
    assert {*outcome.measures} <= {"repair approved", "retry approved"}
