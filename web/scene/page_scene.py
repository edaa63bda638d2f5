"""One page's own scene of a world: everything in it is sent to that page's browser alone."""

from collections.abc import Callable

import viser

from web.api_types import Layout, Plan, Shown
from web.scene import camera, palette
from web.scene.building import PlacesView, draw_store, names_of_places
from web.scene.eye import Eye
from web.scene.frame import Frame
from web.scene.labels import CHOSEN_FIRST, ROBOTS_NEXT, SAMPLES_LAST, FloorLabelsView, Label, LabelsView
from web.scene.paths import PathsView
from web.scene.robots import LABEL_HEIGHT_M, RobotsView, label_text
from web.scene.samples import HEIGHT_M, SamplesView
from web.scene.selection import SelectionView

Pick = Callable[[str, str], None]
"""Told of what is clicked on: its kind, `robot`, `sample` or `place`, and its name."""


class Stage:
    """Draws a world in one browser, with what its page has selected there."""

    def __init__(self, client: viser.ClientHandle, layout: Layout, pick: Pick, *, dark: bool = False) -> None:
        self.client, self.layout, self.dark = client, layout, dark
        ground = palette.DARK if dark else palette.LIGHT
        scene = client.scene
        names = [robot.name for robot in layout.robots]
        draw_store(scene, layout, ground)
        self._places = PlacesView(scene, layout, lambda name: pick("place", name))
        self._robots = RobotsView(scene, names, ground.trim, lambda name: pick("robot", name))
        self._samples = SamplesView(scene, layout, lambda name: pick("sample", name))
        self._selection = SelectionView(scene)
        self._paths = PathsView(scene, names, ground)
        self._labels = LabelsView(scene)
        self._floor_labels = FloorLabelsView(scene, names_of_places(layout))
        self._named: tuple[Frame, Shown] | None = None
        self._followed: str | None = None
        self._whole = -1
        self._time_s = 0.0

    def update(self, frame: Frame, shown: Shown, plan: Plan | None) -> None:
        """Draw this instant, and what the page shows of it."""
        with self.client.atomic():
            if frame.time_s < self._time_s:
                self._samples.forget()
            self._time_s = frame.time_s
            self._places.update(frame.facts)
            self._robots.update(frame, shown.robot)
            self._samples.update(frame.facts, frame.robots)
            self._selection.update(frame, shown.robot, shown.sample, self._samples.at)
            self._paths.update(plan, self.layout, shown.action)
            self._labels.update(self._wanted_labels(frame, shown, self._labels.shown))
            self._named = frame, shown
        self._move_camera(frame, shown)

    def name(self) -> None:
        """Decide anew which labels have room, now that things or the camera may have moved."""
        if self._named is None:
            return
        frame, shown = self._named
        labels, eye = self._wanted_labels(frame, shown), Eye.of(self.client.camera)
        with self.client.atomic():
            self._labels.choose(labels, eye)
            self._labels.update(labels)
            self._floor_labels.make_room([one for one in labels if one.name in self._labels.shown], eye)

    def _wanted_labels(self, frame: Frame, shown: Shown, among: frozenset[str] | None = None) -> list[Label]:
        """The labels of robots and samples; only those `among`, if that is given."""
        labels = []
        for robot in frame.heard:
            name, told = f"robots/{robot}", frame.robots[robot]
            if among is None or name in among:
                rank = CHOSEN_FIRST if robot == shown.robot else ROBOTS_NEXT
                at = (told.x_m, told.y_m, LABEL_HEIGHT_M)
                labels.append(Label(name=name, text=label_text(robot, told, frame.time_s), at=at, rank=rank))
        for sample, (x_m, y_m, bottom_m) in self._samples.at.items():
            name = f"samples/{sample}"
            # The label of the robot that holds it is in the same spot.
            if (among is None or name in among) and sample not in self._samples.held:
                rank = CHOSEN_FIRST if sample == shown.sample else SAMPLES_LAST
                at = (x_m, y_m, bottom_m + HEIGHT_M + 0.05)
                labels.append(Label(name=name, text=sample, at=at, rank=rank))
        return labels

    def _move_camera(self, frame: Frame, shown: Shown) -> None:
        if shown.whole != self._whole:
            self._whole = shown.whole
            camera.aim(self.client, self.layout)
        robot = shown.robot if shown.follow and shown.robot in frame.robots else None
        if robot is not None:
            told = frame.robots[robot]
            camera.follow(self.client, (told.x_m, told.y_m), begins=robot != self._followed)
        self._followed = robot
