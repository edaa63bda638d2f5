"""The physical scene in PyBullet: walls, rovers and samples as rigid bodies that move in the plane.

Frames and units: world frame of the world file, metres, radians, counter-clockwise.
Our choices: there is no gravity; every body is held in its plane instead, and the floor's friction is so
strong that a sample moves only while it is pushed. Rovers are velocity-set: the solver lets walls and bodies
stop them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, sin
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import RADIUS_M, Pose
from robots.world import Slope
from robots.world.slopes import pace_at
from robots.world.walls import WALL_THICKNESS_M, Panel
from sim.clock import TICK_S
from sim.physics import bullet
from sim.physics.bullet import BodyPoses, pybullet
from sim.physics.camera import Colour, Pixels, Seen, picture
from sim.physics.cross_section import CollisionShapes, Shape
from sim.physics.rays import Cut, near
from sim.snapshot import Rock

SUBSTEPS = 4  # of 1/240 s each

WALL_HEIGHT_M = 0.6
RAISED_M = 0.65
"""How far the panel of an open door is raised."""
ROCK_HEIGHT_M = 0.4
"""Higher than a held sample, lower than the infra-red's lines of sight."""
ROVER_HEIGHT_M = 0.3
ROVER_MASS_KG = 20.0
ROVER_INERTIA_KG_M2 = 0.5
"""About its vertical axis."""
SAMPLE_RADIUS_M = 0.06
SAMPLE_HEIGHT_M = 0.15
BALL_RADIUS_M = 0.09
"""Of a sample that rolls: the jaws pass over it."""
BEAM_WIDTH_M = 0.06
CAMERA_HEIGHT_M = 0.35
"""A rover's cameras look over its body."""
BEACON_HEIGHT_M = 0.5
PRESSES_M = 1e-3
"""Bodies nearer than this press against each other."""
LIFTED_M = 0.245
"""Height of a held sample's middle: its foot passes above standing samples and above the whiskers' plane."""

WALL_COLOUR: Colour = (146, 158, 166)
ROCK_COLOUR: Colour = (120, 104, 88)
ROVER_COLOUR: Colour = (44, 92, 168)
SAMPLE_COLOUR: Colour = (228, 186, 40)
BEACON_COLOUR: Colour = (200, 60, 50)
PLACE_COLOUR: Colour = (86, 145, 140)

# Collision groups; the engine's own rays are of group 1, LOW is below the whiskers' plane.
RAYS = 1
WALLS = 2
ROVERS = 4
SAMPLES = 8
LOW = 16
SONAR_GROUPS = WALLS | ROVERS | SAMPLES
"""What a whisker's beam meets."""
MOVABLE = RAYS | ROVERS | SAMPLES | LOW
"""What walls collide with: contacts between joined walls need no solving."""
EVERYTHING = MOVABLE | WALLS

Point3 = tuple[float, float, float]

BEACON = (
    (Shape(pybullet.GEOM_CYLINDER, 0.0, 0.0, 0.0, 0.01, 0.25, 0.25), PLACE_COLOUR),
    (
        Shape(pybullet.GEOM_SPHERE, 0.0, 0.0, BEACON_HEIGHT_M, BEACON_HEIGHT_M + 0.1, 0.05, 0.05),
        BEACON_COLOUR,
    ),
)
"""A place's mark on the floor, and its beacon."""


@dataclass(frozen=True, slots=True)
class Placed:
    """Where a sample stands: its middle; of a long one its length, and the direction that it lies in; of a ball how
    the floor slows it down, and how it rolls.
    """

    point: tuple[float, float]
    length_m: float = 0.0
    heading_rad: float = 0.0
    rolling_m_s2: float = 0.0
    velocity_m_s: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ball:
    """`rolling_m_s2`: how fast the floor slows it down while it rolls."""

    radius_m: float
    rolling_m_s2: float


class Scene:
    """One PyBullet world without a window. Bodies are known by their names in the world file."""

    def __init__(
        self,
        panels: Sequence[Panel],
        rovers: Mapping[str, Pose],
        samples: Mapping[str, Placed],
        slopes: Sequence[Slope] = (),
    ) -> None:
        self._slopes = tuple(slopes)
        self.client: int = pybullet.connect(pybullet.DIRECT)
        # The engine keeps about 30 MB per world, also for one that is dropped without being closed.
        self._disconnect = finalize(self, pybullet.disconnect, self.client)
        self._disconnect.atexit = False
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=TICK_S,
            numSubSteps=SUBSTEPS,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self._solid: list[int] = []
        self._shapes = CollisionShapes()
        self._poses = BodyPoses(self.client)
        self._sample_points: NDArray[np.float64] | None = None
        self._pressed: frozenset[int] = frozenset()
        """Bodies that pressed against something in the last tick."""
        for panel in panels:
            self._add_wall(panel)
        shape = bullet.rover(
            self.client, height_m=ROVER_HEIGHT_M, jaws_m=LIFTED_M, half_width_m=SAMPLE_RADIUS_M
        )
        self._rover_shape = shape
        self._foreign: dict[str, int] = {}
        self._rovers = {name: self._add_rover(shape, pose) for name, pose in rovers.items()}
        self._balls: dict[int, Ball] = {}
        self._samples = {name: self._add_sample(placed) for name, placed in samples.items()}
        self._names = tuple(samples)
        self._long_bodies = frozenset(
            self._samples[name] for name, placed in samples.items() if placed.length_m
        )
        self._held: set[str] = set()
        self._beacons: list[tuple[float, float]] = []
        self._lowered: dict[int, Panel] = {}

    @property
    def lowered_panels(self) -> frozenset[Panel]:
        """The movable panels that stand too low for a rover to pass under."""
        return frozenset(self._lowered.values())

    def pose(self, rover: str) -> Pose:
        """A rover's true pose."""
        x, y, _, heading = self._poses.of(self._rovers[rover])
        return Pose(x_m=x, y_m=y, heading_rad=heading)

    def pace(self, rover: str) -> float:
        """The share of its speed at which the ground under a rover lets it drive."""
        if not self._slopes:
            return 1.0
        here = self.pose(rover)
        return pace_at((here.x_m, here.y_m), self._slopes)

    def sample_point(self, sample: str) -> Point3:
        """A sample's true middle."""
        return self._poses.of(self._samples[sample])[:3]

    def sample_points(self) -> NDArray[np.float64]:
        """Shape (S, 3): the true middles of all samples, in the order in which the scene was given them."""
        if self._sample_points is None:
            poses = [self._poses.of(body) for body in self._samples.values()]
            self._sample_points = np.array(poses).reshape(-1, 4)[:, :3]
        return self._sample_points

    def samples_near(self, points: Sequence[tuple[float, float]], within_m: float) -> list[tuple[int, str]]:
        """The samples whose middles are within a distance of points in the plane, each with its point's number."""
        if not points:
            return []
        pairs = near(np.array(points), self.sample_points(), within_m)
        return [(n, self._names[m]) for n, m in pairs.tolist()]

    def sample_heading(self, sample: str) -> float:
        """The direction that a long sample lies in."""
        return self._poses.of(self._samples[sample])[3]

    def sample_velocity(self, sample: str) -> tuple[float, float]:
        """How a ball rolls; (0, 0) of any other sample."""
        body = self._samples[sample]
        if body not in self._balls:
            return (0.0, 0.0)
        (x_m_s, y_m_s, _), _ = pybullet.getBaseVelocity(body, physicsClientId=self.client)
        return (x_m_s, y_m_s)

    @property
    def is_rolling(self) -> bool:
        """True while a sample rolls."""
        return any(any(self.sample_velocity(sample)) for sample in self._names)

    def drive(self, rover: str, linear_m_s: float, angular_rad_s: float, sideways_m_s: float = 0.0) -> None:
        """Set a rover's velocity for the coming tick, along its own heading and to the left of it."""
        heading = self._poses.of(self._rovers[rover])[3]
        pybullet.resetBaseVelocity(
            self._rovers[rover],
            [
                linear_m_s * cos(heading) - sideways_m_s * sin(heading),
                linear_m_s * sin(heading) + sideways_m_s * cos(heading),
                0.0,
            ],
            [0.0, 0.0, angular_rad_s],
            physicsClientId=self.client,
        )

    def put_rover(self, rover: str, pose: Pose) -> None:
        """Stand a rover somewhere else at once."""
        self._place(self._rovers[rover], (pose.x_m, pose.y_m, ROVER_HEIGHT_M / 2), pose.heading_rad)

    def put_foreign(self, robot: str, pose: Pose) -> None:
        """Stand a robot that is not simulated somewhere: too heavy to be pushed, and shaped as a rover (our choice)."""
        middle = (pose.x_m, pose.y_m, ROVER_HEIGHT_M / 2)
        if robot in self._foreign:
            self._place(self._foreign[robot], middle, pose.heading_rad)
        else:
            body = self._add(0.0, self._rover_shape, middle, pose.heading_rad)
            self._collide(body, ROVERS, MOVABLE)
            self._foreign[robot] = body

    def make_intangible(self, rover: str) -> None:
        """From now on the rover only marks its pose: it collides with nothing, and no ray hits it."""
        self._collide(self._rovers[rover], 0, 0)

    def step(self) -> None:
        """Advance by one tick of 1/60 s and put every body that moved back into its plane."""
        pybullet.stepSimulation(physicsClientId=self.client)
        contacts = pybullet.getContactPoints(physicsClientId=self.client) or ()
        self._pressed = frozenset(
            body for contact in contacts if contact[8] < PRESSES_M for body in contact[1:3]
        )
        # NOTE: without gravity, only rovers and bodies that something touches move.
        pushed = {body for contact in contacts for body in contact[1:3]}
        self._sample_points = None if pushed else self._sample_points
        for body in pushed:
            self._poses.invalidate(body)
        for body in self._rovers.values():
            self._poses.level(body, ROVER_HEIGHT_M / 2)
        for sample, body in self._samples.items():
            if body in pushed and sample not in self._held and body not in self._balls:
                self._stop_pushed(body, SAMPLE_HEIGHT_M / 2)
        for body, ball in self._balls.items():
            self._roll(body, ball)

    def lift(self, sample: str) -> None:
        """A sample in jaws touches nothing; `carry` moves it."""
        self._held.add(sample)
        self._collide(self._samples[sample], 0, 0)

    def carry(self, sample: str, point: tuple[float, float], heading_rad: float = 0.0) -> None:
        """Move a lifted sample to a point in the plane."""
        self._place(self._samples[sample], (*point, LIFTED_M), heading_rad)

    def contacts(self, sample: str) -> list[tuple[tuple[float, float], tuple[float, float], float]]:
        """Where walls and rocks overlap a lifted sample: point, unit normal towards it, depth in metres."""
        body = self._samples[sample]
        found = []
        for solid in self._solid:
            for close in pybullet.getClosestPoints(body, solid, 0.0, physicsClientId=self.client):
                found.append((close[5][:2], close[7][:2], -close[8]))
        return found

    def set_down(self, sample: str, point: tuple[float, float], heading_rad: float = 0.0) -> None:
        """Stand a lifted sample on the floor, where it is solid again."""
        self._held.discard(sample)
        body = self._samples[sample]
        ball = self._balls.get(body)
        self._collide(body, LOW if ball else SAMPLES, EVERYTHING)
        self._place(body, (*point, ball.radius_m if ball else SAMPLE_HEIGHT_M / 2), heading_rad)
        pybullet.resetBaseVelocity(body, [0, 0, 0], [0, 0, 0], physicsClientId=self.client)

    def cut(self, *, height_m: float, groups: int) -> Cut:
        """The cross-section of the bodies of these groups at a height, for rays in that plane."""
        return self._shapes.cut(self._poses.of, height_m=height_m, groups=groups)

    def touched(self, rover: str) -> bool:
        """True while the rover's body or jaws press against anything."""
        return self._rovers[rover] in self._pressed

    def put_box(
        self, point: tuple[float, float], heading_rad: float, *, side_m: float, height_m: float
    ) -> int:
        """Stand a box on the floor, too heavy to be pushed; it blocks whiskers and, if tall, the line of sight."""
        shape = bullet.box(self.client, side_m, side_m, height_m)
        body = self._add(0.0, shape, (*point, height_m / 2), heading_rad)
        self._collide(body, WALLS, MOVABLE)
        return body

    def put_rock(self, rock: Rock) -> None:
        """Stand a rock on the floor, too heavy to be pushed; it blocks whiskers, not the line of sight."""
        shape = bullet.cylinder(self.client, rock.radius_m, ROCK_HEIGHT_M)
        self._add_solid(shape, (*rock.point, ROCK_HEIGHT_M / 2), 0.0)

    def put_ball(self, point: tuple[float, float], *, radius_m: float, rolling_m_s2: float) -> int:
        """Lay a light ball on the floor, below the whiskers' plane; pushed, it rolls until the floor has stopped it."""
        return self._add_ball(point, Ball(radius_m=radius_m, rolling_m_s2=rolling_m_s2))

    def put_panel(self, panel: Panel) -> int:
        """Close a doorway by a panel that `raise_panel` moves; it blocks rovers and rays as a wall does."""
        shape = bullet.box(self.client, panel.length_m, WALL_THICKNESS_M, WALL_HEIGHT_M)
        body = self._add_solid(shape, self._middle_of(panel), _heading_of(panel))
        self._lowered[body] = panel
        return body

    def raise_panel(self, body: int, panel: Panel, share: float) -> None:
        """Raise a panel by a share of its height: 0 it stands on the floor, 1 rovers and rays pass under it."""
        x, y, z = self._middle_of(panel)
        self._poses.place(body, (x, y, z + share * RAISED_M), _heading_of(panel))
        if share * RAISED_M < ROVER_HEIGHT_M:
            self._lowered[body] = panel
        else:
            self._lowered.pop(body, None)

    def is_under(self, panel: Panel) -> str:
        """What stands in a panel's way to the floor: a rover or a sample; empty if nothing does."""
        for name, body in self._rovers.items():
            x, y, _, _ = self._poses.of(body)
            if panel.distance_m((x, y)) < RADIUS_M + WALL_THICKNESS_M / 2:
                return name
        for name, body in self._samples.items():
            x, y, _, _ = self._poses.of(body)
            if panel.distance_m((x, y)) < SAMPLE_RADIUS_M + WALL_THICKNESS_M / 2:
                return name
        return ""

    @staticmethod
    def _middle_of(panel: Panel) -> Point3:
        (x0, y0), (x1, y1) = panel.start, panel.end
        return ((x0 + x1) / 2, (y0 + y1) / 2, WALL_HEIGHT_M / 2)

    def put_beacon(self, point: tuple[float, float]) -> None:
        """Mark a place. Nothing meets the mark, nor the beacon above it: only pictures show them."""
        self._beacons.append(point)

    def picture(self, rover: str, *, width: int, height: int, view_deg: float) -> Pixels:
        """What a rover's camera sees straight ahead, without the rover itself."""
        colours = dict.fromkeys([*self._rovers.values(), *self._foreign.values()], ROVER_COLOUR)
        colours |= dict.fromkeys(self._samples.values(), SAMPLE_COLOUR)
        del colours[self._rovers[rover]]
        bodies = [*colours, *self._solid]
        shapes = [
            Seen(shape, self._poses.of(body), colours.get(body, _colour_of(shape)))
            for body in bodies
            for shape in self._shapes.of(body)
        ]
        for x, y in self._beacons:
            shapes += (Seen(shape, (x, y, 0.0, 0.0), colour) for shape, colour in BEACON)
        return picture(
            shapes, self.pose(rover), height_m=CAMERA_HEIGHT_M, width=width, height=height, view_deg=view_deg
        )

    def remove(self, body: int) -> None:
        """Remove a box or ball."""
        self._balls.pop(body, None)
        self._poses.invalidate(body)
        self._shapes.remove(body)
        pybullet.removeBody(body, physicsClientId=self.client)

    def point_of(self, body: int) -> tuple[float, float]:
        """The true middle of a box or ball."""
        place, _ = pybullet.getBasePositionAndOrientation(body, physicsClientId=self.client)
        return (place[0], place[1])

    def meets(self, rover: str, body: int) -> bool:
        """True while a rover presses against a box or ball."""
        contacts = pybullet.getContactPoints(self._rovers[rover], body, physicsClientId=self.client)
        return any(contact[8] < PRESSES_M for contact in contacts)

    def close(self) -> None:
        self._disconnect()

    def _add_wall(self, panel: Panel) -> None:
        shape = bullet.box(self.client, panel.length_m, WALL_THICKNESS_M, WALL_HEIGHT_M)
        self._add_solid(shape, self._middle_of(panel), _heading_of(panel))

    def _add_solid(self, shape: int, middle: Point3, heading_rad: float) -> int:
        """An obstacle too heavy to be pushed."""
        body = self._add(0.0, shape, middle, heading_rad)
        self._collide(body, WALLS, MOVABLE)
        self._solid.append(body)
        return body

    def _add_rover(self, shape: int, pose: Pose) -> int:
        body = self._add(ROVER_MASS_KG, shape, (pose.x_m, pose.y_m, ROVER_HEIGHT_M / 2), pose.heading_rad)
        # NOTE: resistance to roll and pitch stands for wheels on the floor.
        self._tune(body, localInertiaDiagonal=[1e4, 1e4, ROVER_INERTIA_KG_M2], lateralFriction=0.1)
        self._collide(body, ROVERS, EVERYTHING)
        return body

    def _add_ball(self, point: tuple[float, float], ball: Ball) -> int:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_SPHERE, radius=ball.radius_m, physicsClientId=self.client
        )
        body = self._add(0.2, shape, (*point, ball.radius_m), 0.0)
        self._tune(body, lateralFriction=0.1)
        self._collide(body, LOW, EVERYTHING)
        self._balls[body] = ball
        return body

    def _add_sample(self, placed: Placed) -> int:
        if placed.rolling_m_s2:
            rolling = Ball(radius_m=BALL_RADIUS_M, rolling_m_s2=placed.rolling_m_s2)
            body = self._add_ball(placed.point, rolling)
            pybullet.resetBaseVelocity(
                body, [*placed.velocity_m_s, 0], [0, 0, 0], physicsClientId=self.client
            )
            return body
        if placed.length_m:
            shape = bullet.box(self.client, placed.length_m, BEAM_WIDTH_M, SAMPLE_HEIGHT_M)
        else:
            shape = bullet.cylinder(self.client, SAMPLE_RADIUS_M, SAMPLE_HEIGHT_M)
        body = self._add(0.5, shape, (*placed.point, SAMPLE_HEIGHT_M / 2), placed.heading_rad)
        self._tune(body, lateralFriction=0.1)
        self._collide(body, SAMPLES, EVERYTHING)
        return body

    def _add(self, mass_kg: float, shape: int, middle: Point3, heading_rad: float) -> int:
        turn = pybullet.getQuaternionFromEuler([0.0, 0.0, heading_rad])
        body: int = pybullet.createMultiBody(mass_kg, shape, -1, middle, turn, physicsClientId=self.client)
        self._shapes.put(body, pybullet.getCollisionShapeData(body, -1, physicsClientId=self.client))
        return body

    def _tune(self, body: int, **properties: Any) -> None:
        pybullet.changeDynamics(
            body,
            -1,
            linearDamping=0.0,
            angularDamping=0.0,
            restitution=0.0,
            physicsClientId=self.client,
            **properties,
        )

    def _collide(self, body: int, group: int, mask: int) -> None:
        pybullet.setCollisionFilterGroupMask(body, -1, group, mask, physicsClientId=self.client)
        self._shapes.regroup(body, group)

    def _place(self, body: int, middle: Point3, heading_rad: float) -> None:
        self._poses.place(body, middle, heading_rad)
        self._sample_points = None

    def _stop_pushed(self, body: int, height_m: float) -> None:
        """Floor friction: what was pushed in this tick stands still at its end, upright."""
        linear, angular = pybullet.getBaseVelocity(body, physicsClientId=self.client)
        if any(linear) or any(angular):
            x, y, _, heading = self._poses.of(body)
            self._place(body, (x, y, height_m), heading if body in self._long_bodies else 0.0)
            pybullet.resetBaseVelocity(body, [0, 0, 0], [0, 0, 0], physicsClientId=self.client)

    def _roll(self, body: int, ball: Ball) -> None:
        """Rolling resistance: a ball loses the same speed in every tick, and stays on the floor."""
        (x_m_s, y_m_s, _), _ = pybullet.getBaseVelocity(body, physicsClientId=self.client)
        speed_m_s = hypot(x_m_s, y_m_s)
        if speed_m_s == 0.0:
            return
        kept = max(0.0, 1.0 - ball.rolling_m_s2 * TICK_S / speed_m_s)
        x, y = self.point_of(body)
        self._place(body, (x, y, ball.radius_m), 0.0)
        pybullet.resetBaseVelocity(
            body, [kept * x_m_s, kept * y_m_s, 0], [0, 0, 0], physicsClientId=self.client
        )


def _heading_of(panel: Panel) -> float:
    (x0, y0), (x1, y1) = panel.start, panel.end
    return atan2(y1 - y0, x1 - x0)


def _colour_of(shape: Shape) -> Colour:
    """The colour of what does not move: walls are boxes, rocks are round."""
    return WALL_COLOUR if shape.kind == pybullet.GEOM_BOX else ROCK_COLOUR
