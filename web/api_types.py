"""What the view reads of a world and of its robots' telemetry: the service's JSON, unknown keys left alone.

World frame: x to the east, y to the north, metres; headings in radians, counter-clockwise from east.
"""

from math import cos, hypot, sin

from pydantic import BaseModel, ConfigDict, Field

Point = tuple[float, float]

JAWS_AHEAD_M = 0.34
"""From a rover's centre to the middle of its jaws."""


class Part(BaseModel):
    """Base of every part: immutable; what the view does not know, it does not read."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class Floor(Part):
    name: str
    x: Point
    y: Point
    aisles: tuple["Floor", ...] = ()


class Opening(Part):
    kind: str
    at_m: float
    width_m: float


class Wall(Part):
    start: Point
    end: Point
    openings: tuple[Opening, ...] = ()

    @property
    def length_m(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])


class Location(Part):
    name: str
    kind: str
    at: Point
    approach_deg: tuple[float, ...] = ()


class Rack(Location):
    """A location with room for several samples; its berths are locations of their own."""

    berths: tuple[str, ...] = ()


class Named(Part):
    name: str


class Rock(Named):
    """An obstacle on the floor."""

    at: Point
    radius_m: float


class Lying(Named):
    """A sample and where it lies at the start; a long one has a length."""

    at: str
    length_m: float = 0.0


class Start(Named):
    start: tuple[float, float, float]


class Layout(Part):
    """A world as the service hands it out."""

    compartments: tuple[Floor, ...]
    walls: tuple[Wall, ...] = ()
    locations: tuple[Location, ...] = ()
    racks: tuple[Rack, ...] = ()
    robots: tuple[Start, ...] = ()
    samples: tuple[Lying, ...] = ()
    obstacles: tuple[Rock, ...] = ()

    @property
    def berths(self) -> frozenset[str]:
        """The locations that are berths."""
        return frozenset(berth for rack in self.racks for berth in rack.berths)

    @property
    def bounds(self) -> tuple[Point, Point]:
        """The lowest and highest corner of all floors, metres."""
        low = (min(c.x[0] for c in self.compartments), min(c.y[0] for c in self.compartments))
        high = (max(c.x[1] for c in self.compartments), max(c.y[1] for c in self.compartments))
        return low, high


class Fact(Part):
    predicate: str
    args: tuple[str, ...] = ()


class RobotTelemetry(Part):
    """What one robot says of itself.

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
        """The middle of the jaws in the world's frame."""
        ahead = (JAWS_AHEAD_M * cos(self.heading_rad), JAWS_AHEAD_M * sin(self.heading_rad))
        return self.x_m + ahead[0], self.y_m + ahead[1]


class Telemetry(Part):
    """All robots of a world at one time of its clock."""

    time_s: float = 0.0
    robots: dict[str, RobotTelemetry] = Field(default_factory=dict)


class PlannedAction(Part):
    """An action of a plan, as far as it says who goes where and when."""

    id: str
    agents: tuple[str, ...] = ()
    arguments: dict[str, str] = Field(default_factory=dict)
    earliest_start_s: float = 0.0


class Plan(Part):
    id: str
    actions: tuple[PlannedAction, ...] = ()


class Cursor(Part):
    """An instant of a mission's recording, by the world's clock."""

    mission_id: str
    time_s: float


class Shown(Part):
    """What a page shows: its world (None: the first there is), what is selected, where the camera is to be.

    `seen`: false while nobody sees the view there, and nothing needs to be drawn.
    """

    world: str | None = None
    robot: str | None = None
    sample: str | None = None
    plan_id: str | None = None
    action: str | None = None
    follow: bool = False
    whole: int = 0
    replay: Cursor | None = None
    seen: bool = True
    dark: bool = False
