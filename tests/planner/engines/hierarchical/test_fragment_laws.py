"""Laws of fragments over random stores and goals: valid, needed, intended, and never unreachable where found."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner import load_knowledge_base
from planner.engines.hierarchical.fragments.discovery import MAX_STEPS
from planner.engines.hierarchical.fragments.fragment import Fragments
from planner.engines.hierarchical.fragments.grounding import task_of
from planner.engines.hierarchical.fragments.heuristic import is_reachable
from planner.engines.hierarchical.fragments.relevance import LEVELS, small_world
from planner.engines.hierarchical.fragments.steps import Task
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.relaxation import unreachable_goals
from tests.planner.engines.hierarchical.checks import fragments_of, tags
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.large_store import LargeStore
from tests.planner.store import inside

BASE = load_knowledge_base()
LEARNT = Fragments(BASE)  # shared by all examples, so that what one learnt is tried on the others


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    aisles=st.integers(1, 3),
    yard_robots=st.integers(1, 3),
    store_robots=st.integers(1, 2),
    interchanges=st.integers(1, 2),
    seed=st.integers(0, 999),
)
def test_fragments_of_random_goals_are_valid(
    aisles: int, yard_robots: int, store_robots: int, interchanges: int, seed: int
) -> None:
    world = Store(
        aisles=aisles, yard_robots=yard_robots, store_robots=store_robots, interchanges=interchanges
    )
    chance = random.Random(seed)
    places = [f"door_{n}" for n in range(2)] + [f"bay_{a}_{n}" for a in range(aisles) for n in range(6)]
    samples = {f"s{n}": place for n, place in enumerate(chance.sample(places, len(places) // 2))}
    goal = inside(chance.choice(list(samples)), chance.choice(places))
    problem = world.problem([goal], samples)
    found = fragments_of(LEARNT, problem)
    assert found
    assert not unreachable_goals(BASE, problem)


@pytest.mark.parametrize("level", range(LEVELS))
def test_a_task_cut_down_has_the_steps_of_the_smaller_world(level: int) -> None:
    world = Store(aisles=2, yard_robots=2, store_robots=2, interchanges=2)
    problem = world.problem([inside("s0", "bay_1_3")], {"s0": "bay_0_1", "s1": "bay_1_3", "s2": "door_0"})
    index = WorldIndex(BASE, problem)

    def task_among(objects: frozenset[str]) -> Task:
        task = task_of(index, objects, problem.goals, limit=MAX_STEPS, is_over=lambda: False)
        assert task is not None
        return task

    whole = task_among(small_world(index, problem.goals, level))
    assert len(index.members) > 1
    for kind in index.members:
        smaller = small_world(index, problem.goals, level, [kind])
        assert smaller < whole.objects
        cut, ground = whole.among(smaller), task_among(smaller)
        assert steps_of(cut) == steps_of(ground)
        assert len(cut.steps) < len(whole.steps)
        assert is_reachable(cut) == is_reachable(ground)


def steps_of(task: Task) -> set[tuple[str, tuple[str, ...], float]]:
    return {(step.op.name, step.args, step.cost) for step in task.steps}


def test_every_goal_of_a_large_store_has_the_fragment_of_the_first() -> None:
    world = LargeStore(aisles=8, samples=48)
    problem = world.problem()
    fragments = Fragments(BASE)
    source = fragments.of(problem)
    for goal in problem.goals:
        (fragment,) = source.alternatives((goal,))
        assert len(tags(fragment)) == 8
        assert goal in fragment.actions[-1].intended_effects
    assert len(fragments.known) == 1
