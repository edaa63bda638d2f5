"""The cases: which mishap happens to which robot of a mission, and when."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

from benchmarks.mishaps.acts import (
    SENSOR_FAULTS,
    Act,
    Stage,
    boxed,
    jaws_fail,
    jaws_mended,
    knocked,
    mended,
    put,
    release,
    sensor,
    switched_off,
    switched_on,
    walled_in,
)
from benchmarks.recoveries.watch import Radios
from robots.world import WorldFile, load_world
from robots.world.parts import PHASE_TAGS, STORE_TAGS

DISPATCH = "dispatch"
"""Before the plan is approved and its robots receive scripts."""
FAR_AWAY = (-20.0, -20.0)
"""A point that no robot reaches or sees."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """What an operator asks for, in a shipped world; perhaps of robots that do its actions in phases."""

    world: str
    text: str
    sample: str
    place: str
    in_phases: bool = False

    def world_file(self) -> WorldFile:
        world = load_world(self.world)
        if not self.in_phases:
            return world
        tags = (*STORE_TAGS, *PHASE_TAGS)
        robots = [spec.model_copy(update={"repertoire": tags}) for spec in world.robots]
        return world.model_copy(update={"robots": tuple(robots)})


STORING = Task(world="sample_store", text="move sample_1 to bay_7", sample="sample_1", place="bay_7")
STORING_IN_PHASES = replace(STORING, text="move sample_1 to bay_9", place="bay_9", in_phases=True)
"""Further off: an action that is too short has no phases."""
RELOCATION = Task(
    world="relocation_lab", text="move rock_sample to lander", sample="rock_sample", place="lander"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionStage(Stage):
    """A mission under way, and its robot that has the mishap."""

    radios: Radios


MissionAct = Callable[[MissionStage], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A mishap of a robot, `after_s` after a packet of it began to run; perhaps undone `undo_s` later.

    :param robot: the beginning of its name.
    """

    name: str
    robot: str
    during: str
    do: MissionAct
    after_s: float = 1.0
    undo: Act | None = None
    undo_s: float = 0.0
    of: Task = STORING

    def __str__(self) -> str:
        return f"{self.name}, {self.during} of {self.robot}"


blinded = sensor(SENSOR_FAULTS["infra-red dead"])


def radio_broken(stage: MissionStage) -> None:
    """The robot goes on, but its radio no longer works."""
    stage.radios[stage.robot].broken = True


def cases() -> Iterator[Case]:
    """All cases."""
    yield from _samples()
    yield from _robots()
    yield from _ways()
    yield from _phases()
    yield from _together()


def _samples() -> Iterator[Case]:
    yield Case(name="sample rolls 1 m off", robot="yard", during="NAVIGATE", do=knocked(1.0))
    yield Case(name="sample taken away", robot="yard", during="NAVIGATE", do=put(FAR_AWAY))
    yield Case(name="sample put at door_2", robot="yard", during="NAVIGATE", do=put((6.0, 0.4)))
    for robot in ("yard", "store"):
        yield Case(name="sample torn out", robot=robot, during="TRANSPORT", after_s=3.0, do=knocked(0.5))
        yield Case(name="sample torn out", robot=robot, during="RELEASE2", after_s=0.5, do=knocked(0.5))
    yield Case(name="sample taken away", robot="store", during="DOCK", do=put(FAR_AWAY))
    yield Case(name="sample put back at door_1", robot="store", during="DOCK", do=put((2.0, 0.4)))
    yield Case(name="bay_7 is occupied", robot="yard", during=DISPATCH, do=put((4.5, 5.2), "sample_4"))
    yield Case(name="bay_7 is occupied", robot="store", during="TRANSPORT", do=put((4.5, 5.2), "sample_4"))
    interchange = put((6.0, 3.6), "sample_2")
    yield Case(name="interchange is occupied", robot="yard", during="NAVIGATE", do=interchange)
    yield Case(name="interchange is occupied", robot="yard", during="TRANSPORT", do=interchange)


def _robots() -> Iterator[Case]:
    yield Case(name="switched off", robot="yard", during=DISPATCH, after_s=0.0, do=switched_off)
    for robot, tag in (
        ("yard", "NAVIGATE"),
        ("yard", "DOCK"),
        ("yard", "TRANSPORT"),
        ("yard", "RELEASE2"),
        ("store", "TRANSPORT"),
    ):
        yield Case(name="switched off", robot=robot, during=tag, do=switched_off)
    for robot in ("yard", "store"):
        off_and_on = partial(Case, name="switched off for 200 s", undo=switched_on, undo_s=200.0)
        yield off_and_on(robot=robot, during="TRANSPORT", do=switched_off)
        yield Case(name="radio broken", robot=robot, during="TRANSPORT", do=radio_broken)
        yield Case(name="radio broken", robot=robot, during="RELEASE2", do=radio_broken)
        yield Case(name="infra-red dead", robot=robot, during="NAVIGATE", do=blinded)
        yield Case(name="jaws do not close", robot=robot, during="NAVIGATE", do=jaws_fail)
        yield Case(name="jaws do not open", robot=robot, during="TRANSPORT", do=jaws_fail)
    later = partial(Case, name="jaws do not close for 60 s", undo=jaws_mended, undo_s=60.0)
    yield later(robot="yard", during="NAVIGATE", do=jaws_fail)


def _ways() -> Iterator[Case]:
    for robot, tag in (("yard", "NAVIGATE"), ("yard", "TRANSPORT"), ("store", "TRANSPORT")):
        yield Case(name="walled in", robot=robot, during=tag, do=walled_in)
    yield Case(name="box in the hatch", robot="yard", during="TRANSPORT", do=boxed((6.0, 3.6), 0.36))
    yield Case(name="box at the hatch", robot="yard", during="TRANSPORT", do=boxed((6.0, 2.9), 0.4))


def _phases() -> Iterator[Case]:
    """What befalls a robot between two places, where it is at neither."""
    in_phases = partial(Case, of=STORING_IN_PHASES, after_s=0.5)
    for robot, tag in (
        ("yard", "TRANSPORT_OFF"),
        ("yard", "TRANSPORT_UP"),
        ("yard", "TRANSPORT_IN"),
        ("store", "TRANSPORT_UP"),
    ):
        yield in_phases(name="walled in", robot=robot, during=tag, do=walled_in)
        yield in_phases(
            name="infra-red dead 30 s", robot=robot, during=tag, do=blinded, undo=mended, undo_s=30
        )
        yield in_phases(name="switched off", robot=robot, during=tag, do=switched_off)


def _together() -> Iterator[Case]:
    together = partial(Case, of=RELOCATION, after_s=10.0)
    for robot in ("fred", "ginger"):
        joint = partial(together, robot=robot, during="TRANSPORT")
        yield joint(name="lets go", do=release)
        yield joint(name="switched off", do=switched_off)
        yield joint(name="radio broken", do=radio_broken)
        yield joint(name="infra-red dead", do=blinded)
        yield joint(name="infra-red dead 15 s", do=blinded, undo=mended, undo_s=15)
    yield together(
        name="object dropped",
        robot="fred",
        during="TRANSPORT",
        do=lambda stage: stage.simulation.drop(stage.sample),
    )
    yield together(name="switched off", robot="fred", during="DOCK", after_s=1.0, do=switched_off)
    yield together(name="switched off", robot="ginger", during="DOCK2", after_s=1.0, do=switched_off)
    yield together(name="jaws do not close", robot="fred", during="NAVIGATE", after_s=1.0, do=jaws_fail)
    box = boxed((7.9, 3.5), 0.4)
    yield together(name="box on the way", robot="fred", during="TRANSPORT", do=box)
