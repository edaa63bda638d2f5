"""Missions under a poor radio, from goal to simulated truth: robots go on alone and report later (MACTA §4)."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.composition import make_engine
from app.plans.worker import PlanningWorker
from app.states import MissionState
from benchmarks.errands import with_sample
from benchmarks.radio import Ended, IsWorst, carry_out, finishes, sends, with_link
from robots.world import LinkSpec, load_world
from sim.radio import Way
from tests.app.scripted import ScriptedWorker
from tests.app.store import Store


@pytest.fixture(scope="module")
def worker() -> Iterator[PlanningWorker]:
    worker = PlanningWorker(make_engine)
    worker.warm_up().result(timeout=300)
    yield worker
    worker.close()


def assert_well_ended(ended: Ended) -> None:
    """True in the world, known to be, nothing done twice, and the sample believed in one place alone."""
    assert ended.state is MissionState.COMPLETED, ended
    assert ended.came_true
    assert ended.twice == []
    assert [fact for fact in ended.facts if fact.startswith("in(sample_1, ")] == ["in(sample_1, bay_7)"]


@pytest.mark.parametrize(
    ("link", "seed"),
    [
        ({"loss": 0.5, "delay_s": 0.5, "jitter_s": 2.0, "duplication": 0.3}, 1),
        ({"light_time_s": 5.0}, 0),
    ],
    ids=["half lost", "light-time"],
)
def test_a_mission_comes_true_under_a_poor_radio(
    link: dict[str, Any], seed: int, worker: PlanningWorker, tmp_path: Path
) -> None:
    assert_well_ended(carry_out(with_link(link), worker, tmp_path, seed=seed))


@pytest.mark.parametrize(
    "worst",
    [sends("script_request"), finishes, sends("script_report")],
    ids=["a script", "a packet's end", "a script's end"],
)
def test_20_s_without_radio_from_the_worst_instant_on_change_nothing_but_the_time(
    worst: IsWorst, worker: PlanningWorker, tmp_path: Path
) -> None:
    assert_well_ended(carry_out(with_link({}), worker, tmp_path, worst=worst))


def test_a_clearance_that_is_due_in_an_outage_is_given_after_it(tmp_path: Path) -> None:
    store = Store(with_sample(load_world("sample_store"), "sample_2", "door_2", vacant="bay_3"))
    goal = "move sample_1 to bay_1 and sample_2 to bay_3"
    worker: Any = ScriptedWorker(store.one_interchange_twice())
    ended = carry_out(store.world, worker, tmp_path, seed=1, goal=goal, worst=sends("clearance"))
    assert (ended.state, ended.came_true, ended.twice) == (MissionState.COMPLETED, True, []), ended


def test_in_short_windows_of_contact_alone_a_mission_comes_true_with_few_letters(
    worker: PlanningWorker, tmp_path: Path
) -> None:
    """Out of contact but for 10 s in 120, a mission of 52 s takes minutes; the letters do not grow with them."""
    link = LinkSpec.model_validate({"contacts": [{"start_s": 3, "for_s": 10, "every_s": 120}]})
    ended = carry_out(with_link(link.model_dump()), worker, tmp_path)
    assert_well_ended(ended)
    assert ended.letters[Way.DOWN] + ended.letters[Way.UP] < 2.0 * ended.took_s
