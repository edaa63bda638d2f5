"""The parts of the API's bodies that the view reads.

World frame: x to the east, y to the north, metres; headings in radians, counter-clockwise from east.
"""

from math import cos, hypot, sin

from pydantic import BaseModel, ConfigDict, Field

Point = tuple[float, float]

JAWS_AHEAD_M = 0.34
"""Distance from a robot's centre to the middle of its jaws."""


class ApiModel(BaseModel):
    """Base of all bodies: immutable, unknown keys ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class Floor(ApiModel):
    name: str
    x: Point
    y: Point
    aisles: tuple["Floor", ...] = ()


class Opening(ApiModel):
    kind: str
    at_m: float
    width_m: float


class Wall(ApiModel):
    start: Point
    end: Point
    openings: tuple[Opening, ...] = ()

    @property
    def length_m(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])


class Location(ApiModel):
    name: str
    kind: str
    at: Point
    approach_deg: tuple[float, ...] = ()


class Rack(Location):
    """A location with room for several samples; its berths are separate locations."""

    berths: tuple[str, ...] = ()


class Obstacle(ApiModel):
    name: str
    at: Point
    radius_m: float


class Zone(Floor):
    """An area of the floor with its rule; a slow one has the speed that robots keep to, m/s."""

    rule: str
    max_speed_m_s: float | None = None


class Sample(ApiModel):
    """A sample and its place at the start; a long one has a length."""

    name: str
    at: str
    length_m: float = 0.0


class RobotStart(ApiModel):
    """A robot and its pose at the start: x, y, metres, and heading, degrees."""

    name: str
    start: tuple[float, float, float]


class Stop(ApiModel):
    """A level of a lift, and the door of its cabin there, metres."""

    level: str
    start: Point
    end: Point


class Peripheral(ApiModel):
    """A door or hatch with its panel, or a lift with its stops, metres."""

    name: str
    kind: str
    start: Point | None = None
    end: Point | None = None
    stops: tuple[Stop, ...] = ()


class Layout(ApiModel):
    """A world's layout."""

    compartments: tuple[Floor, ...]
    walls: tuple[Wall, ...] = ()
    locations: tuple[Location, ...] = ()
    racks: tuple[Rack, ...] = ()
    robots: tuple[RobotStart, ...] = ()
    samples: tuple[Sample, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    slopes: tuple[Floor, ...] = ()
    zones: tuple[Zone, ...] = ()
    peripherals: tuple[Peripheral, ...] = ()

    @property
    def berths(self) -> frozenset[str]:
        """The names of the locations that are berths of a rack."""
        return frozenset(berth for rack in self.racks for berth in rack.berths)

    @property
    def bounds(self) -> tuple[Point, Point]:
        """The lowest and highest corner of all floors, metres."""
        low = (min(c.x[0] for c in self.compartments), min(c.y[0] for c in self.compartments))
        high = (max(c.x[1] for c in self.compartments), max(c.y[1] for c in self.compartments))
        return low, high


class Fact(ApiModel):
    predicate: str
    args: tuple[str, ...] = ()


class RobotTelemetry(ApiModel):
    """One robot's telemetry.

    `ranges_m`: shape (N,), metres, beam 0 ahead, counter-clockwise, None where nothing is in range.
    """

    x_m: float
    y_m: float
    heading_rad: float
    ranges_m: tuple[float | None, ...] = ()
    holding: str | None = None
    packet_tag: str | None = None
    packet_state: str | None = None
    tags: dict[str, Point] = Field(default_factory=dict)
    at_s: float = 0.0

    @property
    def jaws(self) -> Point:
        """The middle of the jaws, world frame, metres."""
        ahead = (JAWS_AHEAD_M * cos(self.heading_rad), JAWS_AHEAD_M * sin(self.heading_rad))
        return self.x_m + ahead[0], self.y_m + ahead[1]


class Telemetry(ApiModel):
    """All robots of a world at one time of its clock."""

    time_s: float = 0.0
    robots: dict[str, RobotTelemetry] = Field(default_factory=dict)


class PlannedAction(ApiModel):
    """An action of a plan."""

    id: str
    agents: tuple[str, ...] = ()
    arguments: dict[str, str] = Field(default_factory=dict)
    earliest_start_s: float = 0.0


class Plan(ApiModel):
    id: str
    actions: tuple[PlannedAction, ...] = ()


class ReplayInstant(ApiModel):
    """An instant of a mission's recording, by the world's clock."""

    mission_id: str
    time_s: float


class PageState(ApiModel):
    """What a page shows: its world (None: the first one), its selection, its camera.

    `whole` counts the requests to show the whole world; `seen` is false while the view is not visible.
    """

    world: str | None = None
    robot: str | None = None
    sample: str | None = None
    plan_id: str | None = None
    action: str | None = None
    follow: bool = False
    whole: int = 0
    replay: ReplayInstant | None = None
    seen: bool = True
    dark: bool = False
