"""What a robot reports is what it perceives."""

from dataclasses import replace

from robots.conditions.facts import perceived
from robots.physical.sightings import Sighting
from robots.wire import SymbolicFact
from tests.robots.sensed import percepts, sees
from tests.robots.stories import fact


def test_a_full_gripper_is_reported_with_what_it_holds() -> None:
    facts = perceived(percepts(closed=True, between="sample"))
    assert fact("robot_attribute(me, gripper, full)") in facts
    assert fact("in(sample, me)") in facts


def test_near_and_at_a_place_are_distinguished() -> None:
    assert fact("near(me, bay)") in perceived(percepts(sees("bay", 0.85)))
    assert fact("at(me, bay)") in perceived(percepts(sees("bay", 0.36)))
    far = perceived(percepts(sees("bay", 2)))
    assert not {"near(me, bay)", "at(me, bay)"} & set(map(str, far))


def test_who_stands_in_the_way_of_a_place_with_empty_jaws_is_near_it() -> None:
    beside = sees("bay", 1.2)
    assert fact("near(me, bay)") in perceived(percepts(beside))
    assert fact("near(me, bay)") not in perceived(percepts(beside, closed=True, between="sample"))


def test_the_own_spot_is_named_only_where_no_beacon_is_by() -> None:
    assert fact("near(me, me_spot)") in perceived(percepts())
    assert fact("near(me, me_spot)") not in perceived(percepts(sees("bay", 0.8)))


def test_a_sample_lies_where_its_tag_is_seen_or_in_the_robot_it_is_seen_with() -> None:
    lying = perceived(percepts(sees("bay", 2), sees("sample", 2)))
    carried = perceived(percepts(sees("bay", 2), sees("sample", 1.3), sees("other", 1)))
    assert fact("in(sample, bay)") in lying
    assert fact("in(sample, other)") in carried


def test_a_tag_too_far_for_its_bearing_is_said_to_lie_nowhere() -> None:
    assert not [one for one in perceived(percepts(sees("sample", 4))) if one.predicate == "in"]


def test_a_place_near_by_at_which_no_sample_is_seen_is_reported_to_be_empty() -> None:
    assert fact("vacant(bay)") in told(sees("bay", 0.85))
    assert fact("vacant(bay)") in told(sees("bay", 0.85), sees("sample", 1.6))
    for unsure in ((sees("bay", 0.85), sees("sample", 0.85)), (sees("bay", 2.0),), ()):
        assert fact("vacant(bay)") not in told(*unsure)


def test_where_long_objects_lie_about_no_place_is_reported_to_be_empty() -> None:
    """Their tags shine to their sides only."""
    assert fact("vacant(bay)") not in perceived(percepts(sees("bay", 0.85)))


def told(*sightings: Sighting) -> tuple[SymbolicFact, ...]:
    """In a world without long objects."""
    seen = percepts(*sightings)
    return perceived(replace(seen, profile=replace(seen.profile, lengths_m={})))
