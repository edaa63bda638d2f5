"""Plans to choose from: each differs from the others and is best at something."""

from dataclasses import replace

import pytest

from planner import (
    UNOBSERVED,
    Fact,
    Keeping,
    KnowledgeBase,
    Observer,
    Ordering,
    OrderingReason,
    PlanNet,
    PlanNetAction,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    faults_of,
)
from planner.alternatives import activities, alternatives
from planner.engines.fast_downward import FastDownwardEngine
from tests.planner.store import inside, store_problem

REQUEST = PlanningRequest(time_limit_s=60)


def action(name: str, robot: str, start_s: float, *, energy_j: float = 1.0) -> PlanNetAction:
    return PlanNetAction(
        id=name,
        tag="NAVIGATE",
        arguments={"robots": robot},
        agents=(robot,),
        preconditions=(),
        deletes=(),
        intended_effects=(),
        other_effects=(),
        duration_s=10.0,
        earliest_start_s=start_s,
        latest_start_s=start_s,
        description="",
        energy_j=energy_j,
    )


def net(*actions: PlanNetAction, cleared: bool = False) -> PlanNet:
    ordering = Ordering(
        before="a1", after="a2", reason=OrderingReason.THREAT, kept_by=Keeping.CLEARANCE if cleared else None
    )
    return PlanNet(
        goals=(),
        actions=actions,
        causal_links=(),
        orderings=(ordering,) if cleared else (),
        recruitment={},
    )


def bare(plan_net: PlanNet) -> PlanNet:
    """Without the recruitment, which the canned plans come without."""
    return replace(plan_net, recruitment={})


QUICK = net(action("a1", "yard_1", 0), action("a2", "yard_2", 0, energy_j=5), cleared=True)
SMALL = net(action("a1", "yard_1", 0), action("a2", "yard_1", 10))
SPARING = net(action("a1", "yard_1", 0, energy_j=0.5), action("a2", "store_1", 30, energy_j=0.5))
OTHER = net(action("a1", "store_1", 0), action("a2", "yard_2", 50))


class Answering:
    """Answers each objective with a plan of its own, and another without yard_1."""

    name = "answering"

    def __init__(self, **answers: PlanNet) -> None:
        self.answers = answers
        self.asked = 0

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.asked += 1
        key: str = request.objective
        for robot in ("yard_1", "yard_2"):
            if Fact("can", (robot, "DOCK")) not in problem.facts:
                key = robot
        plan_net = self.answers.get(key)
        status = PlanningStatus.UNSOLVABLE if plan_net is None else PlanningStatus.SOLVED
        return PlanningResult(status=status, engine=self.name, planning_s=0.0, plan_net=plan_net)


@pytest.fixture
def problem() -> PlanningProblem:
    return store_problem([inside("sample_1", "bay_7")])


def test_each_alternative_says_what_it_is_best_at_and_what_it_costs(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> None:
    engine = Answering(makespan=QUICK, robots=SMALL, energy=SPARING, yard_1=OTHER)
    found = alternatives(engine, knowledge_base, problem, REQUEST, k=9)
    assert [(one.label, bare(one.plan_net)) for one in found] == [
        ("shortest time", QUICK),
        ("fewest robots, needs no contact, without yard_2", SMALL),
        ("least energy", SPARING),
        ("without yard_1", OTHER),
    ]
    assert found[0].words == ""
    assert found[1].words == "10 s longer, without yard_2, 4 J less, 1 fewer to clear"
    assert found[3].words == "50 s longer, store_1 instead of yard_1, 4 J less, 1 fewer to clear"
    assert [one.plan_net.clearances for one in found] == [1, 0, 0, 0]


def test_no_more_are_given_than_asked_for(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
    engine = Answering(makespan=QUICK, robots=SMALL, energy=SPARING, yard_1=OTHER)
    found = alternatives(engine, knowledge_base, problem, REQUEST, k=2)
    assert [bare(one.plan_net) for one in found] == [
        QUICK,
        SMALL,
    ]


def test_a_plan_that_is_best_at_nothing_is_left_out(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> None:
    slower = replace(SMALL, actions=(*SMALL.actions, action("a3", "yard_1", 40)))
    known = PlanningResult(status=PlanningStatus.SOLVED, engine="known", planning_s=0.0, plan_net=slower)
    engine = Answering(makespan=SMALL, robots=SMALL, energy=SMALL)
    (only,) = alternatives(engine, knowledge_base, problem, REQUEST, k=4, proposed=known)
    assert (only.label, bare(only.plan_net)) == ("shortest time, least energy", SMALL)


def test_a_plan_that_is_known_already_may_be_the_best(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> None:
    known = PlanningResult(status=PlanningStatus.SOLVED, engine="known", planning_s=0.0, plan_net=QUICK)
    found = alternatives(Answering(makespan=SMALL), knowledge_base, problem, REQUEST, k=4, proposed=known)
    assert [one.result.engine for one in found] == ["known", "answering"]


def test_a_plan_without_a_robot_may_turn_out_to_be_the_shortest(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> None:
    engine = Answering(makespan=SMALL, yard_1=QUICK)
    found = alternatives(engine, knowledge_base, problem, REQUEST, k=4)
    assert [(one.label, one.plan_net.makespan_s) for one in found] == [
        ("shortest time", 10.0),
        ("fewest robots, least energy, needs no contact, without yard_2", 20.0),
    ]
    assert [one.words for one in found] == ["", "10 s longer, without yard_2, 4 J less, 1 fewer to clear"]


def test_a_problem_without_a_plan_has_no_alternatives(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> None:
    assert alternatives(Answering(), knowledge_base, problem, REQUEST, k=4) == ()


def test_who_stops_the_search_gets_what_was_found(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> None:
    engine = Answering(makespan=QUICK, robots=SMALL)

    class Impatient(Observer):
        def should_stop(self) -> bool:
            return engine.asked > 0

    (only,) = alternatives(engine, knowledge_base, problem, REQUEST, Impatient(), k=4)
    assert (bare(only.plan_net), engine.asked) == (QUICK, 1)


def test_the_store_has_a_plan_without_the_nearer_yard_robot(
    engine: FastDownwardEngine, knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> None:
    found = alternatives(engine, knowledge_base, problem, REQUEST, k=4)
    assert len({activities(one.plan_net) for one in found}) == len(found) >= 2
    for one in found:
        assert faults_of(one.plan_net, problem.facts, knowledge_base) == []
        assert one.plan_net.clearances == sum(o.kept_by is Keeping.CLEARANCE for o in one.plan_net.orderings)
    (without,) = [one for one in found if one.label == "without yard_1"]
    assert "yard_1 would qualify too" in without.plan_net.recruitment["yard_2"]
    assert without.plan_net.robots == ("store_2", "yard_2")
    assert without.plan_net.makespan_s > found[0].plan_net.makespan_s
