"""Grippers and samples: what the light barriers meet, and who holds what.

Our choices: closing jaws lift what is between them at once, so that it passes above standing samples and the
whiskers' plane; a held sample touches nothing, only the rover's jaws are solid. Two robots may hold one
sample (MACTA's RELEASE1): it follows the first of them, and slips out of the other's jaws if they part.
A long one is gripped at a handle and carried on compliant capture heads (`sim.physics.beam`).
"""

from collections.abc import Iterable, Mapping, Sequence
from math import cos, hypot, sin

from robots.physical.body import GRIPPER_REACH_M, Gripper, Pose
from sim.clock import TICK_S
from sim.physics.beam import UNLOADED, Beam, Contact, JawsPose, Load
from sim.physics.scene import Placed, Scene
from sim.snapshot import JawsState

BARRIER_M = 0.07
"""Distance from the jaws' middle at which a sample's middle breaks the light barrier."""
HANDLE_M = 0.03
"""Distance at which a long sample's handle breaks it."""
SLIP_M = 0.15
"""A sample farther than this from a second holder's jaws has slipped out."""


def jaws_point(pose: Pose) -> tuple[float, float]:
    """The middle of the jaws, in the world's frame."""
    return (
        pose.x_m + GRIPPER_REACH_M * cos(pose.heading_rad),
        pose.y_m + GRIPPER_REACH_M * sin(pose.heading_rad),
    )


class Jaws:
    """The grippers of all rovers of one scene."""

    def __init__(self, scene: Scene, rovers: Sequence[str], samples: Mapping[str, Placed]) -> None:
        self._scene = scene
        self._closed = dict.fromkeys(rovers, False)
        self._holders: dict[str, list[str]] = {sample: [] for sample in samples}
        self._held: dict[str, str] = {}
        """Rover to the sample that it holds."""
        self._lengths_m = {name: placed.length_m for name, placed in samples.items() if placed.length_m}
        self._beams: dict[str, Beam] = {}
        self.slipped = 0
        """How often a handle has slipped out of a capture head."""

    def snapshot(self) -> JawsState:
        return JawsState(
            closed=dict(self._closed),
            holders={sample: tuple(holders) for sample, holders in self._holders.items()},
            beams={sample: beam.state() for sample, beam in self._beams.items()},
            slipped=self.slipped,
        )

    def restore(self, state: JawsState) -> None:
        """Grip again what was held, at its place in the scene: it is lifted, and nothing moves."""
        self._closed |= state.closed
        self.slipped = state.slipped
        self._holders |= {sample: list(holders) for sample, holders in state.holders.items()}
        self._held = {rover: sample for sample, holders in self._holders.items() for rover in holders}
        for sample in (sample for sample, holders in self._holders.items() if holders):
            point = self._scene.sample_point(sample)[:2]
            heading_rad = self._scene.sample_heading(sample)
            self._scene.lift(sample)
            self._scene.carry(sample, point, heading_rad)
            if sample in state.beams:
                self._beams[sample] = self._beam(sample)
                self._beams[sample].restore(state.beams[sample])

    def holders(self, sample: str) -> tuple[str, ...]:
        """The rovers that hold a sample, the one that carries it first."""
        return tuple(self._holders[sample])

    def hidden_tags(self) -> list[tuple[str, str]]:
        """Rovers and the compact samples in their jaws, whose tags they cannot see; a long one's tag stays visible."""
        return [(rover, sample) for rover, sample in self._held.items() if sample not in self._lengths_m]

    def state(self, rover: str) -> Gripper:
        """What the gripper senses."""
        return self.states([rover])[rover]

    def states(self, rovers: Iterable[str]) -> dict[str, Gripper]:
        """What these rovers' grippers sense."""
        rovers = tuple(rovers)
        between = self._between([rover for rover in rovers if not self._closed[rover]])
        return {
            rover: Gripper(closed=False, between_jaws=between[rover])
            if rover in between
            else Gripper(closed=True, between_jaws=self._held.get(rover))
            for rover in rovers
        }

    def move(self, rover: str, *, closed: bool) -> None:
        """Close or open. Closing on a sample grips and lifts it, opening sets it down below the jaws."""
        if closed == self._closed[rover]:
            return
        sample = self._between([rover])[rover] if closed else self._held.get(rover)
        self._closed[rover] = closed
        if sample is not None:
            change = self._grip if closed else self._release
            change(rover, sample)

    def deflection_m(self, rover: str) -> tuple[float, float]:
        """Offset of the object from the middle of a rover's capture head, x and y of the rover's frame."""
        sample = self._held.get(rover)
        if sample not in self._beams:
            return (0.0, 0.0)
        deflection = self._beams[sample].deflection(rover)
        return (deflection.real, deflection.imag)

    def load(self, rover: str) -> Load:
        """What the object on a rover's capture head exerts on the rover."""
        beam = self._beams.get(self._held.get(rover, ""))
        return UNLOADED if beam is None else beam.load(rover)

    def drop(self, sample: str) -> None:
        """A sample slips out of all jaws that hold it, which stay closed."""
        for rover in self.holders(sample):
            self._release(rover, sample)

    def carry(self) -> None:
        """Bring every held sample to its carrier's jaws."""
        for sample, beam in list(self._beams.items()):
            self._carry_beam(sample, beam)
        for sample, holders in self._holders.items():
            if not holders or sample in self._beams:
                continue
            point = jaws_point(self._scene.pose(holders[0]))
            self._scene.carry(sample, point)
            for other in holders[1:]:
                if _distance_m(point, jaws_point(self._scene.pose(other))) > SLIP_M:
                    holders.remove(other)
                    del self._held[other]

    def _carry_beam(self, sample: str, beam: Beam) -> None:
        """Move a long sample by its heads and contacts; set it down if the last head loses it."""
        jaws = {rover: self._jaws_pose(rover) for rover in self._holders[sample]}
        contacts = [
            Contact(complex(*at), complex(*normal), depth_m)
            for at, normal, depth_m in self._scene.contacts(sample)
        ]
        lost = beam.advance(jaws, contacts, TICK_S)
        self._scene.carry(sample, (beam.middle.real, beam.middle.imag), beam.heading_rad)
        for rover in lost:
            self.slipped += 1
            self._release(rover, sample)

    def _grip(self, rover: str, sample: str) -> None:
        if not self._holders[sample]:
            self._scene.lift(sample)
        self._holders[sample].append(rover)
        self._held[rover] = sample
        if sample in self._lengths_m:
            beam = self._beams.setdefault(sample, self._beam(sample))
            jaws = self._jaws_pose(rover)
            beam.grip(rover, min((1, -1), key=lambda end: abs(beam.handle(end) - jaws.middle)), jaws)

    def _release(self, rover: str, sample: str) -> None:
        point = self._scene.sample_point(sample)
        self._holders[sample].remove(rover)
        del self._held[rover]
        if sample in self._beams:
            self._beams[sample].release(rover)
        if not self._holders[sample]:
            beam = self._beams.pop(sample, None)
            self._scene.set_down(sample, point[:2], beam.heading_rad if beam else 0.0)

    def _between(self, rovers: Sequence[str]) -> dict[str, str | None]:
        """What stands between the jaws of each."""
        points = [jaws_point(self._scene.pose(rover)) for rover in rovers]
        close: dict[str, list[tuple[float, str]]] = {rover: [] for rover in rovers}
        for n, sample in self._scene.samples_near(points, BARRIER_M):
            if sample not in self._lengths_m:
                off_m = _distance_m(self._scene.sample_point(sample)[:2], points[n])
                close[rovers[n]].append((off_m, sample))
        between: dict[str, str | None] = {}
        for rover, jaws in zip(rovers, points, strict=True):
            distance_m, sample = min(close[rover], default=(float("inf"), ""))
            between[rover] = sample if distance_m <= BARRIER_M else self._handle_between(jaws)
        return between

    def _handle_between(self, jaws: tuple[float, float]) -> str | None:
        """The long sample with a handle between the jaws that no other rover grips."""
        for sample in self._lengths_m:
            beam = self._beams.get(sample) or self._beam(sample)
            taken = {beam.end_of(holder) for holder in self._holders[sample]}
            free = [beam.handle(end) for end in (1, -1) if end not in taken]
            if any(abs(handle - complex(*jaws)) <= HANDLE_M for handle in free):
                return sample
        return None

    def _beam(self, sample: str) -> Beam:
        """A long sample at its present pose."""
        x, y, _ = self._scene.sample_point(sample)
        return Beam(self._lengths_m[sample], complex(x, y), self._scene.sample_heading(sample))

    def _jaws_pose(self, rover: str) -> JawsPose:
        pose = self._scene.pose(rover)
        return JawsPose(complex(*jaws_point(pose)), pose.heading_rad)


def _distance_m(one: tuple[float, float], other: tuple[float, float]) -> float:
    return hypot(one[0] - other[0], one[1] - other[1])
