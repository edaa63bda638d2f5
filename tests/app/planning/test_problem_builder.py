"""The planning problem of a goal: what was learned, what is urgent, who rests, what would never help."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.orm import Session

from app.domain.durations import PRIOR_SPREAD
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.plan_document import PlanBody
from app.domain.world_model import Reservation
from app.planning.problem_builder import GoalProblem
from app.store import Database, DurationRow, GoalRow, MissionRow, PlanRow
from app.store.migrate import migrate
from app.store.plan_nets import PlanNets
from app.store.reservations import MissionReservation, Reservations
from planner import Fact, PlanNet, PlanningProblem, PlanningRequest, scale_term
from planner.explanation.conflict import Restriction
from tests.app.planning.record import STORE, StoreRecord
from tests.app.planning.store_engine import StoreEngine
from tests.app.sample_store import said

STORED = STORE.fact("in(sample_1, bay_7)")


class StatedReservations(Reservations):
    """The reservations of missions that are not in the record."""

    def __init__(self, running: Sequence[MissionReservation]) -> None:
        super().__init__(PlanNets(STORE.base))
        self._running = running

    def of_world(self, session: Session, world: str) -> Sequence[MissionReservation]:
        return self._running


class StoreProblems:
    """Builds problems of the sample store from a record of its own."""

    def __init__(self, record: StoreRecord, session: Session) -> None:
        self._record = record
        self._session = session

    def knows(self, action: str, *, samples: int, mean: float) -> None:
        row = DurationRow(
            world="sample_store", action=action, team=1, samples=samples, mean=mean, variance=0.0
        )
        self._session.add(row)
        self._session.flush()

    def drives(self, robot: str, start: str, end: str) -> None:
        """Record that a robot of the yard has driven from one place to another."""
        self._record.core.facts.change(
            self._session,
            "sample_store",
            add=[STORE.fact(f"near({robot}, {end})"), STORE.fact(f"clear({start}, yard)")],
            remove=[STORE.fact(f"near({robot}, {start})"), STORE.fact(f"clear({end}, yard)")],
            source="test",
            at_s=1.0,
        )

    def carries_out(self, plan_net: PlanNet) -> str:
        """Record a mission with this plan; its id."""
        body = PlanBody.of_plan_net(plan_net, STORE.base).model_dump(mode="json")
        goal = GoalRow(id="goal-1", world="sample_store", text="", goal=[], priority=0, auto_approve=False)
        goal.state = GoalState.COMMITTED
        goal.created_by = "me"
        self._session.add(goal)
        self._session.flush()
        plan = PlanRow(
            id="plan-1",
            goal_id=goal.id,
            world=goal.world,
            state=PlanState.APPROVED,
            body=body,
            world_version=1,
        )
        self._session.add(plan)
        self._session.flush()
        mission = MissionRow(
            id="mission-1", workflow="mission-1", goal_id=goal.id, plan_id=plan.id, world=goal.world
        )
        mission.state = MissionState.RUNNING
        mission.estimate_s = mission.original_estimate_s = mission.margin_s = 10.0
        self._session.add(mission)
        self._session.flush()
        return mission.id

    def build(self, *texts: str, **more: Any) -> GoalProblem:
        built = self._record.problems.build(self._session, self._goal(*texts, **more))
        assert built.releases == 7
        return built

    def restricted(
        self, *texts: str, **more: Any
    ) -> tuple[GoalProblem, tuple[PlanningProblem, tuple[Restriction, ...]] | None]:
        """A goal's problem, and the one without its constraints with what these withhold."""
        goal = self._goal(*texts, **more)
        built = self._record.problems.build(self._session, goal)
        return built, self._record.problems.restrictions(self._session, goal, built)

    @staticmethod
    def _goal(*texts: str, **more: Any) -> GoalRow:
        goals = [said(text).model_dump() for text in texts or ("in(sample_1, bay_7)",)]
        return GoalRow(world="sample_store", goal=goals, **{"priority": 0, **more})


@pytest.fixture
def unavailable() -> dict[str, str]:
    return {}


@pytest.fixture
def running() -> list[MissionReservation]:
    return []


@pytest.fixture
def problems(
    tmp_path: Path, unavailable: dict[str, str], running: list[MissionReservation]
) -> Iterator[StoreProblems]:
    database = Database(f"sqlite:///{tmp_path / 'record.sqlite'}")
    migrate(database)
    record = StoreRecord(
        database, unavailable=lambda _: unavailable, reservations=StatedReservations(running)
    )
    with database.write() as session:
        record.add_world(session)
        yield StoreProblems(record, session)
    database.close()


def test_what_a_missions_plan_has_left_out_is_not_taken_up_again(problems: StoreProblems) -> None:
    goals = ("in(sample_1, bay_7)", "in(sample_2, bay_3)")
    terms = {"constraints": {"worth": [None, 5.0]}}
    built = problems.build(*goals, terms=terms)
    assert built.problem.values == {STORE.fact(goals[1]): 5.0}
    assert built.withheld.whole.values == built.problem.values
    mission_id = problems.carries_out(STORE.store_sample_1())
    under_way = problems.build(*goals, terms=terms, mission_id=mission_id).problem
    assert (under_way.goals, under_way.values) == ((STORED,), {})


def test_how_far_durations_vary_is_learned_with_how_long_they_are(problems: StoreProblems) -> None:
    assert problems.build().problem.spreads == {}
    problems.knows("DOCK", samples=97, mean=1.0)
    spread = problems.build().problem.spreads["DOCK", 1]
    assert spread.observations == 100
    assert spread.relative == pytest.approx(PRIOR_SPREAD * (3 / 100) ** 0.5, abs=1e-3), (
        "97 of 100 did not vary"
    )


def test_a_deadline_counts_from_now_on(problems: StoreProblems) -> None:
    assert problems.build().problem.deadlines_s == {}
    assert problems.build(deadline_at_s=130.0).problem.deadlines_s == {STORED: 30.0}
    assert problems.build(deadline_at_s=90.0).problem.deadlines_s == {STORED: -10.0}
    assert problems.build().problem.priorities == {STORED: 0}


def test_learned_durations_scale_the_plan(problems: StoreProblems) -> None:
    problems.knows("DOCK", samples=97, mean=2.0)
    built = problems.build()
    assert built.factors == {("DOCK", 1): 1.97}
    assert built.problem.functions[scale_term("DOCK", 1)] == 1.97
    result = StoreEngine().plan(built.problem, PlanningRequest())
    assert result.plan_net is not None
    docks = [action.duration_s for action in result.plan_net.actions if action.tag == "DOCK"]
    assert docks == [4.925] * len(docks)


def test_an_unavailable_robot_can_do_nothing_but_stays_where_it_is(
    problems: StoreProblems, unavailable: dict[str, str]
) -> None:
    unavailable["store_2"] = "which charges"
    built = problems.build()
    assert not any(f.predicate == "can" and f.args[0] == "store_2" for f in built.problem.facts)
    assert Fact("in_area", ("store_2", "aisle_2")) in built.problem.facts
    assert built.withheld.robots == {"store_2": "which charges"}


def test_waiting_is_in_vain_if_nobody_could_do_it_either_when_all_are_free(
    problems: StoreProblems, unavailable: dict[str, str]
) -> None:
    problems.knows("DOCK", samples=5, mean=1.2)
    unavailable["store_2"] = "which charges"
    assert problems.build().withheld.why_never(STORE.base) == ""
    never = problems.build("tracked(store_1, yard_1)").withheld
    assert "yard_1" in never.why_never(STORE.base)
    assert not any(never.blockers_of_each(STORE.base, [never.whole.goals]))


def held(*robots: str) -> dict[str, Reservation]:
    """Missions of a robot each, named like it."""
    return {robot: Reservation(robots=frozenset({robot})) for robot in robots}


@pytest.mark.parametrize(
    ("busy", "waits_for"),
    [
        (("store_1", "store_2", "yard_1"), ["store_2"]),
        (("yard_1", "yard_2"), ["yard_1", "yard_2"]),  # either would do
    ],
)
def test_a_goal_waits_for_those_missions_that_stand_in_its_way(
    problems: StoreProblems, busy: tuple[str, ...], waits_for: list[str]
) -> None:
    withheld = replace(problems.build().withheld, missions=held(*busy))
    assert withheld.blockers(STORE.base).missions == tuple(waits_for)
    other = STORE.fact("in(sample_1, bay_8)")
    among = replace(withheld, whole=replace(withheld.whole, goals=(other, *withheld.whole.goals)))
    assert among.blockers_of_each(STORE.base, [withheld.whole.goals])[0].missions == tuple(waits_for)


def test_a_goal_waits_for_no_mission_while_the_robot_it_needs_rests(
    problems: StoreProblems, unavailable: dict[str, str]
) -> None:
    unavailable |= {"store_2": "which charges", "yard_1": "which charges"}
    withheld = replace(problems.build().withheld, missions=held("store_1"))
    assert str(withheld.blockers(STORE.base)) == "store_2, which charges"


def test_goals_that_contradict_each_other_do_not_wait(problems: StoreProblems) -> None:
    built = problems.build("near(yard_1, door_1)", "near(yard_2, door_1)")
    assert built.withheld.why_never(STORE.base) == "yard_1 is near door_1 or yard_2 is near door_1, not both"


def test_constraints_withhold_robots_and_places_and_are_not_waited_for(problems: StoreProblems) -> None:
    terms = {"constraints": {"without": ["yard_1"], "avoid": ["interchange_1"], "keep_empty": ["bay_3"]}}
    built = problems.build(terms=terms)
    for facts in (built.problem.facts, built.withheld.whole.facts):
        assert not {fact for fact in facts if fact.predicate == "can" and fact.args[0] == "yard_1"}
        assert not {fact for fact in facts if fact.predicate == "reaches" and fact.args[1] == "interchange_1"}
        assert STORE.fact("vacant(bay_3)") not in facts
        assert STORE.fact("near(yard_1, home_yard_1)") in facts
    result = StoreEngine().plan(built.problem, PlanningRequest())
    assert result.plan_net is not None
    assert not built.constraints.broken_by(result.plan_net)


def test_a_problem_without_constraints_and_what_these_withhold_are_the_problem_with_them(
    problems: StoreProblems,
) -> None:
    terms = {
        "constraints": {
            "robots": ["yard_1", "store_1", "store_2"],
            "without": ["store_1"],
            "avoid": ["interchange_1"],
            "keep_empty": ["bay_3"],
            "keep": [{"predicate": "in", "args": ["sample_2", "bay_2"]}],
        }
    }
    built, restricted = problems.restricted(terms=terms, deadline_at_s=130.0, priority=3)
    assert restricted is not None
    problem, restrictions = restricted
    assert [one.words for one in restrictions] == [
        "only with yard_1, store_1 and store_2",
        "without store_1",
        "avoiding interchange_1",
        "keeping empty: bay_3",
        "keeping sample_2 in bay_2",
    ]
    withheld = frozenset[Fact]().union(*(one.withheld for one in restrictions))
    assert problem.facts > built.problem.facts
    ways = {"functions": built.problem.functions}  # it has no ways to where nobody can be
    assert replace(problem, facts=problem.facts - withheld, **ways) == built.problem
    assert problem.functions.items() >= built.problem.functions.items()
    assert problems.restricted()[1] is None


def test_a_goal_waits_for_the_mission_of_a_robot_that_must_not_act_and_stands_in_the_way(
    problems: StoreProblems, running: list[MissionReservation]
) -> None:
    problems.drives("yard_2", "home_yard_2", "interchange_1")
    terms = {"constraints": {"robots": ["yard_1", "store_1"]}}
    built = problems.build("in(sample_1, bay_1)", terms=terms)
    assert built.withheld.why_never(STORE.base) == "interchange_1 is not clear of robots in yard"
    running.append(
        MissionReservation(mission_id="one", reservation=Reservation(robots=frozenset({"yard_2"})))
    )
    built = problems.build("in(sample_1, bay_1)", terms=terms)
    assert STORE.fact("can(yard_2, NAVIGATE)") not in built.problem.facts
    assert built.withheld.why_never(STORE.base) == ""


def test_a_plan_that_breaks_the_constraints_is_told(problems: StoreProblems) -> None:
    plan = STORE.store_sample_1()
    terms = {"constraints": {"robots": ["yard_2", "store_2"], "avoid": ["bay_7"], "keep_empty": ["bay_7"]}}
    broken = problems.build("near(yard_2, door_1)", terms=terms).constraints.broken_by(plan)
    assert broken == ("it uses yard_1", "it goes to bay_7", "it puts a sample in bay_7")


def test_goals_are_pursued_in_their_stages(problems: StoreProblems) -> None:
    texts = ("in(sample_1, bay_7)", "near(yard_2, door_2)")
    built = problems.build(*texts, terms={"constraints": {"stages": [0, 1]}})
    assert built.problem.stages == {STORED: 0, STORE.fact("near(yard_2, door_2)"): 1}
    assert problems.build(*texts, terms={"constraints": {"stages": [1, 1]}}).problem.stages == {}
