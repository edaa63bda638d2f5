"""A mission's recording, asked for any instant: where the robots were, what they held, where samples lay."""

from bisect import bisect_right
from collections.abc import Sequence
from math import remainder, tau
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import BeforeValidator, Field

from web.api_types import Fact, Layout, Part, Point, RobotTelemetry
from web.scene import Frame

EARLY_S = 0.5
"""A robot is drawn so long before its first row: rows are not at the same instant."""
TRAIL_S = 40.0


class Row(NamedTuple):
    """What a robot said at a time of the world's clock: where it was, what it held, its packet's tag."""

    at_s: float
    x_m: float
    y_m: float
    heading_rad: float
    holding: str | None = None
    packet_tag: str | None = None


def _known(row: Any) -> Any:
    """Of a row what is known of here; later columns are left alone as unknown keys are."""
    return row[: len(Row._fields)] if isinstance(row, list | tuple) else row


class World(Part):
    layout: Layout


class Lain(Part):
    """Where the samples lay from then on."""

    at_s: float
    lying: dict[str, str] = Field(default_factory=dict)


class Told(Part):
    """What a robot of the mission told beside where it was."""

    at_s: float
    ranges_m: tuple[float | None, ...] = ()


class Recording(Part):
    """As the service hands it out."""

    world: World
    robots: dict[str, tuple[Annotated[Row, BeforeValidator(_known)], ...]] = Field(default_factory=dict)
    telemetry: dict[str, tuple[Told, ...]] = Field(default_factory=dict)
    samples: tuple[Lain, ...] = ()

    def at(self, time_s: float) -> Frame:
        """The world at that time of its clock."""
        begun = {
            name: rows for name, rows in self.robots.items() if rows and rows[0].at_s <= time_s + EARLY_S
        }
        lay = _latest(self.samples, time_s)
        return Frame(
            time_s=time_s,
            names=tuple(robot.name for robot in self.world.layout.robots),
            robots={
                name: _pose(rows, time_s, _latest(self.telemetry.get(name, ()), time_s))
                for name, rows in begun.items()
            },
            facts=[Fact(predicate="in", args=pair) for pair in lay.lying.items()] if lay else (),
            trails={name: _trail(rows, time_s) for name, rows in begun.items()},
        )


T = TypeVar("T", Lain, Told)


def _latest(told: Sequence[T], time_s: float) -> T | None:
    """The last until then, else the first."""
    known = bisect_right(told, time_s, key=lambda one: one.at_s)
    return told[max(0, known - 1)] if told else None


def _time(row: Row) -> float:
    return row.at_s


def _pose(rows: Sequence[Row], time_s: float, told: Told | None) -> RobotTelemetry:
    """Between two rows a robot is where a straight line between them says."""
    next_ = bisect_right(rows, time_s, key=_time)
    begin, end = rows[max(0, next_ - 1)], rows[min(next_, len(rows) - 1)]
    span_s = end.at_s - begin.at_s
    share = (time_s - begin.at_s) / span_s if span_s > 0 else 0.0
    turn = end.heading_rad - begin.heading_rad
    return RobotTelemetry(
        x_m=begin.x_m + share * (end.x_m - begin.x_m),
        y_m=begin.y_m + share * (end.y_m - begin.y_m),
        heading_rad=begin.heading_rad + share * remainder(turn, tau),
        ranges_m=told.ranges_m if told else (),
        holding=begin.holding,
        packet_tag=begin.packet_tag,
        at_s=time_s,
    )


def _trail(rows: Sequence[Row], time_s: float) -> list[Point]:
    begin, end = (bisect_right(rows, at_s, key=_time) for at_s in (time_s - TRAIL_S, time_s))
    return [(row.x_m, row.y_m) for row in rows[begin:end]]
