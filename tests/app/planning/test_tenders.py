"""Robots bid for the legs of a goal's first plan; it is planned with the cheapest bidders, who are then awarded."""

from collections.abc import Callable, Iterator

import pytest
from sqlalchemy import Engine, event

from app.agents.speech import end_with_robots
from app.domain.tender_document import BidState, LegBody
from app.store import ConversationRow, EventRow, GoalRow, MissionRow, WorldRow
from planner import UNOBSERVED, Observer, PlanningProblem, PlanningRequest, PlanningResult
from robots.executive.executive import Executive
from robots.social import parse_term
from robots.world import WorldFile
from tests.app.missions.mission_services import WORLD
from tests.app.planning.store_engine import StoreEngine
from tests.app.planning.tendering import GOAL, Tendering
from tests.databases import ON_POSTGRESQL

NEXT = "goal-2"
STORED = "in(sample_1, bay_7)"
EVERYONE = ("yard_1", "yard_2", "store_1", "store_2")
Tender = Callable[[WorldFile], Tendering]


@pytest.fixture
def among(database_url: str) -> Iterator[Tender]:
    """A tendering among the robots of a world."""
    made: list[Tendering] = []

    def make(world: WorldFile) -> Tendering:
        made.append(Tendering(database_url, world))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.fixture
def tendering(among: Tender, world_file: WorldFile) -> Tendering:
    return among(world_file)


def changed(world: WorldFile, name: str, **changes: object) -> WorldFile:
    robots = [one.model_copy(update=changes) if one.name == name else one for one in world.robots]
    return world.model_copy(update={"robots": tuple(robots)})


def states(leg: LegBody) -> dict[str, BidState]:
    return {bid.robot: bid.state for bid in leg.parts[0].bids}


def told(tendering: Tendering, performative: str) -> list[str]:
    return sorted(robot for robot, said in tendering.heard.values() if said == performative)


def accepted(row: ConversationRow) -> str:
    """The award that was said in a conversation."""
    return next(str(one["content"]) for one in row.said if one["performative"] == "accept-proposal")


def outcomes(tendering: Tendering, mission: str) -> dict[str, str]:
    return {row.robot: row.state for row in tendering.conversations(about=mission)}


def robots_of_plan(tendering: Tendering) -> list[str]:
    plan_id = tendering.goal().plan_id
    assert plan_id is not None
    robots: list[str] = tendering.services.plans.get(plan_id).body["robots"]
    return robots


def test_a_goal_is_planned_with_the_robots_whose_bids_are_cheapest(tendering: Tendering) -> None:
    goal = tendering.submit(STORED)
    assert (goal.state, goal.reason) == ("planning", "robots are called for proposals")
    tendering.run(1.0)
    assert tendering.services.plan_once(GOAL).state == "planned"
    yard, store = tendering.tender.legs
    assert states(yard) == {
        "yard_1": BidState.OFFERED,
        "yard_2": BidState.OFFERED,
        "store_1": BidState.DECLINED,
        "store_2": BidState.DECLINED,
    }
    assert (yard.team, store.team, store.is_planned) == (("yard_1",), ("store_2",), True)
    assert yard.why.startswith("yard_1 asks 30 s, the next best, yard_2, 3")
    assert "bay_7 is not a place that yard_1 knows" in store.parts[0].bids[0].reason
    plan = tendering.services.plans.get(tendering.goal().plan_id or "").body
    assert [leg["team"] for leg in plan["tender"]["legs"]] == [["yard_1"], ["store_2"]]


def test_a_robots_own_state_decides_where_planning_alone_would_not_know(
    among: Tender, world_file: WorldFile
) -> None:
    low = among(changed(world_file, "yard_1", battery=0.1))
    low.plan(STORED)
    assert robots_of_plan(low) == ["store_2", "yard_2"]
    yard = low.tender.legs[0]
    assert (states(yard)["yard_1"], yard.team) == (BidState.DECLINED, ("yard_2",))
    assert "battery at 10%" in yard.parts[0].bids[0].reason
    assert "yard_1" in [part.robot for part in yard.parts], "planning alone has yard_1 do it"


def test_a_goal_is_planned_centrally_if_no_robot_answers_in_time(tendering: Tendering) -> None:
    tendering.plan(STORED, deaf=EVERYONE)
    assert tendering.goal().state == "planning"
    tendering.run(20.0, deaf=EVERYONE)
    goal = tendering.services.plan_once(GOAL)
    assert goal.state == "planned"
    assert tendering.tender.state == "central"
    assert tendering.tender.reason == "no robot has answered the calls in time"
    assert states(tendering.tender.legs[0])["yard_1"] == BidState.SILENT
    tendering.approve()
    assert {row.state for row in tendering.conversations()} == {"timed_out"}


def test_a_robot_that_leaves_the_world_holds_up_no_goal(tendering: Tendering) -> None:
    tendering.plan(STORED, deaf=("yard_2",))
    assert tendering.goal().state == "planning"
    awaited = [row.reply_by_s for row in tendering.conversations()]
    with tendering.services.database.write() as session:
        end_with_robots(session, "another_world", [])
    assert [row.reply_by_s for row in tendering.conversations()] == awaited
    with tendering.services.database.write() as session:
        end_with_robots(session, WORLD, [name for name in EVERYONE if name != "yard_2"])
    tendering.run(0.5, deaf=("yard_2",))
    assert tendering.services.plan_once(GOAL).state == "planned"


def test_legs_that_are_too_long_for_a_call_are_planned_centrally(
    tendering: Tendering, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.planning.leg_calls.MAX_CONTENT", 40)
    tendering.submit(STORED)
    goal = tendering.services.plan_once(GOAL)
    assert (goal.state, tendering.tender.state) == ("planned", "central")
    assert "too long for a call" in tendering.tender.reason


class Overtaken(StoreEngine):
    """While it plans for the first time, another process plans the same goal."""

    def __init__(self, meanwhile: Callable[[], object]) -> None:
        super().__init__()
        self._meanwhile: Callable[[], object] | None = meanwhile

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        meanwhile, self._meanwhile = self._meanwhile, None
        if meanwhile is not None:
            meanwhile()
        return super().plan(problem, request, observer)


def test_a_first_plan_that_comes_late_is_not_taken_for_the_second(
    database_url: str, world_file: WorldFile
) -> None:
    tendering: Tendering = Tendering(
        database_url, world_file, engine=Overtaken(lambda: tendering.services.plan_once(GOAL))
    )
    tendering.submit(STORED)
    assert (tendering.goal().state, tendering.tender.state) == ("planning", "called")
    tendering.close()


def test_a_silent_robot_may_still_be_recruited_where_nobody_bids(tendering: Tendering) -> None:
    tendering.plan(STORED, deaf=("store_2",))
    tendering.run(20.0, deaf=("store_2",))
    tendering.services.plan_once(GOAL)
    _, store = tendering.tender.legs
    assert (store.team, states(store)["store_2"]) == ((), BidState.SILENT)
    assert robots_of_plan(tendering) == ["store_2", "yard_1"]


def test_a_goal_whose_leg_all_decline_waits_until_one_can_do_it(among: Tender, world_file: WorldFile) -> None:
    tendering = among(changed(world_file, "store_2", battery=0.1))
    tendering.plan(STORED)
    goal = tendering.services.plan_once(GOAL)
    assert goal.state == "waiting"
    assert goal.reason.startswith("waits for store_2, which declines leg_2: battery at 10%")
    assert goal.waits_for["until_s"] == 60.0, "then all are called again"  # type: ignore[index]
    tendering.run(0.5)
    assert {row.state for row in tendering.conversations()} <= {"rejected", "refused"}
    tendering.simulation.bodies["store_2"].battery.left_j *= 9
    tendering.services.plan_once(GOAL)
    tendering.run(1.0)
    assert tendering.services.plan_once(GOAL).state == "planned"


@pytest.fixture
def busy(among: Tender, world_file: WorldFile) -> Tendering:
    """A goal is stated while yard_1 carries out a mission; yard_2 would have to charge after another."""
    tendering = at_work(among, world_file)
    state_next(tendering)
    assert tendering.goal(NEXT).state == "waiting"
    return tendering


def at_work(among: Tender, world_file: WorldFile) -> Tendering:
    world = changed(world_file, "yard_2", battery=0.2).model_dump()
    at_door = {"name": "sample_2", "at": "door_2"}
    world["samples"] = [at_door if one["name"] == "sample_2" else one for one in world["samples"]]
    tendering = among(WorldFile.model_validate(world))
    tendering.plan("in(sample_1, interchange_2)")
    tendering.give(tendering.services.scripts(tendering.approve()))
    tendering.run(20.0)
    return tendering


def state_next(tendering: Tendering, **more: object) -> GoalRow:
    """State a goal and have robots called for it; the goal."""
    tendering.submit("in(sample_2, interchange_1)", id=NEXT, **more)
    tendering.run(1.0)
    return tendering.services.plan_once(NEXT)


def plan_next(tendering: Tendering) -> GoalRow:
    """Have robots called for the waiting goal again; the goal."""
    assert tendering.services.plan_once(NEXT).state == "planning"
    tendering.run(1.0)
    return tendering.services.plan_once(NEXT)


def team_of_next(tendering: Tendering) -> tuple[str, ...]:
    plan = tendering.services.plans.get(tendering.goal(NEXT).plan_id or "").body
    return tuple(plan["tender"]["legs"][0]["team"])


def releases(tendering: Tendering) -> int:
    tendering.services.waiting.handle_availability(WORLD)
    return tendering.services.read(lambda session: session.get_one(WorldRow, WORLD).releases)  # type: ignore[no-any-return]


def test_a_goal_waits_for_a_busy_robot_that_bids_less_than_those_that_are_free(busy: Tendering) -> None:
    goal = busy.goal(NEXT)
    assert goal.reason.startswith("waits for mission mission-")
    assert goal.reason.endswith("yard_1: yard_1 asks 44 s, robots that are free ask 382 s")
    busy.run(40.0)
    assert {row.state for row in busy.conversations(about=NEXT)} == {"rejected", "refused"}
    with busy.services.database.write() as session:
        session.query(MissionRow).one().state = "completed"
    assert plan_next(busy).state == "planned"
    assert team_of_next(busy) == ("yard_1",)


def test_a_goal_whose_busy_robot_is_not_free_in_time_is_planned_without_it(busy: Tendering) -> None:
    before = releases(busy)
    busy.clock.advance(29.0)
    busy.wall_clock.advance(60.0)
    assert releases(busy) == before
    assert plan_next(busy).state == "waiting", "another release does not end the wait"
    busy.clock.advance(2.0)
    busy.wall_clock.advance(60.0)
    assert releases(busy) == before + 1
    assert releases(busy) == before + 1, "it is looked at again after some time only"
    assert plan_next(busy).state == "planned"
    assert team_of_next(busy) == ("yard_2",)


def waits_until_s(tendering: Tendering) -> float:
    return tendering.goal(NEXT).waits_for["until_s"]  # type: ignore[no-any-return,index]


def test_a_goal_waits_no_longer_than_its_deadline_allows(among: Tender, world_file: WorldFile) -> None:
    tendering = at_work(among, world_file)
    assert state_next(tendering, deadline_s=50.0, deadline_at_s=50.0).state == "waiting"
    makespan_s = tendering.goal(NEXT).tender["makespan_s"]  # type: ignore[index]
    assert 30.0 < makespan_s < 40.0
    assert waits_until_s(tendering) == pytest.approx(50.0 - makespan_s)
    tendering.clock.advance(waits_until_s(tendering))
    assert plan_next(tendering).state == "planned"
    assert team_of_next(tendering) == ("yard_2",)


def test_a_goal_that_would_miss_its_deadline_does_not_wait(among: Tender, world_file: WorldFile) -> None:
    tendering = at_work(among, world_file)
    assert state_next(tendering, deadline_s=40.0, deadline_at_s=40.0).state == "planned"
    assert team_of_next(tendering) == ("yard_2",)


def test_a_new_run_of_the_world_forgets_until_when_a_goal_waits(busy: Tendering) -> None:
    assert waits_until_s(busy) == 30.0
    busy.services.start_world("run-2")
    goal = busy.goal(NEXT)
    assert (goal.state, goal.tender) == ("waiting", None)


def test_robots_that_a_goal_waited_for_before_do_not_prolong_its_wait(busy: Tendering) -> None:
    with busy.services.database.write() as session:
        goal = session.get_one(GoalRow, NEXT)
        assert goal.tender is not None
        goal.tender = {**goal.tender, "waits_until_s": {"store_1": 90000.0}}
    assert plan_next(busy).state == "waiting"
    assert waits_until_s(busy) == 30.0


@ON_POSTGRESQL
def test_bids_are_rejected_with_the_world_locked_before_the_conversations(tendering: Tendering) -> None:
    tendering.submit(STORED)
    tendering.run(1.0)
    locked: list[str] = []

    def note(_connection: object, _cursor: object, statement: str, *_: object) -> None:
        if "FOR UPDATE" in statement:
            locked.extend(table for table in ("FROM worlds", "FROM conversations") if table in statement)

    event.listen(Engine, "before_cursor_execute", note)
    with tendering.services.database.write() as session:
        assert tendering.services.tenders is not None
        tendering.services.tenders.release(session, session.get_one(GoalRow, GOAL))
    event.remove(Engine, "before_cursor_execute", note)
    assert locked[0] == "FROM worlds"
    assert "FROM conversations" in locked


def test_a_goal_whose_leg_no_robot_is_able_to_do_has_no_plan(
    among: Tender, world_file: WorldFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Executive, "why_unable", lambda *_: "it has no gripper")
    tendering = among(world_file)
    tendering.plan(STORED)
    goal = tendering.services.plan_once(GOAL)
    assert goal.state == "unsolvable"
    assert "store_2 declines leg_2: it has no gripper" in goal.reason


def test_robots_that_are_not_called_are_planned_centrally(among: Tender, world_file: WorldFile) -> None:
    mute = world_file
    for name in EVERYONE:
        mute = changed(mute, name, speaks=())
    tendering = among(mute)
    tendering.submit(STORED)
    assert tendering.services.plan_once(GOAL).state == "planned"
    assert tendering.tender.reason == "no robot of the world takes calls"


def test_approval_awards_the_winners_their_scripts_and_rejects_the_others(tendering: Tendering) -> None:
    tendering.plan(STORED)
    mission = tendering.approve()
    tendering.run(1.0)
    assert told(tendering, "accept-proposal") == ["store_2", "yard_1"]
    assert told(tendering, "reject-proposal") == ["yard_2"]
    assert outcomes(tendering, mission) == {"yard_1": "awarded", "store_2": "awarded"}
    scripts = {row.robot: parse_term(accepted(row)).words for row in tendering.conversations(about=mission)}
    assert scripts == {
        "yard_1": ("leg_1", f"{mission}-yard_1"),
        "store_2": ("leg_2", f"{mission}-store_2"),
    }


def test_a_robot_whose_last_word_was_lost_is_asked_for_it_at_the_missions_end(tendering: Tendering) -> None:
    tendering.plan(STORED)
    mission = tendering.approve()
    tendering.give([row for row in tendering.services.scripts(mission) if row.robot == "yard_1"])
    tendering.run(40.0, mute=("yard_1",))
    assert outcomes(tendering, mission) == {"yard_1": "awarded", "store_2": "awarded"}
    with tendering.services.database.write() as session:
        assert tendering.services.tenders is not None
        tendering.services.tenders.settle(session, session.get_one(MissionRow, mission))
    tendering.run(1.0)
    assert outcomes(tendering, mission) == {"yard_1": "done", "store_2": "awarded"}
    tendering.run(20.0)
    assert outcomes(tendering, mission)["store_2"] == "timed_out"


def test_a_plan_that_asks_for_too_many_calls_is_not_put_to_tender(
    tendering: Tendering, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.planning.tenders.MOST_CALLS", 7)
    tendering.submit(STORED)
    assert tendering.services.plan_once(GOAL).state == "planned"
    assert tendering.tender.reason == "its legs would take 8 calls, of which 7 are made at most"
    assert tendering.conversations() == []


def test_a_rejected_plan_and_a_cancelled_goal_reject_the_bids(tendering: Tendering) -> None:
    tendering.plan(STORED)
    tendering.services.plans.reject(tendering.goal().plan_id or "", actor="operator")
    tendering.run(0.5)
    assert told(tendering, "reject-proposal") == ["store_2", "yard_1", "yard_2"]


@pytest.mark.parametrize("after", ["call", "answers", "planning", "approval"])
def test_a_restart_of_the_service_loses_nothing(tendering: Tendering, after: str) -> None:
    tendering.submit(STORED)
    if after == "call":
        tendering.restart()
        assert tendering.services.plan_once(GOAL).state == "planning", "the recovered job finds nothing to do"
    tendering.run(1.0)
    if after == "answers":
        tendering.restart()
    tendering.services.plan_once(GOAL)
    if after == "planning":
        tendering.restart()
    assert tendering.goal().state == "planned"
    mission = tendering.approve()
    if after == "approval":
        tendering.restart()
    tendering.run(1.0)
    assert told(tendering, "reject-proposal") == ["yard_2"]
    assert {row.state for row in tendering.conversations(about=mission)} == {"awarded"}
    assert told(tendering, "cfp") == sorted([*EVERYONE, *EVERYONE])


def test_who_was_called_is_in_the_event_log(tendering: Tendering) -> None:
    tendering.submit(STORED)
    (event,) = tendering.services.read(
        lambda session: session.query(EventRow).filter_by(type="goal.bids_called").all()
    )
    assert (event.subject, event.data["robots"], event.data["legs"]) == (
        GOAL,
        list(EVERYONE),
        ["leg_1", "leg_2"],
    )
