"""Laws of fragments over random stores and goals: valid, needed, intended, and never unreachable where found."""

import random

from hypothesis import given, settings
from hypothesis import strategies as st

from planner import load_knowledge_base
from planner.engines.hierarchical.fragments.fragment import Fragments
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
