"""Any engine with goals in stages."""

from dataclasses import replace

import pytest

from app.domain.world_model import planning_problem
from planner import (
    UNOBSERVED,
    Fact,
    Keeping,
    Observer,
    OrderingReason,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    keep_in_step,
)
from planner.engines.registry import engine_named
from planner.engines.staged import StagedEngine
from planner.plan_nets.validation import faults_of
from planner.repair import MissionProgress, repair
from tests.app.sample_store import Store

STORE = Store()
FIRST = STORE.fact("near(yard_2, door_2)")
SECOND = STORE.fact("near(store_1, bay_1)")
THIRD = STORE.fact("near(store_2, bay_7)")
REQUEST = PlanningRequest(effort_s=0.0)


def problem(*goals: Fact, **more: object) -> PlanningProblem:
    built = planning_problem(STORE.world, STORE.facts, goals)
    return replace(built, **more)  # type: ignore[arg-type]


def plan(staged: PlanningProblem) -> PlanningResult:
    return engine_named("macta", STORE.base).plan(staged, REQUEST)


def test_robots_that_have_nothing_to_do_with_each_other_still_wait_for_the_earlier_stage() -> None:
    net = plan(problem(FIRST, SECOND, THIRD, stages={SECOND: 1, THIRD: 2})).plan_net
    assert net is not None
    starts = {action.agents[0]: action for action in net.actions}
    assert starts["store_1"].earliest_start_s >= starts["yard_2"].earliest_end_s
    assert starts["store_2"].earliest_start_s >= starts["store_1"].earliest_end_s
    assert [(o.reason, o.kept_by) for o in net.orderings] == [(OrderingReason.STAGE, Keeping.CLEARANCE)] * 2
    assert faults_of(net, STORE.facts, STORE.base) == []


def test_without_stages_they_start_at_once() -> None:
    net = plan(problem(FIRST, SECOND, stages={FIRST: 1, SECOND: 1})).plan_net
    assert net is not None
    assert {action.earliest_start_s for action in net.actions} == {0.0}


def test_deadlines_count_from_the_start_of_the_whole_plan() -> None:
    late = plan(problem(FIRST, SECOND, stages={SECOND: 1}, deadlines_s={SECOND: 1.0})).plan_net
    assert late is not None
    assert late.late[SECOND] == pytest.approx(late.makespan_s - 1.0)


def test_a_stage_without_a_plan_is_named_and_only_the_first_is_a_proof() -> None:
    never = STORE.fact("near(yard_1, bay_1)")
    first = plan(problem(never, FIRST, stages={FIRST: 1}))
    later = plan(problem(FIRST, never, stages={never: 1}))
    assert (first.status, later.status) == (PlanningStatus.UNSOLVABLE, PlanningStatus.NOT_FOUND)
    assert later.reason.startswith("after ")
    assert "yard_2" in later.reason


class OneAfterTheOther:
    """Counts what it is asked for."""

    name = "counting"

    def __init__(self) -> None:
        self.asked: list[tuple[Fact, ...]] = []

    def plan(
        self, asked: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.asked.append(asked.goals)
        assert not asked.stages
        return engine_named("macta", STORE.base).plan(asked, request, observer)


def test_each_stage_keeps_what_the_earlier_ones_have_achieved() -> None:
    engine = OneAfterTheOther()
    StagedEngine(engine, STORE.base).plan(problem(FIRST, SECOND, stages={SECOND: 1}), REQUEST)
    assert engine.asked == [(FIRST,), (FIRST, SECOND)]


def test_a_repair_keeps_the_stages_apart() -> None:
    """store_2 was to go after store_1 had arrived; yard_2 has moved meanwhile, so all is planned again."""
    staged = problem(FIRST, SECOND, stages={SECOND: 1})
    net = plan(staged).plan_net
    assert net is not None
    moved = STORE.fact("near(yard_2, door_1)")
    home = STORE.fact("near(yard_2, home_yard_2)")
    facts = (STORE.facts - {home, Fact("clear", ("door_1", "yard"))}) | {
        moved,
        Fact("clear", ("home_yard_2", "yard")),
    }
    progress = MissionProgress()
    engine = engine_named("macta", STORE.base)
    mended = repair(engine, STORE.base, net, replace(staged, facts=facts), progress, REQUEST)
    assert mended.plan_net is not None
    in_step = keep_in_step(mended.plan_net, facts, staged.objects, STORE.base)
    starts = {action.agents[0]: action for action in in_step.actions}
    assert starts["store_1"].earliest_start_s >= starts["yard_2"].earliest_end_s
