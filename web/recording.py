"""A mission's recording, queried at any instant: robots' poses and grippers, samples' places."""

from bisect import bisect_right
from collections.abc import Sequence
from math import remainder, tau
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import BeforeValidator, Field

from web.api_types import ApiModel, Fact, Layout, Point, RobotTelemetry
from web.scene import Frame

EARLY_S = 0.5
"""A robot is drawn this long before its first row, because the robots' rows are not simultaneous."""
TRAIL_S = 40.0


class Row(NamedTuple):
    """A robot's pose, gripper and packet at a time of the world's clock."""

    at_s: float
    x_m: float
    y_m: float
    heading_rad: float
    holding: str | None = None
    packet_tag: str | None = None


def _known(row: Any) -> Any:
    """The row's known columns; further ones are ignored like unknown keys."""
    return row[: len(Row._fields)] if isinstance(row, list | tuple) else row


class RecordedWorld(ApiModel):
    layout: Layout


class RecordedPlaces(ApiModel):
    """The samples' places from that time on."""

    at_s: float
    lying: dict[str, str] = Field(default_factory=dict)


class RecordedTelemetry(ApiModel):
    """A robot's telemetry beside its pose."""

    at_s: float
    ranges_m: tuple[float | None, ...] = ()


class Recording(ApiModel):
    world: RecordedWorld
    robots: dict[str, tuple[Annotated[Row, BeforeValidator(_known)], ...]] = Field(default_factory=dict)
    telemetry: dict[str, tuple[RecordedTelemetry, ...]] = Field(default_factory=dict)
    samples: tuple[RecordedPlaces, ...] = ()

    def at(self, time_s: float) -> Frame:
        """The world at that time of its clock."""
        started = {
            name: rows for name, rows in self.robots.items() if rows and rows[0].at_s <= time_s + EARLY_S
        }
        places = _latest(self.samples, time_s)
        return Frame(
            time_s=time_s,
            names=tuple(robot.name for robot in self.world.layout.robots),
            robots={
                name: _pose(rows, time_s, _latest(self.telemetry.get(name, ()), time_s))
                for name, rows in started.items()
            },
            facts=[Fact(predicate="in", args=pair) for pair in places.lying.items()] if places else (),
            trails={name: _trail(rows, time_s) for name, rows in started.items()},
        )


T = TypeVar("T", RecordedPlaces, RecordedTelemetry)


def _latest(records: Sequence[T], time_s: float) -> T | None:
    """The last record until `time_s`; before the first, the first."""
    known = bisect_right(records, time_s, key=lambda one: one.at_s)
    return records[max(0, known - 1)] if records else None


def _time(row: Row) -> float:
    return row.at_s


def _pose(rows: Sequence[Row], time_s: float, telemetry: RecordedTelemetry | None) -> RobotTelemetry:
    """The pose at an instant, interpolated between two rows."""
    next_ = bisect_right(rows, time_s, key=_time)
    begin = rows[max(0, next_ - 1)]
    end = rows[min(next_, len(rows) - 1)]
    span_s = end.at_s - begin.at_s
    share = (time_s - begin.at_s) / span_s if span_s > 0 else 0.0
    turn = end.heading_rad - begin.heading_rad
    return RobotTelemetry(
        x_m=begin.x_m + share * (end.x_m - begin.x_m),
        y_m=begin.y_m + share * (end.y_m - begin.y_m),
        heading_rad=begin.heading_rad + share * remainder(turn, tau),
        ranges_m=telemetry.ranges_m if telemetry else (),
        holding=begin.holding,
        packet_tag=begin.packet_tag,
        at_s=time_s,
    )


def _trail(rows: Sequence[Row], time_s: float) -> list[Point]:
    begin, end = (bisect_right(rows, at_s, key=_time) for at_s in (time_s - TRAIL_S, time_s))
    return [(row.x_m, row.y_m) for row in rows[begin:end]]
