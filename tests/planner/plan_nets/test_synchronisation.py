"""What keeps robots in step: hand-made plan-nets, and random ones whose every order of events is explored."""

import random
from collections.abc import Sequence
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from planner import (
    Fact,
    GroundAction,
    Keeping,
    KnowledgeBase,
    Ordering,
    PlanNet,
    PlanningProblem,
    awaits_of,
    keep_in_step,
    read_knowledge_base,
)
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from planner.plan_nets.validation import faults_of
from tests.planner.exploring import first_fault
from tests.planner.store import inside, store_problem

AREAS = {"yard_1": "yard", "yard_2": "yard", "store_1": "aisle_1", "store_2": "aisle_2"}


def plan_net_of(base: KnowledgeBase, problem: PlanningProblem, steps: Sequence[str]) -> PlanNet:
    """From steps such as `yard_1 carry sample_1 door_1 interchange_1` (grip, transport, release) or `yard_1
    go a b`."""
    sequence = []
    for step in steps:
        robot, verb, *rest = step.split()
        own = {"robots": robot, "rel1": "near", "rel2": "near", "area": AREAS[robot]}
        if verb == "go":
            todo = [("NAVIGATE", own | {"ref1": rest[0], "ref2": rest[1]})]
        else:
            places = own | {"object": rest[0], "ref1": rest[1], "ref2": rest[2]}
            todo = [("DOCK", places), *((tag, places | {"rel1": "at"}) for tag in ("TRANSPORT", "RELEASE2"))]
        sequence += [
            base.ground(tag, given, problem.functions, objects=problem.objects) for tag, given in todo
        ]
    order = extract(sequence, problem.facts, problem.goals)
    plan_net = assemble(order, problem.goals, base, {})
    assert faults_of(plan_net, problem.facts, base) == []
    return keep_in_step(plan_net, problem.facts, problem.objects, base, problem.senses)


def cleared(plan_net: PlanNet) -> list[tuple[str, str]]:
    """The orderings kept by clearance, as "robot tag" of both ends."""
    actions = {action.id: f"{action.agents[0]} {action.tag}" for action in plan_net.actions}
    kept = [o for o in plan_net.orderings if o.kept_by is Keeping.CLEARANCE]
    return [(actions[o.before], actions[o.after]) for o in kept]


def uncleared(plan_net: PlanNet, ordering: Ordering) -> PlanNet:
    """The plan-net whose robots are not told of one ordering."""
    others = (replace(o, kept_by=Keeping.SENSING) if o is ordering else o for o in plan_net.orderings)
    return replace(plan_net, orderings=tuple(others))


def test_a_robot_without_senses_docks_once_it_is_cleared(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_1")], samples={"sample_1": "door_1"})
    blind = replace(problem, senses={"store_1": frozenset()})
    plan_net = plan_net_of(knowledge_base, blind, BRING_IN)
    assert cleared(plan_net) == [("yard_1 RELEASE2", "store_1 DOCK")]
    assert awaits_of(plan_net, problem.objects, knowledge_base) == {}
    assert plan_net.senses == {"store_1": frozenset()}
    assert first_fault(plan_net, problem.facts, problem.objects, knowledge_base) is None


def test_senses_of_robots_that_await_nothing_change_no_plan(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_1")], samples={"sample_1": "door_1"})
    usual = plan_net_of(knowledge_base, problem, BRING_IN)
    blind = replace(problem, senses={"yard_1": frozenset(), "yard_2": frozenset()})
    other = plan_net_of(knowledge_base, blind, BRING_IN)
    assert replace(other, senses={}) == usual


BRING_IN = [
    "yard_1 go home_yard_1 door_1",
    "yard_1 carry sample_1 door_1 interchange_1",
    "store_1 go home_store_1 interchange_1",
    "store_1 carry sample_1 interchange_1 bay_1",
]


def test_handing_over_at_an_interchange_is_kept_by_sensing_alone(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_1")], samples={"sample_1": "door_1"})
    plan_net = plan_net_of(knowledge_base, problem, BRING_IN)
    assert cleared(plan_net) == []
    assert first_fault(plan_net, problem.facts, problem.objects, knowledge_base) is None
    ordering = next(o for o in plan_net.orderings if o.kept_by is Keeping.SENSING)
    assert plan_net.action(ordering.before).tag == "RELEASE2"
    assert plan_net.action(ordering.after).tag == "DOCK"


def two_at_one_interchange(knowledge_base: KnowledgeBase) -> tuple[PlanningProblem, PlanNet]:
    """The second yard robot comes to an interchange that is clear at first, then taken, then clear again."""
    samples = {"sample_1": "door_1", "sample_2": "door_2"}
    problem = store_problem([inside("sample_1", "bay_1"), inside("sample_2", "bay_2")], samples=samples)
    steps = [
        *BRING_IN,
        "yard_1 go interchange_1 door_1",
        "yard_2 go home_yard_2 door_2",
        "yard_2 carry sample_2 door_2 interchange_1",
        "store_1 go bay_1 interchange_1",
        "store_1 carry sample_2 interchange_1 bay_2",
    ]
    return problem, plan_net_of(knowledge_base, problem, steps)


def test_two_robots_that_use_one_interchange_from_one_side_need_clearance(
    knowledge_base: KnowledgeBase,
) -> None:
    problem, plan_net = two_at_one_interchange(knowledge_base)
    assert cleared(plan_net) == [("yard_1 NAVIGATE", "yard_2 TRANSPORT")]
    assert first_fault(plan_net, problem.facts, problem.objects, knowledge_base) is None


def test_without_that_clearance_some_order_of_events_goes_wrong(knowledge_base: KnowledgeBase) -> None:
    problem, plan_net = two_at_one_interchange(knowledge_base)
    ordering = next(o for o in plan_net.orderings if o.kept_by is Keeping.CLEARANCE)
    alone = uncleared(plan_net, ordering)
    assert first_fault(alone, problem.facts, problem.objects, knowledge_base) is not None


def test_one_robot_may_hand_over_twice_at_one_interchange(knowledge_base: KnowledgeBase) -> None:
    samples = {"sample_1": "door_1", "sample_2": "door_2"}
    problem = store_problem([inside("sample_1", "bay_1"), inside("sample_2", "bay_2")], samples=samples)
    steps = [
        *BRING_IN,
        "yard_1 go interchange_1 door_2",
        "yard_1 carry sample_2 door_2 interchange_1",
        "store_1 go bay_1 interchange_1",
        "store_1 carry sample_2 interchange_1 bay_2",
    ]
    plan_net = plan_net_of(knowledge_base, problem, steps)
    assert cleared(plan_net) == []
    assert first_fault(plan_net, problem.facts, problem.objects, knowledge_base) is None


def test_taking_out_after_bringing_in_is_kept_by_sensing_alone(knowledge_base: KnowledgeBase) -> None:
    samples = {"sample_1": "door_1", "sample_2": "bay_2"}
    problem = store_problem([inside("sample_1", "bay_1"), inside("sample_2", "door_1")], samples=samples)
    bring_out = [
        "store_1 go bay_1 bay_2",
        "store_1 carry sample_2 bay_2 interchange_1",
        "yard_1 carry sample_2 interchange_1 door_1",
    ]
    plan_net = plan_net_of(knowledge_base, problem, BRING_IN + bring_out)
    assert cleared(plan_net) == []
    assert first_fault(plan_net, problem.facts, problem.objects, knowledge_base) is None


ANY_ACTION = """
types: {robot: {}, thing: {}}
functions: {}
predicates:
  seen: {arguments: {thing: thing}, sensed: true}
  felt: {arguments: {thing: thing}, sensed: true}
  hidden: {arguments: {thing: thing}}
  done: {arguments: {thing: thing}}
actions:
  - identifier: 1
    name: ACT
    parameters: [{name: robot, type: robot}, {name: thing, type: thing}]
    agents: [robot]
    preconditions: []
    delete: []
    intended_effects: [done(thing)]
    other_effects: []
    duration: "1"
    description: "{robot} act on {thing}"
"""
ANY_BASE = read_knowledge_base(ANY_ACTION, "any.yaml")
THINGS = ("one", "two", "three")
ROBOTS = ("fred", "ginger", "gene")


def act(
    number: int, agents: Sequence[str], needs: Sequence[Fact], uses: Sequence[Fact], brings: Sequence[Fact]
) -> GroundAction:
    """An action that also intends a fact of its own, `done(number)`, so that it is not redundant."""
    return GroundAction(
        tag="ACT",
        arguments={"robot": agents[0], "thing": str(number)},
        agents=tuple(agents),
        preconditions=tuple(needs),
        deletes=tuple(uses),
        intended_effects=(Fact("done", (str(number),)), *brings),
        other_effects=(),
        duration_s=1.0 + number % 3,
    )


def random_problem(choose: random.Random) -> tuple[PlanningProblem, list[GroundAction]]:
    """Up to seven actions of two or three robots, now and then together, on facts seen and hidden."""
    facts = [
        Fact(name, (thing,))
        for name in ("seen", "felt", "hidden")
        for thing in THINGS[: choose.randint(1, 3)]
    ]
    initial = frozenset(fact for fact in facts if choose.random() < 0.5)
    robots = ROBOTS[: choose.randint(2, 3)]
    state = set(initial)
    sequence = list[GroundAction]()
    for number in range(choose.randint(2, 7)):
        agents = sorted(choose.sample(robots, 2 if choose.random() < 0.15 else 1))
        needs = choose.sample(sorted(state), min(len(state), choose.randint(0, 2)))
        uses = [fact for fact in needs if choose.random() < 0.5]
        missing = [fact for fact in facts if fact not in state or fact in uses]
        brings = choose.sample(missing, min(len(missing), choose.randint(0, 2)))
        state = (state - set(uses)) | set(brings)
        sequence.append(act(number, agents, needs, uses, brings))
    objects = dict.fromkeys((*THINGS, *map(str, range(len(sequence)))), "thing")
    goals = tuple(Fact("done", (str(number),)) for number in range(len(sequence)))
    problem = PlanningProblem(
        objects=objects | dict.fromkeys(robots, "robot"),
        facts=initial,
        goals=(*goals, *sorted(state - initial)),
    )
    return problem, sequence


def kept(problem: PlanningProblem, sequence: Sequence[GroundAction]) -> PlanNet:
    plan_net = assemble(extract(sequence, problem.facts, problem.goals), problem.goals, ANY_BASE, {})
    return keep_in_step(plan_net, problem.facts, problem.objects, ANY_BASE, problem.senses)


def with_random_senses(problem: PlanningProblem, choose: random.Random) -> PlanningProblem:
    """Each robot senses all, nothing, or one of the two predicates that are sensed."""
    words = [None, (), ("seen",), ("felt",), ("seen", "felt")]
    chosen = {robot: choose.choice(words) for robot in ROBOTS}
    return replace(problem, senses={r: frozenset(w) for r, w in chosen.items() if w is not None})


@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_no_order_of_events_goes_wrong_where_clearances_are_honoured(seed: int) -> None:
    problem, sequence = random_problem(random.Random(seed))
    plan_net = kept(problem, sequence)
    assert all(ordering.kept_by is not None for ordering in plan_net.orderings)
    assert first_fault(plan_net, problem.facts, problem.objects, ANY_BASE) is None


@settings(max_examples=400, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_no_order_of_events_goes_wrong_whatever_each_robot_senses(seed: int) -> None:
    choose = random.Random(seed)
    problem, sequence = random_problem(choose)
    problem = with_random_senses(problem, choose)
    plan_net = kept(problem, sequence)
    assert all(ordering.kept_by is not None for ordering in plan_net.orderings)
    assert first_fault(plan_net, problem.facts, problem.objects, ANY_BASE) is None
    awaits = awaits_of(plan_net, problem.objects, ANY_BASE)
    for (_, robot), facts in awaits.items():
        assert {fact.predicate for fact in facts} <= problem.senses.get(robot, {"seen", "felt"})


@settings(max_examples=75, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_robots_without_senses_await_nothing_and_depend_on_others_by_clearance_alone(seed: int) -> None:
    problem, sequence = random_problem(random.Random(seed))
    blind = replace(problem, senses=dict.fromkeys(ROBOTS, frozenset()))
    plan_net = kept(blind, sequence)
    assert awaits_of(plan_net, problem.objects, ANY_BASE) == {}
    assert all(ordering.kept_by is not Keeping.SENSING for ordering in plan_net.orderings)
    assert plan_net.clearances >= kept(problem, sequence).clearances
    assert first_fault(plan_net, problem.facts, problem.objects, ANY_BASE) is None


def test_a_robot_that_is_taken_to_sense_what_it_does_not_goes_wrong_in_some_order() -> None:
    """The comparison notices plan-nets that rely on senses a robot lacks."""
    wrong = 0
    for seed in range(60):
        problem, sequence = random_problem(random.Random(seed))
        trusted = replace(kept(problem, sequence), senses=dict.fromkeys(ROBOTS, frozenset[str]()))
        wrong += first_fault(trusted, problem.facts, problem.objects, ANY_BASE) is not None
    assert wrong > 10


def test_hardly_any_clearance_can_be_done_without() -> None:
    needless = total = 0
    for seed in range(150):
        choose = random.Random(seed)
        problem, sequence = random_problem(choose)
        problem = with_random_senses(problem, choose) if seed % 2 else problem
        plan_net = kept(problem, sequence)
        for ordering in plan_net.orderings:
            if ordering.kept_by is Keeping.CLEARANCE:
                less = uncleared(plan_net, ordering)
                needless += first_fault(less, problem.facts, problem.objects, ANY_BASE) is None
                total += 1
    assert total > 100
    assert needless <= total // 100


def story(*actions: GroundAction, facts: Sequence[Fact] = ()) -> tuple[PlanningProblem, PlanNet]:
    """The plan-net of actions on things, with whatever they bring about by the way."""
    objects = dict.fromkeys((*THINGS, *map(str, range(len(actions)))), "thing")
    problem = PlanningProblem(
        objects=objects | dict.fromkeys(ROBOTS, "robot"),
        facts=frozenset(facts),
        goals=tuple(action.intended_effects[0] for action in actions),
    )
    return problem, kept(problem, actions)


SEEN = Fact("seen", ("one",))
HIDDEN = Fact("hidden", ("one",))


def test_what_a_robot_cannot_sense_is_kept_by_clearance() -> None:
    for fact, keeping in ((SEEN, Keeping.SENSING), (HIDDEN, Keeping.CLEARANCE)):
        _, plan_net = story(act(0, ["fred"], [], [], [fact]), act(1, ["ginger"], [fact], [], []))
        assert [ordering.kept_by for ordering in plan_net.orderings] == [keeping]


def test_what_is_seen_before_another_takes_it_away_and_brings_it_back_tells_nothing() -> None:
    take = act(0, ["fred"], [SEEN], [SEEN], [])
    bring_back = act(1, ["fred"], [], [], [SEEN])
    use = act(2, ["ginger"], [SEEN], [SEEN], [])
    _, plan_net = story(take, bring_back, use, facts=[SEEN])
    assert cleared(plan_net) == [("fred ACT", "ginger ACT")]


def test_robots_that_act_together_are_cleared_for_each_other() -> None:
    """Each starts its part by itself, so the other's part before has to be over."""
    lift = act(0, ["fred", "ginger"], [], [], [HIDDEN])
    lower = act(1, ["fred", "ginger"], [HIDDEN], [HIDDEN], [])
    problem, plan_net = story(lift, lower)
    assert [ordering.kept_by for ordering in plan_net.orderings] == [Keeping.CLEARANCE]
    assert first_fault(plan_net, problem.facts, problem.objects, ANY_BASE) is None
    alone = uncleared(plan_net, plan_net.orderings[0])
    assert first_fault(alone, problem.facts, problem.objects, ANY_BASE) is not None


def test_a_team_does_not_wait_to_see_what_its_first_robot_takes_away() -> None:
    problem, plan_net = story(
        act(0, ["gene"], [], [], [SEEN]), act(1, ["fred", "ginger"], [SEEN], [SEEN], [])
    )
    assert [ordering.kept_by for ordering in plan_net.orderings] == [Keeping.CLEARANCE]
    assert first_fault(plan_net, problem.facts, problem.objects, ANY_BASE) is None
