"""The parts of a world file: compartments, walls, locations, robots and samples.

Metres, degrees where the name says so. World frame: x to the east, y to the north, headings counter-clockwise
from east.
"""

from collections.abc import Iterable
from math import hypot
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator
from typing_extensions import Self

from robots.data import Checked, StrEnum
from robots.wire import MAX_RULE_FILES, RuleText
from robots.world.bodies import BodySpec, PackageBodySpec, VelocityBodySpec, WheeledBodySpec
from robots.world.radio import LinkSpec
from robots.world.sensors import SensorSpec

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
Point = tuple[float, float]
Start = tuple[float, float, float]
"""Where a robot starts: x and y in metres, heading in degrees."""
Speed = Annotated[float, Field(gt=0, le=2)]
TurnRate = Annotated[float, Field(gt=0, le=6)]
Architecture = Literal["parallel", "sequential"]
SonarPart = Literal["real", "map", "virtual"]
Sonar = Annotated[tuple[SonarPart, ...], Field(min_length=1)]
Tuning = dict[str, dict[str, dict[str, float]]]
Interval = tuple[float, float]

Tag = Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9_]*$", max_length=64)]
"""A packet's; whether some packet has it is checked where a world is loaded for use, for packs bring packets."""
STORE_TAGS = ("NAVIGATE", "DOCK", "DOCK2", "TRANSPORT", "RELEASE1", "RELEASE2", "TRACK")
"""A robot's repertoire if its world file does not state it: all packets of the sample store but those of phases."""
PHASE_TAGS = (
    "NAVIGATE_OFF",
    "NAVIGATE_UP",
    "NAVIGATE_IN",
    "TRANSPORT_OFF",
    "TRANSPORT_UP",
    "TRANSPORT_IN",
    "DOCK2_OFF",
)
"""The packets by which a robot carries out an action in phases: it holds a place only while it uses it."""
ON_BORDER_M = 0.05
"""A point this far outside an area still lies on its border; locations nearer than this coincide."""
SHORTEST_M = 0.7
"""The least length of a long object: two robots grip it side by side."""
SLOWEST_M_S = 0.05
"""The least speed limit of a zone: below it a robot could not tell that it moves."""
FARTHEST_M = 100_000.0
"""The greatest coordinate of a zone: with far greater ones nothing can be drawn or computed."""
NARROWEST_PITCH_M = 0.45
"""The least pitch of berths: nearer ones a robot could not tell apart."""


class Aisle(Checked):
    """An allocated area of a compartment, x and y intervals in metres."""

    name: Name
    x: Interval
    y: Interval

    def contains(self, point: Point) -> bool:
        """True inside or on the border, so that an interchange in a wall belongs to both sides."""
        inside = (
            low - ON_BORDER_M <= value <= high + ON_BORDER_M
            for value, (low, high) in zip(point, (self.x, self.y), strict=True)
        )
        return all(inside)


class Compartment(Aisle):
    """A rectangle of floor, divided into aisles or not."""

    aisles: tuple[Aisle, ...] = ()


class Opening(Checked):
    """A gap in a wall, `at_m` metres from the wall's start to the gap's middle.

    door: closed to robots, samples are brought in from outside; hatch: narrow, samples pass, robots do not;
    gap: robots pass.
    """

    kind: Literal["door", "hatch", "gap"]
    at_m: float = Field(ge=0)
    width_m: float = Field(gt=0)


class Wall(Checked):
    """A straight wall between two points."""

    start: Point
    end: Point
    openings: tuple[Opening, ...] = ()

    @property
    def length_m(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])


class Location(Checked):
    """A named place on the floor with an infra-red beacon above it.

    `approach_deg` are the directions in which the beacon emits: a robot docks from there. `capacity` is how many
    samples may lie there: none at a home or at a `charger`, where any robot that reaches it is charged, one at a time.
    With room for several it is a row of berths around `at`, side by side as seen from the first of `approach_deg`,
    `berth_pitch_m` apart (default: as far as there is room).
    """

    name: Name
    kind: Literal["door", "interchange", "bay", "rack", "dock", "home", "charger", "lander", "place"]
    at: Point
    approach_deg: tuple[float, ...] = Field(min_length=1)
    capacity: int = Field(default=1, ge=0, le=100)
    berth_pitch_m: float | None = Field(default=None, ge=NARROWEST_PITCH_M)


class RoleSpec(Checked):
    """What a robot is for: the role that its rules believe it to play, and what it is recruited for.

    `tags`: the packets of its repertoire that plans may use it for; left out: all. `rules`: the text of the role's rule
    file (docs/rules.md); left out: that of its name among the robot's `rules`, if there is one.
    """

    name: Name
    tags: tuple[Tag, ...] | None = Field(default=None, max_length=256)
    rules: RuleText | None = None


class RobotSpec(Checked):
    """A robot of the team: start is x, y in metres and heading in degrees; `body` is a kind, or one with its measures.

    `battery`: the share of its charge that it starts with; `battery_wh`: what it holds when full, watt-hours.
    `architecture`: sensing in parallel with acting, or in turn. `whisker_least_m`: the shortest range read.
    `sonar`: the range sensors, in order: its whiskers or, in their place, the echoes of the map's walls, and a virtual
    sonar that detects avatars.
    `sensors`: further ones: cameras, and those of installed packages.
    `senses`: predicates whose facts it perceives of others' work, such as `in` and `clear`; left out: those that its
    sensors perceive; none of an `external` robot. What it does not perceive it is told by clearance.
    `speaks`: what it says to other robots or the service and takes from them, such as `clearance` and `bids`; left out:
    all that its software can; nothing of an `external` robot. Robots hear each other if the world has a `peer_link`.
    `tuning`: by packet and behaviour pattern ("rotate/steer"), parameters to override ("stimulus.full_rad").
    `rules`: the rule files that it starts with, the text of each by the name of its agent or role, in order of rank
    (docs/rules.md). A world file lists shipped ones by name, and others as paths relative to it.
    `role`: its role, or only the role's name.
    `link`: its radio, with the world's `link` as default for each value.
    `external`: software of its own speaks for it on the link; it is not simulated.
    """

    name: Name
    compartment: Name
    aisle: Name | None = None
    start: Start
    home: Name | None = None
    body: BodySpec = VelocityBodySpec()
    architecture: Architecture = "parallel"
    repertoire: tuple[Tag, ...] = STORE_TAGS
    speed_m_s: Speed = 0.5
    turn_rad_s: TurnRate = 1.5
    battery: float = Field(default=1.0, ge=0, le=1)
    battery_wh: float = Field(default=120.0, gt=0, le=1e5)
    whiskers: int = Field(default=16, ge=8, le=64)
    whisker_range_m: float = Field(default=2.5, gt=0.2, le=10)
    whisker_least_m: float = Field(default=0.0, ge=0, le=0.5)
    sonar: Sonar = ("real", "virtual")
    sensors: tuple[SensorSpec, ...] = ()
    senses: tuple[Name, ...] | None = Field(default=None, max_length=64)
    speaks: tuple[Name, ...] | None = Field(default=None, max_length=16)
    tuning: Tuning = Field(default_factory=dict)
    rules: dict[str, RuleText] = Field(default_factory=dict, max_length=MAX_RULE_FILES)
    role: RoleSpec | None = None
    link: LinkSpec | None = None
    external: bool = False

    @property
    def rule_files(self) -> dict[str, str]:
        """Its rules with its role's."""
        role = self.role
        return {
            **self.rules,
            **({role.name: role.rules} if role is not None and role.rules is not None else {}),
        }

    @field_validator("role", mode="before")
    @classmethod
    def _names_its_role(cls, role: Any) -> Any:
        return {"name": role} if isinstance(role, str) else role

    @model_validator(mode="after")
    def _wheels_are_fast_enough(self) -> Self:
        if isinstance(self.body, WheeledBodySpec | PackageBodySpec):
            self.body.check_speeds(self.name, linear_m_s=self.speed_m_s, angular_rad_s=self.turn_rad_s)
        return self

    @model_validator(mode="after")
    def _cameras_have_names_of_their_own(self) -> Self:
        cameras = [sensor.kind for sensor in self.sensors if sensor.takes_images]
        if doubles := {kind for kind in cameras if cameras.count(kind) > 1}:
            raise ValueError(
                f"{self.name} has several cameras of kind {', '.join(sorted(doubles))}; packets name a camera by its "
                "kind, so a robot has one of each"
            )
        return self


class Sample(Checked):
    """A tagged sample and where it lies at the start.

    One with a `length_m` is a long object that takes two robots: a bar with a handle at each end and its tag at the
    middle. It lies across the first approach direction of its place. 0 is a compact sample, which one robot carries.
    One with a `rolling_m_s2` is a ball: pushed, it rolls on, and the floor slows it down by so much. 0: it stands where
    it was pushed to.
    """

    name: Name
    at: Name
    length_m: float = Field(default=0.0, ge=0, le=3)
    rolling_m_s2: float = Field(default=0.0, ge=0, le=5)

    @field_validator("length_m")
    @classmethod
    def _two_robots_fit(cls, length_m: float) -> float:
        if 0 < length_m < SHORTEST_M:
            raise ValueError(
                f"two robots stand side by side at {SHORTEST_M} m or more; 0 is a compact sample"
            )
        return length_m

    @model_validator(mode="after")
    def _is_long_or_rolls(self) -> Self:
        if self.length_m and self.rolling_m_s2:
            raise ValueError(f"{self.name} is long: only compact samples roll")
        return self


class Delivery(Sample):
    """A sample that is brought from outside `after_s` seconds after the world's start, once its place is free.

    Nobody is told of it: it is known once a robot has seen it lie there.
    """

    after_s: float = Field(ge=0)


class Obstacle(Checked):
    """A round rock on the floor that is on no robot's map: whiskers detect it, infra-red passes above it.

    `jitter_m`: how far from `at` a seed may put it.
    """

    name: Name
    at: Point
    radius_m: float = Field(gt=0, le=2)
    jitter_m: float = Field(default=0.0, ge=0, le=2)


class Rectangle(Checked):
    """A rectangle of the floor, x and y intervals in metres."""

    name: Name
    x: Interval
    y: Interval

    def contains(self, point: Point) -> bool:
        """True inside or on the border."""
        return self.x[0] <= point[0] <= self.x[1] and self.y[0] <= point[1] <= self.y[1]

    def grown(self, by_m: float) -> "Rectangle":
        """The same and what lies within `by_m` of its sides."""
        (left, right), (low, high) = self.x, self.y
        return Rectangle(name=self.name, x=(left - by_m, right + by_m), y=(low - by_m, high + by_m))

    @model_validator(mode="after")
    def _has_an_extent(self) -> Self:
        for axis, (low, high) in (("x", self.x), ("y", self.y)):
            if high <= low:
                raise ValueError(f"{axis}: {high:g} must be greater than {low:g}")
        return self


class ZoneRule(StrEnum):
    """What holds within a zone."""

    NAMED = "named"
    """Nothing: goals name it."""
    KEEP_OUT = "keep_out"
    """Robots stay out, and nothing is put or taken there. One that is inside may leave."""
    ONE_ROBOT = "one_robot"
    """At most one robot is inside at a time."""
    SLOW = "slow"
    """Robots inside keep to the zone's `max_speed_m_s`."""


class Zone(Rectangle):
    """A named area of the floor with its rule. Goals name its places by it, and robots have it on their map."""

    rule: ZoneRule = ZoneRule.NAMED
    max_speed_m_s: float | None = Field(default=None, ge=SLOWEST_M_S, le=2)

    @model_validator(mode="after")
    def _limits_the_speed_if_slow(self) -> Self:
        if (self.rule is ZoneRule.SLOW) != (self.max_speed_m_s is not None):
            raise ValueError(f"{self.name}: max_speed_m_s is of zones with the rule slow, and only of those")
        return self

    def misplaced(self, compartments: Iterable[Aisle]) -> str:
        """Why it is no zone of a world with these compartments; empty if it is one. Not asked of recorded worlds."""
        if max(map(abs, (*self.x, *self.y))) > FARTHEST_M:
            return f"{self.name} reaches farther than {FARTHEST_M:.0f} m"
        return "" if any(map(self._meets, compartments)) else f"{self.name} lies in no compartment"

    def _meets(self, other: Aisle) -> bool:
        """True if the two have some floor in common."""
        return all(
            low < farthest and nearest < high
            for (low, high), (nearest, farthest) in zip((self.x, self.y), (other.x, other.y), strict=True)
        )


class Slope(Rectangle):
    """Sloping ground; robots drive on it at `pace`, a share of their speed. It is on no robot's map."""

    pace: float = Field(ge=0.1, le=1)


class WorldNumber(Checked):
    """An initial number, such as the last reading of a sensor at a place; robots' batteries are theirs."""

    quantity: str
    args: tuple[str, ...] = Field(min_length=1)
    value: float = Field(allow_inf_nan=False, strict=True)


class WorldFact(Checked):
    """An extra initial fact, in rel/ref form."""

    predicate: str
    args: tuple[str, ...] = ()
