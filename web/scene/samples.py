"""The samples: where the facts put them, unless a robot reports that it holds them."""

from collections.abc import Mapping, Sequence
from math import pi, radians

import numpy as np
import viser

from web.api_types import Fact, Layout, Point, RobotTelemetry, Sample
from web.scene import palette
from web.scene.geometry import box, cylinder, turned
from web.scene.nodes import HIDDEN, OnClick, add_instances, add_mesh, on_instance_click

RADIUS_M = 0.06
HEIGHT_M = 0.15
BAR_M = 0.06
LIFTED_M = 0.16
"""Bottom of a held sample above the floor, above the plane of the range readings."""

Position = tuple[float, float, float]


class SamplePositions:
    """Determines the samples' positions.

    A held sample is at its robot's jaws. One that was just released stays there until the facts change. Otherwise the
    facts count; a sample that they assign to a robot which does not hold it lies where its tag was last seen.
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

    def update(self, facts: Sequence[Fact], robots: Mapping[str, RobotTelemetry]) -> dict[str, Position]:
        """Each known sample's position, metres, at its bottom."""
        believed = {
            fact.args[0]: fact.args[1] for fact in facts if fact.predicate == "in" and len(fact.args) == 2
        }
        held = {
            name: self._in_jaws(name, robots) for name in {r.holding for r in robots.values() if r.holding}
        }
        for sample in self._held.keys() - held.keys():
            # If the facts changed to a new location while it was held, they include the release already.
            jaws, gripped_at = self._held[sample]
            if believed.get(sample) == gripped_at or believed.get(sample) not in self._locations:
                self._dropped[sample] = (jaws, believed.get(sample))
        began = {sample: at for sample, (_, at) in self._held.items()}
        self._held = {
            sample: (jaws, began.get(sample, believed.get(sample))) for sample, jaws in held.items()
        }
        places = {}
        for sample in self._names:
            place = self._place(sample, believed.get(sample), robots)
            if place is not None:
                places[sample] = place
        return places

    def heading_rad(self, sample: str, robots: Mapping[str, RobotTelemetry]) -> float:
        """The direction of a long sample: across its robot's heading, or across its place's approach."""
        holder = next((robot for robot in robots.values() if robot.holding == sample), None)
        if holder is not None:
            self._turned[sample] = holder.heading_rad + pi / 2
        return self._turned.get(sample, 0.0)

    @staticmethod
    def _in_jaws(sample: str, robots: Mapping[str, RobotTelemetry]) -> Point:
        """The mean position that its robots report: of a long one its tag, of a compact one the jaws."""
        points = [r.tags.get(sample, r.jaws) for r in robots.values() if r.holding == sample]
        return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)

    def forget(self) -> None:
        """Forget held and released samples; call it when the time jumps back."""
        self._dropped = {}
        self._held = {}

    @property
    def held(self) -> frozenset[str]:
        """The samples in a robot's jaws."""
        return frozenset(self._held)

    def _place(
        self, sample: str, believed: str | None, robots: Mapping[str, RobotTelemetry]
    ) -> Position | None:
        if sample in self._held:
            self._dropped.pop(sample, None)
            return (*self._held[sample][0], LIFTED_M)
        if sample in self._dropped:
            at, believed_then = self._dropped[sample]
            if believed == believed_then:
                return (*at, 0.0)
            del self._dropped[sample]
        if believed is not None and believed in self._locations:
            return (*self._locations[believed], 0.0)
        seen = next((robot.tags[sample] for robot in robots.values() if sample in robot.tags), None)
        if seen is None and believed is not None and believed in robots:
            seen = robots[believed].jaws
        return None if seen is None else (*seen, 0.0)


class SamplesView:
    """Draws the samples: the compact ones as one batched node, the long ones as bars."""

    def __init__(self, scene: viser.SceneApi, layout: Layout, on_click: OnClick) -> None:
        self.positions: dict[str, Position] = {}
        """Where each sample with a known place is drawn."""
        self.tracked = SamplePositions(layout)
        self._compact = tuple(sample.name for sample in layout.samples if not sample.length_m)
        self._bodies = _cylinders(scene, self._compact, on_click) if self._compact else None
        self._bars = {
            sample.name: _bar(scene, sample, on_click) for sample in layout.samples if sample.length_m
        }

    def update(self, facts: Sequence[Fact], robots: Mapping[str, RobotTelemetry]) -> None:
        """Move the samples to their present positions."""
        positions = self.tracked.update(facts, robots)
        if positions == self.positions:
            return
        self.positions = positions
        if self._bodies is not None:
            points = [positions.get(name, HIDDEN) for name in self._compact]
            self._bodies.batched_positions = np.array(points, dtype=np.float32)
        for name, bar in self._bars.items():
            bar.position = positions.get(name, HIDDEN)
            bar.wxyz = turned([self.tracked.heading_rad(name, robots)])[0]


def _bar(scene: viser.SceneApi, sample: Sample, on_click: OnClick) -> viser.MeshHandle:
    body = box((sample.length_m, BAR_M, HEIGHT_M), (0.0, 0.0, HEIGHT_M / 2))
    bar = add_mesh(scene, f"/samples/{sample.name}/bar", body, palette.SAMPLE, HIDDEN)
    bar.on_click(lambda _: on_click(sample.name))
    return bar


def _cylinders(scene: viser.SceneApi, names: Sequence[str], on_click: OnClick) -> viser.BatchedMeshHandle:
    body = cylinder(RADIUS_M, 0.0, HEIGHT_M, sides=20)
    bodies = add_instances(scene, "/samples", body, [HIDDEN] * len(names), [palette.SAMPLE] * len(names))
    on_instance_click(bodies, names, on_click)
    return bodies
