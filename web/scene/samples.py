"""The samples: where the service's facts put them, unless a robot says that it holds them."""

from collections.abc import Mapping, Sequence
from math import pi, radians

import numpy as np
import viser

from web.api_types import Fact, Layout, Lying, Point, RobotTelemetry
from web.scene import palette
from web.scene.geometry import box, cylinder, turned
from web.scene.nodes import Click, on_instance

RADIUS_M, HEIGHT_M = 0.06, 0.15
BAR_M = 0.06
LIFTED_M = 0.16
"""Bottom of a held sample above the floor: above the whiskers' plane."""
UNSEEN = (0.0, 0.0, -10.0)

Place = tuple[float, float, float]


class SamplePlaces:
    """Works out where the samples are.

    Held, says a robot: at its jaws. Just let go: there, until the facts change. Else where the facts say; a
    sample that the facts leave with a robot that does not hold it lies where its tag was last seen.
    """

    def __init__(self, layout: Layout) -> None:
        self._locations = {place.name: place.at for place in layout.locations}
        self._names = tuple(sample.name for sample in layout.samples)
        approach_deg = {place.name: place.approach_deg for place in layout.locations}
        self._turned = {
            sample.name: radians(approach_deg[sample.at][0] + 90)
            for sample in layout.samples
            if sample.length_m and approach_deg.get(sample.at)
        }
        self._dropped: dict[str, tuple[Point, str | None]] = {}
        self._held: dict[str, tuple[Point, str | None]] = {}

    def update(self, facts: Sequence[Fact], robots: Mapping[str, RobotTelemetry]) -> dict[str, Place]:
        """Each known sample's place, metres, the bottom of the cylinder."""
        told = {
            fact.args[0]: fact.args[1] for fact in facts if fact.predicate == "in" and len(fact.args) == 2
        }
        held = {
            name: self._in_jaws(name, robots) for name in {r.holding for r in robots.values() if r.holding}
        }
        for sample in self._held.keys() - held.keys():
            # Facts that changed while it was held to a new location know of the release already.
            jaws, gripped_at = self._held[sample]
            if told.get(sample) == gripped_at or told.get(sample) not in self._locations:
                self._dropped[sample] = (jaws, told.get(sample))
        began = {sample: at for sample, (_, at) in self._held.items()}
        self._held = {sample: (jaws, began.get(sample, told.get(sample))) for sample, jaws in held.items()}
        places = {}
        for sample in self._names:
            place = self._place(sample, told.get(sample), robots)
            if place is not None:
                places[sample] = place
        return places

    def heading_rad(self, sample: str, robots: Mapping[str, RobotTelemetry]) -> float:
        """The direction of a long sample: square to who holds it, or to how its place is approached."""
        holder = next((robot for robot in robots.values() if robot.holding == sample), None)
        if holder is not None:
            self._turned[sample] = holder.heading_rad + pi / 2
        return self._turned.get(sample, 0.0)

    @staticmethod
    def _in_jaws(sample: str, robots: Mapping[str, RobotTelemetry]) -> Point:
        """Where its holders have it: a long one's middle as they see it, a compact one in the jaws."""
        points = [r.tags.get(sample, r.jaws) for r in robots.values() if r.holding == sample]
        return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)

    def forget(self) -> None:
        """Forget who held what: only facts and robots count from here on."""
        self._dropped, self._held = {}, {}

    @property
    def held(self) -> frozenset[str]:
        """The samples in a robot's jaws."""
        return frozenset(self._held)

    def _place(self, sample: str, told: str | None, robots: Mapping[str, RobotTelemetry]) -> Place | None:
        if sample in self._held:
            self._dropped.pop(sample, None)
            return (*self._held[sample][0], LIFTED_M)
        if sample in self._dropped:
            at, told_then = self._dropped[sample]
            if told == told_then:
                return (*at, 0.0)
            del self._dropped[sample]
        if told is not None and told in self._locations:
            return (*self._locations[told], 0.0)
        seen = next((robot.tags[sample] for robot in robots.values() if sample in robot.tags), None)
        if seen is None and told is not None and told in robots:
            seen = robots[told].jaws
        return None if seen is None else (*seen, 0.0)


class SamplesView:
    """Draws the samples: the compact ones as one batched node, the long ones as bars."""

    def __init__(self, scene: viser.SceneApi, layout: Layout, on_click: Click = lambda _: None) -> None:
        self.at: dict[str, Place] = {}
        """Where each known sample is drawn."""
        self._places = SamplePlaces(layout)
        self._compact = tuple(sample.name for sample in layout.samples if not sample.length_m)
        self._bodies = _cylinders(scene, self._compact, on_click) if self._compact else None
        self._bars = {
            sample.name: _bar(scene, sample, on_click) for sample in layout.samples if sample.length_m
        }

    @property
    def held(self) -> frozenset[str]:
        return self._places.held

    def forget(self) -> None:
        """What comes next is not what followed: a recording was gone back in."""
        self._places.forget()

    def update(self, facts: Sequence[Fact], robots: Mapping[str, RobotTelemetry]) -> None:
        """Move the samples to where they are now."""
        places = self._places.update(facts, robots)
        if places == self.at:
            return
        self.at = places
        if self._bodies is not None:
            points = [places.get(name, UNSEEN) for name in self._compact]
            self._bodies.batched_positions = np.array(points, dtype=np.float32)
        for name, bar in self._bars.items():
            bar.position = places.get(name, UNSEEN)
            bar.wxyz = turned([self._places.heading_rad(name, robots)])[0]


def _bar(scene: viser.SceneApi, sample: Lying, on_click: Click) -> viser.MeshHandle:
    bar = scene.add_mesh_simple(
        f"/samples/{sample.name}/bar",
        *box((sample.length_m, BAR_M, HEIGHT_M), (0.0, 0.0, HEIGHT_M / 2)),
        color=palette.SAMPLE,
        position=UNSEEN,
        cast_shadow=False,
        receive_shadow=False,
    )
    bar.on_click(lambda _: on_click(sample.name))
    return bar


def _cylinders(scene: viser.SceneApi, names: Sequence[str], on_click: Click) -> viser.BatchedMeshHandle:
    bodies = scene.add_batched_meshes_simple(
        "/samples",
        *cylinder(RADIUS_M, 0.0, HEIGHT_M, sides=20),
        batched_wxyzs=turned([0.0] * len(names)),
        batched_positions=np.array([UNSEEN] * len(names), dtype=np.float32),
        batched_colors=palette.batched([palette.SAMPLE] * len(names)),
        lod="off",
        cast_shadow=False,
        receive_shadow=False,
    )
    on_instance(bodies, names, on_click)
    return bodies
