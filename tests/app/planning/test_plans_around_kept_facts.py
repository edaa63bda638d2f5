"""No plan ends a fact that a hold, or a constraint of its goal, keeps: problems and plans of real worlds."""

import pytest

from app.cli.goal_input import read_goals
from app.cli.trials.offline_mission import goal_problem
from app.domain.errors import Invalid
from app.domain.goal_language.kept_facts import HoldFact
from app.domain.goal_language.stated_holds import StatedHold
from app.domain.world_model import Facts, revise_beliefs, taken_by
from app.planning.hold_service import HoldService
from app.planning.job import permitted
from app.planning.pool.work import Solution, WorkResult
from app.planning.problem_builder import GoalProblem
from app.planning.waiting_goals import WaitingGoals
from app.store import Database, GoalRow
from app.store.editions import WorldDirectory
from planner import PlanNet, PlanningRequest, PlanningResult, PlanningStatus
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from robots.world import load_world
from tests.app.planning.record import STORE, WORLD, StoreRecord
from tests.app.sample_store import Store, said
from tests.app.stepped_clock import SteppedClock
from tests.databases import ON_BOTH

QUICK = PlanningRequest(effort_s=0.0)


def planned(store: Store, sentence: str, facts: Facts | None = None) -> PlanningResult:
    """The plan of a sentence in a world, found by the service's own engine."""
    believed = store.facts if facts is None else facts
    stated = read_goals(store.world, believed, [sentence], store.base)
    problem = goal_problem(store.world, believed, stated.goals, store.base, stated.constraints)
    return HierarchicalEngine(store.base).plan(problem, QUICK)


def net_of(result: PlanningResult) -> PlanNet:
    assert result.plan_net is not None, result
    return result.plan_net


@pytest.mark.parametrize(
    ("world", "sentence", "kept"),
    [
        ("sample_store", "move sample_1 to bay_7 and keep yard_1 at home_yard_1", "yard_1"),
        ("sample_store", "move sample_1 to any bay and keep yard_2 at home_yard_2 for an hour", "yard_2"),
        (
            "sample_store",
            "move sample_3 to any bay and keep sample_2 in bay_2 until further notice",
            "sample_2",
        ),
        ("busy_store", "move any sample to any bay and keep yard_1 at home_yard_1", "yard_1"),
    ],
)
def test_a_plan_leaves_alone_what_its_goal_keeps(world: str, sentence: str, kept: str) -> None:
    assert kept not in taken_by(net_of(planned(Store(load_world(world)), sentence))).names


def test_what_is_kept_is_not_moved_out_of_the_way() -> None:
    ways = revise_beliefs(
        STORE.facts, [STORE.fact("in(sample_2, interchange_1)"), STORE.fact("in(sample_3, interchange_2)")]
    )
    aside = taken_by(net_of(planned(STORE, "move sample_1 to bay_7", ways)))
    assert "sample_3" in aside.samples
    kept = net_of(planned(STORE, "move sample_1 to bay_7 and keep sample_2 in interchange_1", ways))
    assert "sample_2" not in taken_by(kept).samples
    with pytest.raises(Invalid, match="keeping sample_3 in interchange_2"):
        planned(STORE, "move sample_1 to bay_7 and keep sample_3 in interchange_2", ways)


def test_a_robot_may_work_until_it_stands_where_it_is_to_be_kept() -> None:
    net = net_of(
        planned(STORE, "keep yard_1 at door_2 for an hour and move sample_1 to bay_7 without yard_2")
    )
    last = max(
        (action for action in net.actions if "yard_1" in action.agents), key=lambda one: one.earliest_start_s
    )
    assert STORE.fact("near(yard_1, door_2)") in last.effects


class Planner:
    """Problems of the sample store's record, with holds."""

    def __init__(self, database: Database) -> None:
        self.record = StoreRecord(database, unavailable=lambda _: {})
        with database.write() as session:
            self.record.add_world(session)
        self.holds = HoldService(
            self.record.core,
            worlds=WorldDirectory(database, {WORLD: STORE.world}),
            clocks=self.record.clocks,
            waiting=WaitingGoals(self.record.core, clocks=self.record.clocks),
            wall_clock=SteppedClock(epoch_s=0.0),
        )

    def keep(self, text: str, *, stated_by: str | None = None) -> str:
        """Begin a hold of a fact; the id of the goal that states it."""
        goal_id = self.record.add_goal(stated_by or text)
        kept = HoldFact.model_validate(said(text).model_dump())
        with self.record.database.write() as session:
            goal = session.get_one(GoalRow, goal_id)
            self.holds.begin(session, goal, [StatedHold(facts=(kept,))], STORE.world, actor="ann")
        return goal_id

    def build(self, goal_id: str) -> GoalProblem:
        with self.record.database.read() as session:
            return self.record.problems.build(session, session.get_one(GoalRow, goal_id))


@pytest.fixture
def planner(database: Database) -> Planner:
    return Planner(database)


@ON_BOTH
def test_the_problems_of_other_goals_lack_what_would_end_the_fact(planner: Planner) -> None:
    planner.keep("in(sample_2, bay_2)")
    planner.keep("near(yard_1, home_yard_1)")
    built = planner.build(planner.record.add_goal("in(sample_1, bay_7)"))
    assert STORE.fact("in(sample_2, bay_2)") not in built.problem.facts
    assert not {fact for fact in built.problem.facts if fact.predicate == "can" and fact.args[0] == "yard_1"}
    assert STORE.fact("near(yard_1, home_yard_1)") in built.problem.facts
    assert STORE.fact("in(sample_2, bay_2)") in built.withheld.whole.facts
    net = net_of(HierarchicalEngine(STORE.base).plan(built.problem, QUICK))
    assert not {"yard_1", "sample_2"} & taken_by(net).names


def test_the_goal_that_states_the_fact_may_bring_it_about_and_no_other_takes_the_place(
    planner: Planner,
) -> None:
    own = planner.build(planner.keep("in(sample_1, bay_7)"))
    assert {STORE.fact("in(sample_1, door_1)"), STORE.fact("vacant(bay_7)")} <= own.problem.facts
    assert not own.withheld.holds
    other = planner.build(planner.record.add_goal("in(sample_2, bay_8)"))
    assert not {STORE.fact("in(sample_1, door_1)"), STORE.fact("vacant(bay_7)")} & other.problem.facts
    again = planner.build(planner.record.add_goal("in(sample_1, bay_7)"))
    assert STORE.fact("in(sample_1, door_1)") in again.problem.facts


def test_a_goal_that_only_a_kept_fact_stands_against_waits_for_its_hold(planner: Planner) -> None:
    planner.keep("near(yard_1, home_yard_1)")
    planner.keep("in(sample_2, bay_2)")
    built = planner.build(planner.record.add_goal("in(sample_2, bay_3)"))
    assert not built.withheld.why_never(STORE.base)
    assert ["keeps sample_2 in bay_2" in one for one in built.withheld.blockers(STORE.base).holds] == [True]


def test_what_is_true_and_asked_for_is_not_ended_for_a_time(planner: Planner) -> None:
    planner.keep("in(sample_1, door_1)")
    carried = STORE.store_sample_1()
    built = planner.build(planner.record.add_goal("in(sample_1, door_1)"))
    assert STORE.fact("in(sample_1, door_1)") in built.problem.facts
    solved = PlanningResult(status=PlanningStatus.SOLVED, engine="none", planning_s=0.0, plan_net=carried)
    refused = permitted(built, WorkResult.solved((Solution(result=solved),)))
    assert refused.answer is None
    assert refused.reason.endswith("it moves sample_1")
