"""What a mission counts on: causal links that the world has cut, and links that only wait for their time."""

from app.domain.broken_links import broken_links
from app.domain.world_model import apply_action, revise_beliefs
from tests.app.sample_store import Store

STORE = Store()
NET = STORE.store_sample_1()
DOCK = next(a.id for a in NET.actions if a.tag == "DOCK" and a.agents == ("yard_1",))
CARRIES = [a.id for a in NET.actions if a.agents == ("yard_1",)]


def words(begun: set[str], done: set[str], facts: frozenset[object]) -> set[str]:
    return {str(link.fact) for link in broken_links(NET, facts, begun=begun, done=done)}  # type: ignore[arg-type]


def test_a_plan_that_goes_as_expected_has_no_cut_link_at_any_of_its_stages() -> None:
    facts, done = STORE.facts, set[str]()
    for action in sorted(NET.actions, key=lambda one: one.earliest_start_s):
        assert not broken_links(NET, facts, begun=done, done=done)
        assert not broken_links(NET, facts, begun=done | {action.id}, done=done)
        facts = apply_action(facts, action)
        done.add(action.id)
    assert not broken_links(NET, facts, begun=done, done=done)


def test_a_sample_that_is_elsewhere_cuts_the_link_until_it_is_fetched() -> None:
    moved = revise_beliefs(STORE.facts, [STORE.fact("in(sample_1, door_2)")])
    assert words(set(), set(), moved) == {str(STORE.fact("in(sample_1, door_1)"))}
    assert not broken_links(NET, moved, begun={DOCK}, done=set())


def test_what_comes_before_an_action_that_has_begun_has_begun_too() -> None:
    moved = revise_beliefs(STORE.facts, [STORE.fact("in(sample_1, yard_1)")])
    assert not broken_links(NET, moved, begun={CARRIES[-1]}, done=set())


def test_a_bay_that_is_filled_meanwhile_cuts_the_link_of_its_vacancy() -> None:
    filled = revise_beliefs(STORE.facts, [STORE.fact("in(sample_4, bay_7)")])
    assert str(STORE.fact("vacant(bay_7)")) in words(set(), set(), filled)


def test_a_robot_that_stands_in_the_way_or_elsewhere_cuts_nothing() -> None:
    stands = revise_beliefs(
        STORE.facts, [STORE.fact("near(yard_2, door_1)"), STORE.fact("near(yard_1, door_2)")]
    )
    assert not broken_links(NET, stands, begun=set(), done=set())


def test_a_goal_that_came_true_and_is_undone_is_a_cut_link() -> None:
    facts = STORE.facts
    done = {action.id for action in NET.actions}
    for action in sorted(NET.actions, key=lambda one: one.earliest_start_s):
        facts = apply_action(facts, action)
    gone = revise_beliefs(facts, [], gone=[STORE.fact("in(sample_1, bay_7)")])
    assert str(STORE.fact("in(sample_1, bay_7)")) in words(done, done, gone)
