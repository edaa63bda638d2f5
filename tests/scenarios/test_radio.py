"""Missions under a poor radio, from goal to simulated truth: robots go on alone and report later (MACTA §4)."""

import time
from collections import defaultdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from app.cli.ground_truth import snapshot_truth
from app.composition import Service
from app.domain.lifecycles.mission import MissionState
from app.planning.goal_service import GoalRequest
from app.planning.pool.pool import PlanningWorker
from benchmarks.errands import with_sample
from benchmarks.radio import Ended, IsWorst, carry_out, finishes, sends, with_link
from robots.world import LinkSpec, load_world
from sim.world.radio import Direction
from tests.app.sample_store import Store
from tests.app.scripted import ScriptedWorker
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.scenarios.services import over_broker
from tests.scenarios.serving import macta_fleet
from tests.waiting import awaited


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
    assert ended.letters[Direction.DOWN] + ended.letters[Direction.UP] < 2.0 * ended.took_s


class Operator:
    """Looks at a mission again and again: its state, what is said of it, which robots are silent for too long."""

    def __init__(self) -> None:
        self.states: list[str] = []
        self.reasons: list[str] = []
        self.silent: set[str] = set()

    def __call__(self, service: Service, mission_id: str) -> None:
        mission, _ = service.missions.get(mission_id)
        for known, said in ((self.states, mission.state), (self.reasons, mission.reason)):
            if known[-1:] != [said]:
                known.append(said)
        self.silent |= {report.view.name for report in service.robots.robots() if report.silent}


def test_a_robot_that_misses_its_windows_is_asked_makes_the_mission_unknown_and_is_back_on_contact(
    worker: PlanningWorker, tmp_path: Path
) -> None:
    """It goes on alone meanwhile: what it did is reported once there is contact again."""
    link = {"contacts": [{"for_s": 10, "every_s": 30}]}
    operator = Operator()
    ended = carry_out(
        with_link(link),
        worker,
        tmp_path,
        worst=lambda message: message.sender == "store_2" and message.body.kind == "packet_report",
        out_s=200.0,
        patience_s=1.0,
        meanwhile=operator,
    )
    assert_well_ended(ended)
    # From the record: what is said of the mission meanwhile changes with the next message of another robot.
    asked = [event["reason"] for event in ended.events if event["type"] == "mission.robots_asked"]
    assert "no message from store_2: asking store_2" in asked, "before the expected time is over"
    assert "no answer from store_2" in operator.reasons
    # Whether it is seen running once more depends on when the operator looks: all reports may come at once.
    assert set(operator.states[operator.states.index("unknown") + 1 :]) <= {"running", "completed"}
    assert operator.silent == {"store_2"}


def test_orders_to_pause_and_resume_that_overtake_each_other_leave_no_robot_paused(
    worker: PlanningWorker, tmp_path: Path
) -> None:
    left = [order for _ in range(6) for order in ("pause", "resume")]

    def hesitate(service: Service, mission_id: str) -> None:
        mission, _ = service.missions.get(mission_id)
        if left and mission.started_at_s is not None:
            getattr(service.missions, left.pop(0))(mission_id, "operator", "")

    link = {"jitter_s": 8.0, "duplication": 0.5}
    ended = carry_out(with_link(link), worker, tmp_path, meanwhile=hesitate)
    assert_well_ended(ended)
    assert left == []


POOR = "sample_store_radio"
GIVE_UP_S = 200.0


class Words:
    """When each robot was heard, in world seconds."""

    def __init__(self, service: Service) -> None:
        self._service = service
        self._heard_s: dict[str, list[float]] = defaultdict(list)

    def note(self) -> None:
        for name, view in self._service.board.views(POOR).items():
            if view.heard_s is not None and self._heard_s[name][-1:] != [view.heard_s]:
                self._heard_s[name].append(view.heard_s)

    def longest_silence_s(self, robot: str) -> float:
        return max(later - one for one, later in pairwise(self._heard_s[robot]))


def planned(service: Service, text: str) -> str:
    goal = service.goals.submit(GoalRequest(world=POOR, text=text), actor="test")
    found = awaited(lambda: service.goals.get(goal.id), lambda found: found.plan_id, GIVE_UP_S)
    assert found.plan_id is not None
    return found.plan_id


@needs_mosquitto
def test_behind_a_broker_the_radio_is_as_poor_and_a_mission_comes_true_as_well(
    worker: PlanningWorker, tmp_path: Path
) -> None:
    """By `macta fleet`; paused and resumed at once meanwhile, so that orders may overtake each other."""
    fleet = tmp_path / "fleet"
    with (
        mosquitto(tmp_path / "broker") as broker,
        over_broker(tmp_path / "service", worker, broker.url, world=POOR) as service,
        macta_fleet(fleet, "--world", POOR, "--broker", broker.url, "--speed", "20"),
    ):
        words = Words(service)
        _, mission_id = service.plans.approve(
            planned(service, "move sample_1 to bay_7"), actor="test", comment=""
        )
        left = ["pause", "resume", "pause", "resume"]
        give_up = time.monotonic() + GIVE_UP_S
        while not MissionState((mission := service.missions.get(mission_id)[0]).state).ended:
            assert time.monotonic() < give_up, (mission.state, mission.reason)
            if left and mission.started_at_s is not None:
                getattr(service.missions, left.pop(0))(mission_id, "test", "")
            words.note()
            time.sleep(0.02)
        words.note()  # the word that ends the mission may be the first that is heard after a silence
    assert (mission.state, mission.reason) == (MissionState.COMPLETED, "")
    assert snapshot_truth(fleet, load_world(POOR)).samples["sample_1"].ref == "bay_7"
    assert words.longest_silence_s("store_2") > 35.0, (
        "between its windows of contact it is not heard for 45 s"
    )
