"""The physical scene in PyBullet: walls, rovers and samples as rigid bodies that move in the plane.

Frames and units: world frame of the world file, metres, radians, counter-clockwise.
Our choices: there is no gravity; every body is held in its plane instead, and the floor's friction is so
strong that a sample moves only while it is pushed. Rovers are velocity-set: the solver lets walls and bodies
stop them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import atan2, cos, remainder, sin, tau
from typing import Any

from robots.body import GRIPPER_REACH_M, RADIUS_M, Pose
from robots.world.walls import WALL_THICKNESS_M, Panel
from sim.quiet import quietly

with quietly():
    import pybullet

TICK_S = 1 / 60
SUBSTEPS = 4  # of 1/240 s each

WALL_HEIGHT_M = 0.6
ROCK_HEIGHT_M = 0.4
"""Higher than a held sample, lower than the infra-red's lines of sight."""
ROVER_HEIGHT_M = 0.3
ROVER_MASS_KG = 20.0
ROVER_INERTIA_KG_M2 = 0.5
"""About its vertical axis."""
SAMPLE_RADIUS_M = 0.06
SAMPLE_HEIGHT_M = 0.15
BEAM_WIDTH_M = 0.06
LIFTED_M = 0.245
"""Height of a held sample's middle: its foot passes above standing samples and above the whiskers' plane."""

WALLS, ROVERS, SAMPLES, LOW = 1, 2, 4, 8  # collision groups; LOW: below the whiskers' plane
AUDIBLE = WALLS | ROVERS | SAMPLES
EVERYTHING = AUDIBLE | LOW

Point3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Placed:
    """Where a sample stands: its middle; of a long one its length, and the direction that it lies in."""

    point: tuple[float, float]
    length_m: float = 0.0
    heading_rad: float = 0.0


class Scene:
    """One PyBullet world without a window. Bodies are known by their names in the world file."""

    def __init__(
        self, panels: Sequence[Panel], rovers: Mapping[str, Pose], samples: Mapping[str, Placed]
    ) -> None:
        self._client: int = pybullet.connect(pybullet.DIRECT)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=TICK_S,
            numSubSteps=SUBSTEPS,
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )
        self._solid: list[int] = []
        for panel in panels:
            self._add_wall(panel)
        shape = self._rover_shape()
        self._rovers = {name: self._add_rover(shape, pose) for name, pose in rovers.items()}
        self._samples = {name: self._add_sample(placed) for name, placed in samples.items()}
        self._long = frozenset(self._samples[name] for name, placed in samples.items() if placed.length_m)
        self._held: set[str] = set()
        self._balls: dict[int, float] = {}

    def pose(self, rover: str) -> Pose:
        """A rover's true pose."""
        (x, y, _), turn = pybullet.getBasePositionAndOrientation(
            self._rovers[rover], physicsClientId=self._client
        )
        return Pose(x_m=x, y_m=y, heading_rad=_about_z(turn))

    def sample_point(self, sample: str) -> Point3:
        """A sample's true middle."""
        place, _ = pybullet.getBasePositionAndOrientation(self._samples[sample], physicsClientId=self._client)
        return (place[0], place[1], place[2])

    def sample_heading(self, sample: str) -> float:
        """The direction that a long sample lies in."""
        return self._heading(self._samples[sample])

    def drive(self, rover: str, linear_m_s: float, angular_rad_s: float, sideways_m_s: float = 0.0) -> None:
        """Give a rover its velocity for the coming tick, along its own heading and to the left of it."""
        heading = self.pose(rover).heading_rad
        pybullet.resetBaseVelocity(
            self._rovers[rover],
            [
                linear_m_s * cos(heading) - sideways_m_s * sin(heading),
                linear_m_s * sin(heading) + sideways_m_s * cos(heading),
                0.0,
            ],
            [0.0, 0.0, angular_rad_s],
            physicsClientId=self._client,
        )

    def put_rover(self, rover: str, pose: Pose) -> None:
        """Stand a rover somewhere else at once."""
        self._place(self._rovers[rover], (pose.x_m, pose.y_m, ROVER_HEIGHT_M / 2), pose.heading_rad)

    def disembody(self, rover: str) -> None:
        """From now on a rover only marks its pose: it meets nothing, and no ray meets it."""
        self._collide(self._rovers[rover], 0, 0)

    def step(self) -> None:
        """Advance by one tick of 1/60 s and put every body back into its plane."""
        pybullet.stepSimulation(physicsClientId=self._client)
        for rover, body in self._rovers.items():
            pose = self.pose(rover)
            self._place(body, (pose.x_m, pose.y_m, ROVER_HEIGHT_M / 2), pose.heading_rad)
        for sample, body in self._samples.items():
            if sample not in self._held:
                self._settle(body, SAMPLE_HEIGHT_M / 2)
        for body, radius_m in self._balls.items():
            self._settle(body, radius_m)

    def lift(self, sample: str) -> None:
        """A sample in jaws touches nothing; `carry` moves it."""
        self._held.add(sample)
        self._collide(self._samples[sample], 0, 0)

    def carry(self, sample: str, point: tuple[float, float], heading_rad: float = 0.0) -> None:
        """Move a lifted sample to a point in the plane."""
        self._place(self._samples[sample], (*point, LIFTED_M), heading_rad)

    def presses(self, sample: str) -> list[tuple[tuple[float, float], tuple[float, float], float]]:
        """Where walls and rocks press against a lifted sample: point, unit normal towards it, depth in metres."""
        body, found = self._samples[sample], []
        for solid in self._solid:
            for close in pybullet.getClosestPoints(body, solid, 0.0, physicsClientId=self._client):
                found.append((close[5][:2], close[7][:2], -close[8]))
        return found

    def set_down(self, sample: str, point: tuple[float, float], heading_rad: float = 0.0) -> None:
        """Stand a lifted sample on the floor, where it is solid again."""
        self._held.discard(sample)
        self._collide(self._samples[sample], SAMPLES, EVERYTHING)
        self._place(self._samples[sample], (*point, SAMPLE_HEIGHT_M / 2), heading_rad)

    def cast(self, starts: Sequence[Point3], ends: Sequence[Point3], *, mask: int) -> list[float]:
        """The share of each ray that is free of bodies of the masked groups; 1 where nothing is hit."""
        if not starts:
            return []
        hits = pybullet.rayTestBatch(starts, ends, collisionFilterMask=mask, physicsClientId=self._client)
        return [hit[2] for hit in hits]

    def touched(self, rover: str) -> bool:
        """True while the rover's body or jaws press against anything."""
        contacts = pybullet.getContactPoints(bodyA=self._rovers[rover], physicsClientId=self._client)
        return any(contact[8] < 1e-3 for contact in contacts)

    def put_box(
        self, point: tuple[float, float], heading_rad: float, *, side_m: float, height_m: float
    ) -> int:
        """Stand a box on the floor, too heavy to be pushed; it blocks whiskers and, if tall, the line of sight."""
        half = [side_m / 2, side_m / 2, height_m / 2]
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half, physicsClientId=self._client
        )
        body = self._add(0.0, shape, (*point, height_m / 2), heading_rad)
        self._collide(body, WALLS, EVERYTHING)
        return body

    def put_rock(self, point: tuple[float, float], *, radius_m: float) -> int:
        """Stand a round rock on the floor, too heavy to be pushed; it blocks whiskers, not the line of sight."""
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=radius_m, height=ROCK_HEIGHT_M, physicsClientId=self._client
        )
        body = self._add(0.0, shape, (*point, ROCK_HEIGHT_M / 2), 0.0)
        self._collide(body, WALLS, EVERYTHING)
        self._solid.append(body)
        return body

    def put_ball(self, point: tuple[float, float], *, radius_m: float) -> int:
        """Lay a light ball on the floor, below the whiskers' plane; it moves only while it is pushed."""
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_SPHERE, radius=radius_m, physicsClientId=self._client
        )
        body = self._add(0.2, shape, (*point, radius_m), 0.0)
        self._tune(body, lateralFriction=0.1)
        self._collide(body, LOW, EVERYTHING)
        self._balls[body] = radius_m
        return body

    def take_away(self, body: int) -> None:
        """Remove a box or ball."""
        self._balls.pop(body, None)
        pybullet.removeBody(body, physicsClientId=self._client)

    def point_of(self, body: int) -> tuple[float, float]:
        """The true middle of a box or ball."""
        place, _ = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
        return (place[0], place[1])

    def meets(self, rover: str, body: int) -> bool:
        """True while a rover presses against a box or ball."""
        contacts = pybullet.getContactPoints(self._rovers[rover], body, physicsClientId=self._client)
        return any(contact[8] < 1e-3 for contact in contacts)

    def close(self) -> None:
        pybullet.disconnect(physicsClientId=self._client)

    def _add_wall(self, panel: Panel) -> None:
        (x0, y0), (x1, y1) = panel.start, panel.end
        half = [panel.length_m / 2, WALL_THICKNESS_M / 2, WALL_HEIGHT_M / 2]
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half, physicsClientId=self._client
        )
        middle = ((x0 + x1) / 2, (y0 + y1) / 2, WALL_HEIGHT_M / 2)
        body = self._add(0.0, shape, middle, atan2(y1 - y0, x1 - x0))
        self._collide(body, WALLS, EVERYTHING)
        self._solid.append(body)

    def _rover_shape(self) -> int:
        """A round body with its jaws ahead, which pass over standing samples but not through walls."""
        # NOTE: jaws end short of their grip's middle, so that two rovers' jaws can meet at one sample.
        inside, tip = RADIUS_M - 0.04, GRIPPER_REACH_M - SAMPLE_RADIUS_M / 2
        jaws = [(tip - inside) / 2, SAMPLE_RADIUS_M, 0.05]
        shape: int = pybullet.createCollisionShapeArray(
            shapeTypes=[pybullet.GEOM_CYLINDER, pybullet.GEOM_BOX],
            radii=[RADIUS_M, 0.0],
            lengths=[ROVER_HEIGHT_M, 0.0],
            halfExtents=[[0.0, 0.0, 0.0], jaws],
            collisionFramePositions=[[0, 0, 0], [(tip + inside) / 2, 0, LIFTED_M - ROVER_HEIGHT_M / 2]],
            physicsClientId=self._client,
        )
        return shape

    def _add_rover(self, shape: int, pose: Pose) -> int:
        body = self._add(ROVER_MASS_KG, shape, (pose.x_m, pose.y_m, ROVER_HEIGHT_M / 2), pose.heading_rad)
        # NOTE: resistance to roll and pitch stands for wheels on the floor.
        self._tune(body, localInertiaDiagonal=[1e4, 1e4, ROVER_INERTIA_KG_M2], lateralFriction=0.1)
        self._collide(body, ROVERS, EVERYTHING)
        return body

    def _add_sample(self, placed: Placed) -> int:
        height_m, client = SAMPLE_HEIGHT_M, self._client
        if placed.length_m:
            half = [placed.length_m / 2, BEAM_WIDTH_M / 2, height_m / 2]
            shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
        else:
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_CYLINDER, radius=SAMPLE_RADIUS_M, height=height_m, physicsClientId=client
            )
        body = self._add(0.5, shape, (*placed.point, SAMPLE_HEIGHT_M / 2), placed.heading_rad)
        self._tune(body, lateralFriction=0.1)
        self._collide(body, SAMPLES, EVERYTHING)
        return body

    def _add(self, mass_kg: float, shape: int, middle: Point3, heading_rad: float) -> int:
        turn = pybullet.getQuaternionFromEuler([0.0, 0.0, heading_rad])
        body: int = pybullet.createMultiBody(mass_kg, shape, -1, middle, turn, physicsClientId=self._client)
        return body

    def _tune(self, body: int, **properties: Any) -> None:
        pybullet.changeDynamics(
            body,
            -1,
            linearDamping=0.0,
            angularDamping=0.0,
            restitution=0.0,
            physicsClientId=self._client,
            **properties,
        )

    def _collide(self, body: int, group: int, mask: int) -> None:
        pybullet.setCollisionFilterGroupMask(body, -1, group, mask, physicsClientId=self._client)

    def _place(self, body: int, middle: Point3, heading_rad: float) -> None:
        turn = (0.0, 0.0, sin(heading_rad / 2), cos(heading_rad / 2))
        pybullet.resetBasePositionAndOrientation(body, middle, turn, physicsClientId=self._client)

    def _heading(self, body: int) -> float:
        _, turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
        return _about_z(turn)

    def _settle(self, body: int, height_m: float) -> None:
        """Floor friction: what was pushed in this tick stands still at its end, upright."""
        linear, angular = pybullet.getBaseVelocity(body, physicsClientId=self._client)
        if any(linear) or any(angular):
            (x, y, _), _ = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
            self._place(body, (x, y, height_m), self._heading(body) if body in self._long else 0.0)
            pybullet.resetBaseVelocity(body, [0, 0, 0], [0, 0, 0], physicsClientId=self._client)


def _about_z(turn: tuple[float, float, float, float]) -> float:
    """The heading of a body that only turns in the plane, by its quaternion x, y, z, w."""
    return remainder(2 * atan2(turn[2], turn[3]), tau)
