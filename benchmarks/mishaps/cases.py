"""The cases: each mishap in every part of an undertaking in which it can happen."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from benchmarks.mishaps.acts import (
    SENSOR_FAULTS,
    WHISKER_FAULTS,
    Act,
    battery_nan,
    boxed,
    carried_off,
    hidden,
    knocked,
    mended,
    nudged,
    release,
    sensor,
    shoved,
    shown,
    turned,
    twisted,
    wheels_frozen,
    wheels_nan,
)
from benchmarks.mishaps.injection import dead, frozen, head_reads_nan, sees_nothing, sightings_read_nan
from benchmarks.mishaps.undertakings import CARRIER, PARTNERS, Undertaking, errand, relocation
from robots.physical.body import Sensor

PASSES_S = 3.0
"""Duration of a temporary mishap."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A mishap while a packet runs, `after_s` after its patterns began to act; perhaps undone later.

    :param robot: whose packet it is, and who has the mishap.
    """

    name: str
    during: str
    do: Act
    after_s: float = 1.0
    undo: Act | None = None
    undo_s: float = PASSES_S
    of: Callable[[], Undertaking] = errand
    robot: str = CARRIER

    def __str__(self) -> str:
        who = "" if self.robot == CARRIER else f" of {self.robot}"
        return f"{self.name}, {self.during}{who}"


ALL = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")
WAYS_M = {"ahead": (0.15, 0.0), "aside": (0.0, 0.15)}


def cases() -> Iterator[Case]:
    """All cases."""
    yield from _alone()
    yield from _together()


def _alone() -> Iterator[Case]:
    work = errand()
    for tag in ALL:
        place = work.start if tag in ("NAVIGATE", "DOCK") else work.goal
        yield Case(name="turned by hand", during=tag, do=turned)
        yield Case(name="carried off", during=tag, do=carried_off)
        yield Case(name="pushed", during=tag, do=shoved)
        yield Case(name="beacon hidden 10 s", during=tag, do=hidden(place), undo=shown(place), undo_s=10)
        yield Case(name="beacon hidden for good", during=tag, do=hidden(place))
        yield Case(
            name="all covered 10 s", during=tag, do=sensor(lambda: sees_nothing), undo=mended, undo_s=10
        )
        yield from _sensors(tag)
    for tag in ("NAVIGATE", "DOCK"):
        yield Case(name="sample knocked 0.15 m", during=tag, do=knocked(0.15))
        yield Case(name="sample knocked 1 m", during=tag, do=knocked(1.0))
        yield Case(name="sample hidden 3 s", during=tag, do=hidden(work.sample), undo=shown(work.sample))
    yield Case(name="sample knocked from jaws", during="TRANSPORT", after_s=3.0, do=knocked(0.5))
    yield Case(name="sample knocked from jaws", during="RELEASE2", after_s=0.5, do=knocked(0.5))
    hatch, before = (6.0, 3.6), (6.0, 2.9)
    yield Case(name="box in the hatch", during="TRANSPORT", do=boxed(hatch, 0.36))
    yield Case(name="box in the hatch", during="RELEASE2", after_s=0.2, do=boxed(hatch, 0.36))
    yield Case(name="box at the approach point", during="TRANSPORT", do=boxed(before, 0.4))
    yield Case(name="box on the way", during="TRANSPORT", do=boxed((4.0, 2.2), 0.5))
    yield Case(name="box at the approach point", during="NAVIGATE", after_s=0.2, do=boxed((2.0, 1.5), 0.3))


def _sensors(tag: str) -> Iterator[Case]:
    """Whiskers do not run while a robot docks or deposits."""
    whiskers = WHISKER_FAULTS if tag in ("NAVIGATE", "TRANSPORT") else {}
    for name, fault in {**whiskers, **SENSOR_FAULTS}.items():
        yield Case(name=name, during=tag, do=sensor(fault))
    yield Case(name="odometry NaN", during=tag, do=wheels_nan)
    yield Case(name="odometry frozen", during=tag, do=wheels_frozen)
    yield Case(name="battery NaN", during=tag, do=battery_nan)
    yield Case(name="infra-red NaN 3 s", during=tag, do=sensor(lambda: sightings_read_nan), undo=mended)


def _together() -> Iterator[Case]:
    """Mishaps of one of two robots that carry a long object, the first or the second to dock."""
    goal = relocation().goal
    first, second = PARTNERS
    joint = [
        (first, "DOCK"),
        (second, "DOCK2"),
        (first, "TRANSPORT"),
        (second, "TRANSPORT"),
        (second, "RELEASE2"),
    ]
    for robot, tag in joint:
        case = partial(
            Case, during=tag, of=relocation, robot=robot, after_s=10.0 if tag == "TRANSPORT" else 1.0
        )
        yield case(name="turned by hand 0.3 rad", do=twisted(0.3))
        for way, (ahead_m, left_m) in WAYS_M.items():
            yield case(name=f"pushed {way} 0.15 m", do=nudged(ahead_m, left_m))
        yield case(name="all covered 10 s", do=sensor(lambda: sees_nothing), undo=mended, undo_s=10)
        yield case(name="infra-red dead", do=sensor(SENSOR_FAULTS["infra-red dead"]))
        yield case(name="gripper dead", do=sensor(SENSOR_FAULTS["gripper dead"]))
        yield case(name="odometry frozen", do=wheels_frozen)
    for robot in PARTNERS:
        case = partial(Case, during="TRANSPORT", of=relocation, robot=robot, after_s=10.0)
        yield case(name="capture head dead", do=sensor(lambda: dead(Sensor.CAPTURE_HEAD)))
        yield case(name="capture head NaN", do=sensor(lambda: head_reads_nan))
        yield case(name="capture head frozen", do=sensor(lambda: frozen(Sensor.CAPTURE_HEAD)))
        yield case(name="one whisker NaN", do=sensor(WHISKER_FAULTS["one whisker NaN"]))
        yield case(name="whiskers dead", do=sensor(WHISKER_FAULTS["whiskers dead"]))
        yield case(name="its jaws let go", do=release)
    shared = partial(Case, during="TRANSPORT", of=relocation, robot=first, after_s=10.0)
    yield shared(name="beacon hidden 10 s", do=hidden(goal), undo=shown(goal), undo_s=10)
    yield shared(name="beacon hidden for good", do=hidden(goal))
    yield shared(name="object dropped", do=lambda stage: stage.simulation.drop(stage.sample))
    yield shared(name="box on the way", do=boxed((7.9, 3.5), 0.4))
