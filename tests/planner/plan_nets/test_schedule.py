"""Time windows, deadlines and critical paths."""

import random
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import Fact, KnowledgeBase, PlanNet
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from planner.plan_nets.precedence import Precedence
from planner.plan_nets.schedule import critical_path, windows
from tests.planner.large_store import LargeStore

Network = tuple[list[float], set[tuple[int, int]]]


@st.composite
def networks(draw: st.DrawFn) -> Network:
    """Durations and acyclic orderings."""
    spans = draw(st.lists(st.integers(1, 20).map(float), min_size=1, max_size=9))
    last = len(spans) - 1
    pairs = draw(st.sets(st.tuples(st.integers(0, last), st.integers(0, last))))
    return spans, {(min(pair), max(pair)) for pair in pairs if pair[0] != pair[1]}


@given(network=networks())
def test_windows_are_the_minimal_network(network: Network) -> None:
    """Against all-pairs longest paths of the temporal constraints."""
    spans, pairs = network
    count = len(spans)
    far = [[0.0 if a == b else float("-inf") for b in range(count)] for a in range(count)]
    for before, after in pairs:
        far[before][after] = spans[before]
    for via in range(count):
        for a in range(count):
            for b in range(count):
                far[a][b] = max(far[a][b], far[a][via] + far[via][b])
    makespan = max(far[a][b] + spans[b] for a in range(count) for b in range(count))
    times = windows(spans, pairs, {})
    for node in range(count):
        assert times.earliest[node] == max(far[a][node] for a in range(count))
        assert times.latest[node] == makespan - max(far[node][b] + spans[b] for b in range(count))


@given(network=networks())
def test_the_critical_path_is_a_chain_as_long_as_the_makespan(network: Network) -> None:
    spans, pairs = network
    times = windows(spans, pairs, {})
    path = critical_path(spans, times.earliest, pairs)
    assert all(pair in pairs for pair in pairwise(path))
    assert sum(spans[node] for node in path) == max(
        start + span for start, span in zip(times.earliest, spans, strict=True)
    )
    assert all(times.earliest[node] == times.latest[node] for node in path)


@given(network=networks(), seed=st.integers(0, 999))
def test_a_deadline_binds_the_latest_starts_and_never_the_earliest(network: Network, seed: int) -> None:
    spans, pairs = network
    choose = random.Random(seed)
    node = choose.randrange(len(spans))
    by = choose.uniform(-5.0, 60.0)
    free = windows(spans, pairs, {})
    bound = windows(spans, pairs, {node: by})
    assert bound.earliest == free.earliest
    end = bound.latest[node] + spans[node]
    assert end <= max(by, free.earliest[node] + spans[node]) + 0.001
    before = Precedence.of(len(spans), pairs).before[node]
    for other in range(len(spans)):
        assert free.earliest[other] <= bound.latest[other] <= free.latest[other]
        if other != node and not before >> other & 1:
            assert bound.latest[other] == free.latest[other]


def test_nothing_to_do_takes_no_time() -> None:
    assert windows([], set(), {}).earliest == ()
    assert critical_path([], [], set()) == []


@pytest.fixture(scope="module")
def store() -> LargeStore:
    return LargeStore(aisles=2, samples=2)


def planned(store: LargeStore, base: KnowledgeBase, deadlines_s: dict[Fact, float]) -> PlanNet:
    problem = store.problem()
    order = extract(store.sequence(problem, base), problem.facts, problem.goals)
    return assemble(order, problem.goals, base, {}, deadlines_s)


def ends(plan_net: PlanNet) -> dict[Fact, tuple[float, float]]:
    """Each goal's earliest and latest time."""
    found = {}
    for link in plan_net.causal_links:
        if link.consumer == "goal":
            action = plan_net.action(link.producer)
            found[link.fact] = (action.earliest_end_s, action.latest_start_s + action.duration_s)
    return found


def test_a_deadline_that_can_be_kept_bounds_the_goal(
    knowledge_base: KnowledgeBase, store: LargeStore
) -> None:
    free = ends(planned(store, knowledge_base, {}))
    soonest = min(free, key=lambda goal: free[goal][0])
    earliest, latest = free[soonest]
    assert latest > earliest + 0.2
    plan_net = planned(store, knowledge_base, {soonest: earliest + 0.1})
    assert plan_net.late == {}
    assert ends(plan_net)[soonest] == pytest.approx((earliest, earliest + 0.1))


def test_a_deadline_that_cannot_be_kept_is_reported_and_makes_its_way_critical(
    knowledge_base: KnowledgeBase, store: LargeStore
) -> None:
    free = planned(store, knowledge_base, {})
    soonest = min(ends(free), key=lambda goal: ends(free)[goal][0])
    earliest, _ = ends(free)[soonest]
    plan_net = planned(store, knowledge_base, {soonest: earliest - 4})
    assert plan_net.late == {soonest: pytest.approx(4.0)}
    assert plan_net.makespan_s == free.makespan_s
    producer = next(link.producer for link in plan_net.causal_links if link.fact == soonest)
    assert plan_net.action(producer).critical
    assert not free.action(producer).critical


def test_a_goal_that_holds_already_is_never_late(knowledge_base: KnowledgeBase, store: LargeStore) -> None:
    problem = store.problem()
    held = next(fact for fact in sorted(problem.facts) if fact.predicate == "object_position")
    order = extract((), problem.facts, (held,))
    assert assemble(order, (held,), knowledge_base, {}, {held: -10.0}).late == {}
