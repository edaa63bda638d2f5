"""Rays in the plane find what the physics engine's own rays find."""

from math import pi, sqrt, tau

import numpy as np
import pybullet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.world import load_world
from sim.physics.rays import CLEARANCE_M, Cut, LinesOfSight, free_shares
from sim.physics.scene import SONAR_GROUPS, WALLS
from sim.world.simulation import Simulation

NOTHING = Cut(np.empty((0, 6)), np.empty((0, 3)))
BOX = np.array([[2.0, 0.0, 1.0, 0.0, 0.5, 1.0]])
"""Around (2, 0), 1 m long to the east and 2 m wide."""
DISC = np.array([[2.0, 0.0, 0.5]])
ONE_EACH = np.array([0, 1])


class Idle:
    def tick(self) -> None: ...


def share(cut: Cut, start: tuple[float, float], end: tuple[float, float]) -> float:
    return float(free_shares(cut, np.array([start]), np.array([end]), ONE_EACH)[0])


def test_a_ray_ends_where_it_meets_a_box_and_goes_on_past_it() -> None:
    cut = NOTHING._replace(boxes=BOX)
    assert share(cut, (0, 0), (3, 0)) == pytest.approx(0.5)
    assert share(cut, (0, 0.9), (3, 0.9)) == pytest.approx(0.5)
    assert share(cut, (0, 1.1), (3, 1.1)) == 1.0
    assert share(cut, (0, 0), (1.4, 0)) == 1.0
    assert share(cut, (3, 0), (4, 0)) == 1.0


def test_a_box_turns_with_its_body() -> None:
    half_turned = np.array([[2.0, 0.0, sqrt(0.5), sqrt(0.5), 0.5, 0.5]])
    assert share(NOTHING._replace(boxes=half_turned), (0, 0), (2, 0)) == pytest.approx((2 - sqrt(0.5)) / 2)


def test_a_ray_ends_where_it_meets_a_disc() -> None:
    cut = NOTHING._replace(discs=DISC)
    assert share(cut, (0, 0), (3, 0)) == pytest.approx(0.5)
    assert share(cut, (0, 0.51), (3, 0.51)) == 1.0
    assert share(cut, (3, 0), (4, 0)) == 1.0


def test_a_ray_that_begins_within_something_is_not_free_at_all() -> None:
    assert share(NOTHING._replace(boxes=BOX), (2, 0), (5, 0)) == 0.0
    assert share(NOTHING._replace(discs=DISC), (2, 0), (5, 0)) == 0.0


@pytest.mark.parametrize(("height_m", "groups"), [(0.1, SONAR_GROUPS), (0.5, WALLS)])
@pytest.mark.parametrize("world", ["sample_store", "relocation_lab"])
def test_rays_agree_with_the_physics_engine(world: str, height_m: float, groups: int) -> None:
    """But for a few that graze a round body, where the engine is a centimetre off, and those that begin in one."""
    simulation = Simulation(load_world(world), make_agent=lambda _: Idle(), seed=1)
    rng = np.random.default_rng(0)
    starts = rng.uniform((0, 0), (10, 7), (1000, 2))
    angles = rng.uniform(-pi, pi, 1000)
    ends = starts + 2.5 * np.column_stack([np.cos(angles), np.sin(angles)])
    ours = free_shares(simulation.scene.cut(height_m=height_m, groups=groups), starts, ends, np.arange(1001))
    high = np.full((1000, 1), height_m)
    hits = pybullet.rayTestBatch(
        np.hstack([starts, high]),
        np.hstack([ends, high]),
        collisionFilterMask=groups,
        physicsClientId=simulation.scene.client,
    )
    off_m = 2.5 * np.abs(ours - [hit[2] for hit in hits])[ours > 0]
    assert np.count_nonzero(ours < 1) > 200
    assert np.count_nonzero(off_m > 0.002) <= 10
    assert np.median(off_m) < 1e-6


@given(
    seed=st.integers(0, 10**6), extent_m=st.sampled_from((0.0, 3.0, 40.0, 900.0)), bodies=st.integers(0, 40)
)
def test_rays_meet_the_same_bodies_as_without_cells(seed: int, extent_m: float, bodies: int) -> None:
    rng = np.random.default_rng(seed)
    cut = scattered(rng, bodies, extent_m)
    starts = rng.uniform(-1, extent_m + 1, (40, 2))
    ends = starts + rng.uniform(-extent_m, extent_m, (40, 2)) * rng.choice((0.0, 1e-9, 0.1, 1.0), (40, 2))
    each = np.arange(41)
    alone = [free_shares(one, starts, ends, each) for one in one_by_one(cut)]
    expected = np.min([np.ones(40), *alone], axis=0)
    fans = np.unique(np.append(rng.integers(0, 41, 5), (0, 40)))
    assert free_shares(cut, starts, ends, fans).tolist() == expected.tolist()
    seen = [
        LinesOfSight(1, 1).read(cut, starts[[n]], ends[[n]], np.array([1e9]), np.ones((1, 1), np.bool_))
        for n in range(40)
    ]
    assert [len(pairs) == 1 for pairs in seen] == (expected == 1.0).tolist()


def scattered(rng: np.random.Generator, bodies: int, extent_m: float) -> Cut:
    """Boxes, some of them long walls along an axis, and discs."""
    turns = np.where(
        rng.random(bodies) < 0.5, rng.integers(0, 4, bodies) * tau / 4, rng.uniform(0, tau, bodies)
    )
    lengths = rng.uniform(0.02, 1 + extent_m / 4, bodies)
    middles = rng.uniform(0, extent_m, (bodies, 2))
    boxes = np.column_stack([middles, np.cos(turns), np.sin(turns), lengths, np.full(bodies, 0.05)])
    return Cut(
        boxes, np.column_stack([rng.uniform(0, extent_m, (bodies, 2)), rng.uniform(0.02, 0.5, bodies)])
    )


def one_by_one(cut: Cut) -> list[Cut]:
    boxes = [NOTHING._replace(boxes=cut.boxes[[n]]) for n in range(len(cut.boxes))]
    return boxes + [NOTHING._replace(discs=cut.discs[[n]]) for n in range(len(cut.discs))]


@given(seed=st.integers(0, 10**6), extent_m=st.sampled_from((3.0, 8.0, 40.0)))
def test_sight_does_not_depend_on_what_was_seen_before(seed: int, extent_m: float) -> None:
    """Ends that creep, stand and leap, beside walls of which some move."""
    rng = np.random.default_rng(seed)
    cut = scattered(rng, 20, extent_m)
    at = [rng.uniform(0, extent_m, (count, 2)) for count in (5, 30)]
    reach_m = rng.choice((extent_m / 2, np.inf), 30)
    lines = LinesOfSight(5, 30)
    for _ in range(25):
        known = rng.random((5, 30)) < 0.9
        fresh = LinesOfSight(5, 30).read(cut, *at, reach_m, known)
        assert lines.read(cut, *at, reach_m, known).tolist() == fresh.tolist()
        steps_m = rng.choice((0.0, CLEARANCE_M / 5, extent_m / 2), p=(0.3, 0.6, 0.1), size=2)
        at = [one + step_m * rng.uniform(-1, 1, one.shape) for one, step_m in zip(at, steps_m, strict=True)]
        if rng.random() < 0.1:
            cut = cut._replace(boxes=cut.boxes + rng.choice((0.0, 0.2), (20, 1)) * np.eye(6)[0])
