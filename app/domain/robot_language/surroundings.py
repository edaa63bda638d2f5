"""What a person's words to a robot may name: what this robot, and the world's model, know of the world now."""

from cmath import phase
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import hypot, inf, pi

from app.domain.world_model.beliefs import OBJECT_POSITION, Facts
from robots.repertoire import PacketSpec, Repertoire
from robots.wire import Telemetry
from robots.world import RobotSpec, WorldFile

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """One robot and what it can name. Points are in the world's frame, metres.

    :param packets: those that it can carry out, by name; of equal words the first counts.
    :param speed_m_s: of the robot, as `turn_rad_s`.
    :param places: the locations of its reach, by name, with their points; `kinds`: what each is called, such as "bay".
    :param kept_out: places that no robot enters, each with the zone's name.
    :param lies_at: by sample, the place or robot that it is believed to be in.
    :param seen: the samples that the robot sees now, with their points.
    :param pose: x, y and heading in radians, as the robot believes; None while it has sent no telemetry.
    """

    robot: str
    home: str | None
    speed_m_s: float
    turn_rad_s: float
    packets: tuple[PacketSpec, ...]
    places: Mapping[str, Point]
    kinds: Mapping[str, str]
    robots: Mapping[str, Point | None]
    samples: frozenset[str]
    kept_out: Mapping[str, str] = field(default_factory=dict)
    lies_at: Mapping[str, str] = field(default_factory=dict)
    seen: Mapping[str, Point] = field(default_factory=dict)
    pose: tuple[float, float, float] | None = None
    holding: str | None = None

    def point(self, name: str) -> Point | None:
        """Where something is, as far as that is known."""
        if name in self.seen:
            return self.seen[name]
        if (place := self.lies_at.get(name)) is not None and place in self.places:
            return self.places[place]
        return self.places.get(name) or self.robots.get(name)

    def range_m(self, name: str) -> float:
        """How far it is from the robot; infinite if that is not known."""
        at = self.point(name)
        return inf if at is None or self.pose is None else hypot(at[0] - self.pose[0], at[1] - self.pose[1])

    def bearing_rad(self, name: str) -> float:
        """Where it is as the robot looks, to the left positive; infinite if that is not known."""
        at = self.point(name)
        if at is None or self.pose is None:
            return inf
        x_m, y_m, heading_rad = self.pose
        turn = phase(complex(at[0] - x_m, at[1] - y_m)) - heading_rad
        return (turn + pi) % (2 * pi) - pi


def surroundings_of(
    robot: RobotSpec,
    world: WorldFile,
    facts: Facts,
    repertoire: Repertoire,
    *,
    telemetry: Telemetry | None,
    points: Mapping[str, Point],
) -> Surroundings:
    """What may be named to a robot now.

    :param telemetry: the robot's newest. :param points: of robots, as they have told.
    """
    reach = world.reach_of(robot)
    tags = set(robot.repertoire)
    packets = [
        spec for spec in repertoire.specs.values() if (spec.basic or spec.tag in tags) and not spec.long
    ]
    return Surroundings(
        robot=robot.name,
        home=robot.home,
        speed_m_s=robot.speed_m_s,
        turn_rad_s=robot.turn_rad_s,
        packets=tuple(sorted(packets, key=lambda spec: (spec.basic, spec.tag))),
        places={place.name: place.at for place in reach},
        kinds={place.name: place.kind for place in reach},
        robots={one.name: points.get(one.name) for one in world.robots},
        samples=frozenset(one.name for one in world.samples),
        kept_out=world.kept_out,
        lies_at={fact.args[0]: fact.args[2] for fact in facts if fact.predicate == OBJECT_POSITION},
        seen={} if telemetry is None else dict(telemetry.tags),
        pose=None if telemetry is None else (telemetry.x_m, telemetry.y_m, telemetry.heading_rad),
        holding=None if telemetry is None else telemetry.holding,
    )
