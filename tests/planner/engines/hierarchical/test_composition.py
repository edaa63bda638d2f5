"""Fragments composed: who does what and when."""

from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.planner.instances import FAMILIES
from planner import Fact, GroundAction, KnowledgeBase, read_knowledge_base
from planner.engines.hierarchical.composition import Composed, Composition
from planner.engines.hierarchical.legs.stops import with_stops
from planner.engines.hierarchical.scheduling.annealing import Schedule
from planner.engines.hierarchical.scheduling.construction import Constructor
from planner.engines.hierarchical.scheduling.decoder import IMPOSSIBLE, USELESS, decode
from planner.engines.hierarchical.scheduling.decoder_state import decoder_state_for
from planner.engines.hierarchical.scheduling.model import AHEAD, NEAR, PUSH, Choice
from planner.engines.hierarchical.scheduling_problem import SchedulingProblemBuilder
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract, fault_of
from tests.planner.engines.hierarchical.composing import MAKESPAN_ONLY, ProblemSetup, said
from tests.planner.engines.hierarchical.survey import SURVEY, survey
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside

TRIALS = 2000


def stored(count: int, *, doors: int = 4) -> tuple[list[Fact], dict[str, str]]:
    """So many samples at doors, for bays of two aisles."""
    goals = [inside(f"sample_{n}", f"bay_{n % 2}_{n}") for n in range(count)]
    return goals, {f"sample_{n}": f"door_{n}" for n in range(count)}


@pytest.fixture
def four(knowledge_base: KnowledgeBase) -> ProblemSetup:
    return ProblemSetup.of(knowledge_base, Store(doors=4).problem(*stored(4)))


def composition_of(world: ProblemSetup, *, seed: int = 0) -> Composition:
    return world.composition([(world.quickest(goal),) for goal in world.problem.goals], seed=seed)


def builder_of(world: ProblemSetup) -> SchedulingProblemBuilder:
    return world.builder([(world.quickest(goal),) for goal in world.problem.goals])


def improved(composition: Composition, trials: int = TRIALS) -> Composed:
    assert composition.begin()
    composition.improve(trials, 1e9, lambda _: True)
    assert composition.composed is not None
    return composition.composed


def makespan_s(world: ProblemSetup, actions: Sequence[GroundAction]) -> float:
    """By the plan-net of the sequence."""
    order = extract(actions, world.problem.facts, world.problem.goals)
    return assemble(order, world.problem.goals, world.base, {}).makespan_s


def test_the_makespan_is_that_of_the_plan_net(four: ProblemSetup) -> None:
    composed = improved(composition_of(four))
    assert fault_of(composed.actions, four.problem.facts, four.problem.goals) is None
    assert composed.makespan_s == pytest.approx(makespan_s(four, composed.actions), abs=0.01)


def test_annealing_makes_it_shorter_and_never_longer(knowledge_base: KnowledgeBase) -> None:
    bays = Store(doors=8, bays=8)
    first = composition_of(ProblemSetup.of(knowledge_base, bays.problem(*stored(8))))
    assert first.begin()
    assert first.composed is not None
    begun_s = first.composed.makespan_s
    seen: list[float] = []
    first.improve(TRIALS, 1e9, lambda best_s: bool(seen.append(best_s)) or True)
    assert seen == sorted(seen, reverse=True)
    assert seen[0] == begun_s
    assert first.composed.makespan_s < begun_s


def test_the_same_seed_composes_the_same_plan(four: ProblemSetup) -> None:
    one, same = improved(composition_of(four, seed=5)), improved(composition_of(four, seed=5))
    assert one.actions == same.actions
    assert one.makespan_s == same.makespan_s


def test_robots_that_are_alike_share_the_work(four: ProblemSetup) -> None:
    docking = {one[1] for one in said(improved(composition_of(four)).actions) if one[0] == "DOCK"}
    assert docking == {"yard_0", "yard_1", "store_0_0", "store_1_0"}


def test_a_slower_fragment_is_not_chosen(knowledge_base: KnowledgeBase) -> None:
    goal = inside("sample", "door_9")
    store = Store(aisles=1, doors=10)
    world = ProblemSetup.of(knowledge_base, store.problem([goal], {"sample": "bay_0_0"}))
    direct, *over_home = with_stops([world.quickest(goal)], world.stops())
    assert over_home
    composed = improved(world.composition([[*over_home, direct]]), trials=200)
    assert len([one for one in said(composed.actions) if one[0] == "TRANSPORT"]) == 2


def test_a_robot_begins_from_wherever_it_stands(knowledge_base: KnowledgeBase) -> None:
    """The fragment was found for a robot at home."""
    goal = inside("sample", "door_0")
    store = Store(aisles=1, yard_robots=1)
    there = ProblemSetup.of(knowledge_base, store.problem([goal], {"sample": "bay_0_0"}))
    fragment = there.quickest(goal)
    problem = store.problem([goal], {"sample": "bay_0_0"}, robots_at={"store_0_0": "interchange_0_0"})
    composed = improved(ProblemSetup.of(knowledge_base, problem).composition([[fragment]]), trials=200)
    assert fault_of(composed.actions, problem.facts, problem.goals) is None
    assert said(composed.actions)[0] == ("NAVIGATE", "store_0_0", "interchange_0_0", "bay_0_0")


def scheduled(world: ProblemSetup, trials: int) -> int:
    """Of so many orders, agents and stops at random those with a schedule; each of these is a plan."""
    builder = builder_of(world)
    model = builder.model()
    random = np.random.default_rng(0)
    state = decoder_state_for(model)
    tasks = len(world.problem.goals)
    legs = tasks * model.max_legs
    possible = 0
    for _ in range(trials):
        choice = Choice(
            random.permutation(legs).astype(np.int32),
            np.zeros(tasks, np.int32),
            random.integers(-1, len(model.agent_class), legs).astype(np.int32),
            random.choice([0, NEAR, AHEAD, PUSH, NEAR | AHEAD | PUSH], legs).astype(np.int32),
        )
        cost, _, length, span_s = decode(model, choice, MAKESPAN_ONLY, np.inf, state)
        if cost < IMPOSSIBLE:
            possible += 1
            actions = builder.actions(state.steps[:length], state.step_agents[:length])
            assert fault_of(actions, world.problem.facts, world.problem.goals) is None
            assert span_s >= makespan_s(world, actions) - 0.01
    return possible


def test_every_choice_decodes_to_a_plan_or_is_called_impossible(four: ProblemSetup) -> None:
    assert scheduled(four, 200) > 100


def test_the_members_of_a_team_go_on_from_where_it_leaves_them() -> None:
    goals = [Fact("at", ("ann", "base")), Fact("stands", ("box", "fork")), Fact("at", ("bob", "north"))]
    problem = survey(goals, rovers={"ann": "fork", "bob": "fork"}, strong=["ann", "bob"])
    world = ProblemSetup.of(read_knowledge_base(SURVEY, "survey.yaml"), problem)
    assert scheduled(world, 50) > 10


def test_a_leg_that_nobody_can_take_now_waits_until_somebody_can() -> None:
    goals = [Fact("photographed", ("rock",)), Fact("stands", ("box", "fork"))]
    problem = survey(goals, rovers={"ann": "base", "bob": "fork"}, strong=["ann", "bob"])
    world = ProblemSetup.of(read_knowledge_base(SURVEY, "survey.yaml"), problem)
    assert scheduled(world, 50) > 10


def test_a_step_starts_when_the_one_it_waited_for_ends(four: ProblemSetup) -> None:
    """The causes lead from the last step back to the start, and their durations add up to the makespan."""
    model = builder_of(four).model()
    state = decoder_state_for(model)
    choice = Constructor(model).choice(np.random.default_rng(0))
    cost, _, _, span_s = decode(model, choice, MAKESPAN_ONLY, np.inf, state)
    assert cost < IMPOSSIBLE
    step = int(state.free[np.argmax(state.free[:, 0]), 1])
    whole = 0.0
    while step >= 0:
        whole += model.step_span_s[state.steps[step]]
        step = int(state.cause[step])
    assert whole == pytest.approx(span_s)


def test_a_choice_counts_as_impossible_above_the_given_cost_only(four: ProblemSetup) -> None:
    model = builder_of(four).model()
    state = decoder_state_for(model)
    choice = Constructor(model).choice(np.random.default_rng(0))
    decisive, cost, _, _ = decode(model, choice, MAKESPAN_ONLY, np.inf, state)
    assert decode(model, choice, MAKESPAN_ONLY, cost, state)[:2] == (decisive, cost)
    assert decode(model, choice, MAKESPAN_ONLY, 0.9 * decisive, state)[0] == IMPOSSIBLE


def test_constructed_choices_can_be_scheduled_and_are_better_than_orders_at_random(
    knowledge_base: KnowledgeBase,
) -> None:
    """The best of eight, over twelve stores."""
    better = 0
    for seed in range(12):
        world = ProblemSetup.of(knowledge_base, FAMILIES["mixed"](12, seed).problem(knowledge_base))
        model = builder_of(world).model()
        random = np.random.default_rng(seed)
        constructor = Constructor(model)
        constructed = [constructor.choice(random) for _ in range(8)]
        legs = range(len(constructed[0].order))
        assert all(sorted(choice.order) == list(legs) for choice in constructed)
        schedules = [Schedule(model, choice, MAKESPAN_ONLY) for choice in constructed]
        assert sum(schedule.is_possible for schedule in schedules) >= 4
        orders = [random.permutation(legs).astype(np.int32) for _ in constructed]
        others = [
            Schedule(model, Choice.of(order, np.zeros(12, np.int32)), MAKESPAN_ONLY) for order in orders
        ]
        better += min(schedule.merit for schedule in schedules) < min(one.merit for one in others)
    assert better >= 11


def test_tasks_that_come_last_are_constructed_after_all_others(four: ProblemSetup) -> None:
    model = builder_of(four).model()
    for seed in range(10):
        choice = Constructor(model, [False, True, False, True]).choice(np.random.default_rng(seed))
        counts = np.diff(model.leg_first)
        placed = [place for place in choice.order if place % model.max_legs < counts[place // model.max_legs]]
        tasks = [place // model.max_legs for place in placed]
        assert set(tasks[: counts[0] + counts[2]]) == {0, 2}


@pytest.mark.parametrize(("family", "samples", "seed"), [("mixed", 12, 4), ("store", 8, 3), ("store", 12, 5)])
def test_improvement_begins_with_the_best_schedule_known(
    knowledge_base: KnowledgeBase, family: str, samples: int, seed: int
) -> None:
    """Here, the agents that took the legs would make a longer schedule if they were chosen beforehand."""
    world = ProblemSetup.of(knowledge_base, FAMILIES[family](samples, seed).problem(knowledge_base))
    composition = composition_of(world)
    assert composition.begin()
    assert composition.start().makespan_s <= composition.best_s


@pytest.mark.parametrize("trials", [0, 1, 100, 1777])
def test_exactly_the_trials_asked_for_are_made(four: ProblemSetup, trials: int) -> None:
    composition = composition_of(four)
    improved(composition, trials)
    assert composition.trials == trials


def test_a_longer_search_begins_with_the_shorter_one(knowledge_base: KnowledgeBase) -> None:
    world = ProblemSetup.of(knowledge_base, FAMILIES["mixed"](8, 0).problem(knowledge_base))
    found = []
    for trials in (20, 200, 2000):
        composition = composition_of(world)
        improved(composition, trials)
        found.append([composed.makespan_s for composed in composition.found()][::-1])
    shortest, longer, longest = found
    # The last chunk of a search may be cut short: what it found last, the longer one may have improved at once.
    assert longer[: len(shortest) - 1] == shortest[:-1]
    assert longest[: len(longer) - 1] == longer[:-1]
    assert len(longest) > len(shortest)


def test_fragments_offered_later_are_as_good_as_those_offered_at_first(four: ProblemSetup) -> None:
    quickest = [(four.quickest(goal),) for goal in four.problem.goals]
    stops = [with_stops(some, four.stops())[1:] for some in quickest]
    varied = four.composition(quickest)
    assert varied.begin()
    varied.vary(stops)
    varied.improve(TRIALS, 1e9, lambda _: True)
    assert varied.composed is not None
    assert varied.composed.makespan_s == pytest.approx(makespan_s(four, varied.composed.actions), abs=0.01)
    at_once = four.composition([(*one, *more) for one, more in zip(quickest, stops, strict=True)])
    assert varied.composed.makespan_s <= 1.1 * improved(at_once).makespan_s


def test_a_stop_that_clears_a_place_for_nobody_is_useless(knowledge_base: KnowledgeBase) -> None:
    """Table 3: a place may be left early for another robot only."""
    goal = inside("sample", "door_9")
    store = Store(aisles=1, doors=10)
    world = ProblemSetup.of(knowledge_base, store.problem([goal], {"sample": "bay_0_0"}))
    direct, over_home, *_ = with_stops([world.quickest(goal)], world.stops())
    model = world.builder([[direct, over_home]]).model()
    legs = np.arange(model.max_legs, dtype=np.int32)
    straight, stopping = (
        Schedule(model, Choice.of(legs, np.array([number], np.int32)), MAKESPAN_ONLY) for number in (0, 1)
    )
    assert straight.decisive < USELESS
    assert USELESS <= stopping.decisive < IMPOSSIBLE
    assert stopping.cost < 2 * straight.cost, "the search may pass by it"


def test_a_stop_is_of_use_if_another_robot_takes_the_place_some_steps_later(
    knowledge_base: KnowledgeBase,
) -> None:
    goals = [inside("sample", "door_9"), inside("other", "door_8")]
    lying = {"sample": "bay_0_0", "other": "bay_0_1"}
    world = ProblemSetup.of(knowledge_base, Store(aisles=1, doors=10).problem(goals, lying))
    first, second = (world.quickest(goal) for goal in goals)
    _, over_home, *_ = with_stops([first], world.stops())
    model = world.builder([[over_home], [second]]).model()
    legs = np.arange(2 * model.max_legs, dtype=np.int32)
    schedule = Schedule(model, Choice.of(legs, np.zeros(2, np.int32)), MAKESPAN_ONLY)
    assert schedule.decisive < USELESS
