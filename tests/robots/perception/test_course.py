"""Steering round what is in the way, and coming to stand near a place."""

from cmath import phase

from hypothesis import given, settings
from hypothesis import strategies as st

from robots.perception.course import clear_course, guide
from robots.perception.obstacles import Obstacle, Obstacles
from robots.physical.body import RADIUS_M
from tests.robots.sensed import percepts, sees

TARGET = 3 + 0j


def test_a_free_way_is_straight() -> None:
    assert clear_course(TARGET, Obstacles.of([])) == 0


def test_a_robot_that_comes_head_on_is_passed_on_the_right() -> None:
    for aside in (-0.1, 0.0, 0.1):
        course = clear_course(
            TARGET, Obstacles.of([Obstacle(at=1.2 + aside * 1j, radius_m=RADIUS_M, is_robot=True)])
        )
        assert course is not None
        assert course < 0


def test_a_post_is_passed_on_its_nearer_side() -> None:
    left, right = Obstacle(at=1 + 0.1j, radius_m=0.06), Obstacle(at=1 - 0.1j, radius_m=0.06)
    assert (
        (clear_course(TARGET, Obstacles.of([left])) or 0)
        < 0
        < (clear_course(TARGET, Obstacles.of([right])) or 0)
    )


def test_what_lies_beyond_the_target_is_not_in_the_way() -> None:
    assert clear_course(0.5 + 0j, Obstacles.of([Obstacle(at=1.1 + 0j, radius_m=0.06)])) == 0


def test_no_course_is_found_where_everything_is_blocked() -> None:
    ring = Obstacles.of(Obstacle(at=0.3 * 1j**quarter, radius_m=0.1) for quarter in range(4))
    assert clear_course(TARGET, ring) is None


@settings(deadline=None)  # the first call compiles
@given(
    st.lists(st.tuples(st.floats(0.5, 2.5), st.floats(-3.1, 3.1)), max_size=6),
    st.floats(0.5, 4),
    st.floats(-3, 3),
)
def test_a_course_never_leads_the_hull_into_a_near_obstacle(
    places: list[tuple[float, float]], distance_m: float, angle: float
) -> None:
    from cmath import rect

    obstacles = Obstacles.of(Obstacle(at=rect(*place), radius_m=0.06) for place in places)
    target = rect(distance_m, angle)
    course = clear_course(target, obstacles)
    if course is None:
        return
    for one in obstacles:
        seen = one.at * rect(1, -course)
        if seen.real > 0 and abs(one.at) < min(1.2, distance_m):
            assert abs(seen.imag) >= one.radius_m + RADIUS_M - 1e-6


def test_guidance_far_off_leads_to_the_point_before_the_beacon() -> None:
    way = guide(percepts(sees("bay", 2, 0.5, 0.3)), "bay")
    assert way is not None
    assert way.turn_rad != phase(1 + 0j)
    assert way.advance_m > 0.5


def test_guidance_at_the_approach_point_only_faces_the_beacon() -> None:
    way = guide(percepts(sees("bay", 0.8, 0.4, -0.02)), "bay")
    assert way is not None
    assert abs(way.turn_rad - 0.4) < 0.05


def test_an_unknown_place_gives_no_guidance() -> None:
    assert guide(percepts(), "nowhere") is None
