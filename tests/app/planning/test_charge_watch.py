"""Robots without a home that are low on battery are charged by goals that the service states by itself."""

import time
from collections.abc import Callable
from typing import Any, cast

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import event

from app.composition import Service
from app.core import Core
from app.domain.errors import Busy
from app.missions.world_start import start_world_run
from app.planning.charge_watch import AGAIN_AFTER_S, MARGIN, STATED_BY, ChargeWatch, charging_range
from app.store import Database
from app.store.editions import WorldDirectory
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.known_empty import KNOWN_FOR_S
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from planner import load_knowledge_base
from planner.engines.replenishment import ReplenishingEngine
from robots.world import WorldFile, load_world
from tests.app.fake_robots import FakeTeam
from tests.app.planning.store_engine import StoreEngine
from tests.app.planning.test_holds import approve, state
from tests.app.scripted import InProcessWorker
from tests.app.stepped_clock import SteppedClock
from tests.databases import ON_BOTH
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
WORLD = "/v1/worlds/sample_store"
ENOUGH, LOW, TOO_FAR, STRANDED = 0.31, 0.29, 0.201, 0.15
"""Batteries: that need no charge, that need one, with which the charger is too far, and to take on no script."""
FEW = 4
"""Statements to the database: a transaction's own, the world's counters, and its numbers if they have changed."""


@pytest.fixture
def worker() -> InProcessWorker:
    return InProcessWorker(ReplenishingEngine(StoreEngine(), load_knowledge_base()))


@pytest.fixture
def world_file(request: pytest.FixtureRequest) -> WorldFile:
    """The sample store, with a charger in the yard in place of yard_1's home, and, if asked for, of yard_2's."""
    data = load_world("sample_store").model_dump(mode="json")
    for number in range(getattr(request, "param", 1)):
        charger = {"name": f"charger_{number + 1}", "kind": "charger", "at": [4.0 - number, 1.8]}
        data["locations"].append(charger | {"approach_deg": [0, 180], "capacity": 0})
        data["robots"][number] |= {"home": None, "battery_wh": 2.0}
    return WorldFile.model_validate(data)


def tell(api: TestClient, level: float, robot: str = "yard_1") -> None:
    """Have a robot's battery believed to be at this level."""
    number = {"quantity": "battery", "args": [robot], "value": level}
    api.put(f"{WORLD}/numbers", json={"numbers": [number]}).raise_for_status()


def goals(api: TestClient) -> list[dict[str, Any]]:
    """Newest first."""
    found: list[dict[str, Any]] = api.get("/v1/goals").raise_for_status().json()["items"]
    return found


def stated(api: TestClient, follow: Follow, *states: str) -> dict[str, Any]:
    """The only goal, once it is in one of these states."""
    until(lambda: goals(api))
    (goal,) = goals(api)
    return follow(f"/v1/goals/{goal['id']}", *states)


def looked(service: Service, world: WorldFile, api: TestClient, later_s: float = 0.0) -> int:
    """The number of goals once a process has looked that has just started, so many seconds from now."""
    ChargeWatch(
        service.core,
        worlds=WorldDirectory(service.database, {world.name: world}),
        goals=service.goals,
        low_battery=0.2,
        wall_clock=SteppedClock(epoch_s=time.time() + later_s),
    ).follow(world.name)
    return len(goals(api))


def test_robots_are_charged_while_they_take_on_scripts_and_plans_have_something_left_for_the_way() -> None:
    base = load_knowledge_base()
    assert charging_range(base, 0.1) == (0.2, pytest.approx(0.2 + MARGIN))
    assert charging_range(base, 0.4) == (0.4, pytest.approx(0.4 + MARGIN))


@ON_BOTH
def test_an_idle_robot_without_a_home_is_charged_by_a_goal_that_is_stated_and_approved_once(
    api: TestClient, service: Service, world_file: WorldFile, follow: Follow, team: FakeTeam
) -> None:
    for level in (ENOUGH, STRANDED):
        tell(api, level)
        assert looked(service, world_file, api) == 0
    tell(api, LOW)
    goal = stated(api, follow, "finished")
    assert (goal["text"], goal["created_by"], goal["auto_approve"]) == ("charge yard_1", STATED_BY, True)
    assert goal["goal"] == [{"predicate": "charged", "args": ["yard_1", "charger_1"]}]
    assert goal["outcome"] == "completed"
    assert [deed[0] for deed in team.robots["yard_1"].deeds] == ["NAVIGATE", "RECHARGE"]
    assert looked(service, world_file, api, AGAIN_AFTER_S - 10) == 1, "its battery may not have been told yet"
    assert looked(service, world_file, api, AGAIN_AFTER_S + 60) == 2


def test_robots_with_a_home_and_those_out_of_service_or_lost_are_left_alone(
    api: TestClient, service: Service, world_file: WorldFile, follow: Follow
) -> None:
    tell(api, LOW, "yard_2")
    assert looked(service, world_file, api) == 0
    for leave, come_back, why in (
        ("take_out_of_service", "bring_back", {"reason": "a wheel"}),
        ("declare_lost", "declare_found", {}),
    ):
        api.post(f"/v1/robots/yard_1:{leave}", json=why).raise_for_status()
        tell(api, LOW)
        assert looked(service, world_file, api) == 0
        tell(api, ENOUGH)
        api.post(f"/v1/robots/yard_1:{come_back}", json={}).raise_for_status()
    tell(api, LOW)
    stated(api, follow, "finished")


def test_a_robot_that_a_mission_uses_is_charged_once_it_is_idle(
    api: TestClient, service: Service, world_file: WorldFile, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("yard_1")
    other = state(api, "move sample_1 to interchange_1")
    mission = approve(api, follow(f"/v1/goals/{other['id']}", "planned")["plan_id"])
    tell(api, LOW)
    assert looked(service, world_file, api) == 1
    team.faults.stuck.clear()
    follow(f"/v1/missions/{mission}", "completed")
    tell(api, LOW - 0.01)
    until(lambda: len(goals(api)) == 2)
    assert goals(api)[0]["created_by"] == STATED_BY


def test_an_operators_goal_for_the_same_is_enough(
    api: TestClient, service: Service, world_file: WorldFile, follow: Follow
) -> None:
    goal = state(api, "charge yard_1")
    follow(f"/v1/goals/{goal['id']}", "planned")
    tell(api, LOW)
    assert looked(service, world_file, api) == 1


@ON_BOTH
def test_a_goal_waits_for_the_charger_is_not_stated_twice_and_once_withdrawn_only_later(
    api: TestClient, service: Service, world_file: WorldFile, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("yard_2")
    other = state(api, "charge yard_2 at charger_1")
    mission = approve(api, follow(f"/v1/goals/{other['id']}", "planned")["plan_id"])
    tell(api, LOW)
    until(lambda: len(goals(api)) == 2)
    goal = follow(f"/v1/goals/{goals(api)[0]['id']}", "waiting")
    assert goal["reason"].startswith(f"waits for mission {mission}, which uses charger_1")
    assert looked(service, world_file, api, 10 * AGAIN_AFTER_S) == 2
    api.post(f"/v1/goals/{goal['id']}:cancel", json={}).raise_for_status()
    assert looked(service, world_file, api, AGAIN_AFTER_S - 10) == 2
    assert looked(service, world_file, api, AGAIN_AFTER_S + 60) == 3


@pytest.mark.parametrize("world_file", [2], indirect=True)
def test_robots_that_are_low_together_are_charged_at_chargers_of_their_own(
    api: TestClient, world_file: WorldFile, team: FakeTeam
) -> None:
    robots = [robot.name for robot in world_file.robots if robot.home is None]
    team.faults.stuck.update(robots)
    numbers = [{"quantity": "battery", "args": [robot], "value": LOW} for robot in robots]
    api.put(f"{WORLD}/numbers", json={"numbers": numbers}).raise_for_status()
    until(lambda: [goal["state"] for goal in goals(api)] == ["committed"] * 2)
    charged = sorted(goal["goal"][0]["args"] for goal in goals(api))
    assert charged == [["yard_1", "charger_1"], ["yard_2", "charger_2"]]


def test_after_a_goal_without_a_plan_the_next_is_stated_only_later(
    api: TestClient, service: Service, world_file: WorldFile, follow: Follow
) -> None:
    tell(api, TOO_FAR)
    goal = stated(api, follow, "unsolvable")
    assert "yard_1's battery is at" in goal["reason"]
    assert looked(service, world_file, api, AGAIN_AFTER_S - 10) == 1
    assert looked(service, world_file, api, AGAIN_AFTER_S + 60) == 2


def test_only_the_process_that_holds_the_worlds_lease_states_goals(
    api: TestClient, service: Service, follow: Follow, monkeypatch: pytest.MonkeyPatch
) -> None:
    turns: list[str] = []

    def is_anothers(world: str) -> bool:
        turns.append(world)
        return False

    monkeypatch.setattr(service.executors, "holds_lease", is_anothers)
    until(lambda: len(turns) > 2)  # the turn that had asked before is over
    tell(api, LOW)
    turns.clear()
    until(lambda: len(turns) > 10)
    assert goals(api) == []
    monkeypatch.undo()
    stated(api, follow, "finished")


class Refusing:
    """Takes no goal."""

    def __init__(self) -> None:
        self.asked = 0

    def submit(self, *_: object, **__: object) -> None:
        self.asked += 1
        raise Busy("too many goals are open", code="too-many-goals")


class Watched:
    """A record without a service, its watch, and the statements that the database is sent."""

    def __init__(self, database: Database, world: WorldFile) -> None:
        base = load_knowledge_base()
        events = EventLog(database)
        plan_nets = PlanNets(base)
        core = Core(
            database=database,
            events=events,
            facts=FactStore(events, base),
            workflows=cast("Any", None),
            knowledge_base=base,
            plan_nets=plan_nets,
            reservations=Reservations(plan_nets),
        )
        with database.write() as session:
            start_world_run(session, core, world, "run")
        self._database = database
        self._numbers = core.facts.numbers
        self.clock = SteppedClock()
        self.goals = Refusing()
        self.watch = ChargeWatch(
            core,
            worlds=WorldDirectory(database, {world.name: world}),
            goals=cast("Any", self.goals),
            low_battery=0.2,
            wall_clock=self.clock,
        )
        self.statements: list[str] = []
        event.listen(
            database.engine, "before_cursor_execute", lambda *args: self.statements.append(str(args[2]))
        )

    def tell(self, level: float) -> None:
        with self._database.write() as session:
            numbers = {("battery", ("yard_1",)): level}
            self._numbers.set(session, "sample_store", numbers, source="test", at_s=0.0)
        self.statements.clear()

    def follow(self) -> int:
        """The number of statements that a call takes."""
        self.statements.clear()
        self.watch.follow("sample_store")
        return len(self.statements)


def test_a_goal_that_is_refused_is_tried_again_only_later(database: Database, world_file: WorldFile) -> None:
    watched = Watched(database, world_file)
    watched.tell(LOW)
    for _ in range(3):
        watched.follow()
        watched.tell(LOW - 0.01)
    assert watched.goals.asked == 1
    watched.clock.advance(AGAIN_AFTER_S + 1)
    watched.follow()
    assert watched.goals.asked == 2


def test_looking_costs_nothing_where_all_have_homes_and_else_a_few_statements_after_a_change_or_a_while(
    database: Database, world_file: WorldFile
) -> None:
    assert Watched(database, load_world("sample_store")).follow() == 0
    watched = Watched(database, world_file)
    for news in (lambda: watched.tell(ENOUGH), lambda: watched.clock.advance(KNOWN_FOR_S + 1)):
        news()
        assert 0 < watched.follow() <= FEW
        assert [watched.follow() for _ in range(3)] == [0, 0, 0]
