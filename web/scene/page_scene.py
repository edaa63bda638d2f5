"""One page's scene of a world: all of it is sent to that page's browser alone."""

from collections.abc import Callable

import viser

from web.api_types import Layout, PageState, Plan
from web.scene import camera, palette
from web.scene.building import PlacesView, draw_building, place_labels
from web.scene.camera import CameraView
from web.scene.frame import RADIUS_M, Frame
from web.scene.geometry import ring
from web.scene.labels import ROBOT_RANK, SAMPLE_RANK, SELECTED_RANK, FloorLabelsView, Label, LabelsView
from web.scene.nodes import add_mesh
from web.scene.paths import PathsView
from web.scene.peripherals import PeripheralsView
from web.scene.robots import LABEL_HEIGHT_M, RobotsView, label_text
from web.scene.samples import HEIGHT_M, SamplesView

SELECTION_RINGS_M = {"robot": (RADIUS_M + 0.12, RADIUS_M + 0.19), "sample": (0.14, 0.21)}
"""Inner and outer radius by what is selected."""
RING_HEIGHT_M = 0.02

OnPick = Callable[[str, str], None]
"""Receives what was clicked on: its kind, `robot`, `sample` or `place`, and its name."""


class PageScene:
    """Draws a world in one browser, with what its page has selected."""

    def __init__(
        self, client: viser.ClientHandle, layout: Layout, on_pick: OnPick, *, dark: bool = False
    ) -> None:
        self.client = client
        self.layout = layout
        self.dark = dark
        theme = palette.DARK if dark else palette.LIGHT
        scene = client.scene
        names = [robot.name for robot in layout.robots]
        draw_building(scene, layout, theme)
        self._peripherals = PeripheralsView(scene, layout)
        self._places = PlacesView(scene, layout, lambda name: on_pick("place", name))
        self._robots = RobotsView(scene, names, theme.trim, lambda name: on_pick("robot", name))
        self._samples = SamplesView(scene, layout, lambda name: on_pick("sample", name))
        self._rings = {
            kind: add_mesh(
                scene, f"/selection/{kind}", ring(*radii, RING_HEIGHT_M), palette.SELECTED, visible=False
            )
            for kind, radii in SELECTION_RINGS_M.items()
        }
        self._paths = PathsView(scene, names, theme)
        self._labels = LabelsView(scene)
        self._floor_labels = FloorLabelsView(scene, place_labels(layout))
        self._drawn: tuple[Frame, PageState] | None = None
        self._followed: str | None = None
        self._whole_count = -1
        self._time_s = 0.0

    def update(self, frame: Frame, state: PageState, plan: Plan | None) -> None:
        """Draw this instant, and what the page shows of it."""
        with self.client.atomic():
            if frame.time_s < self._time_s:
                self._samples.tracked.forget()
            self._time_s = frame.time_s
            self._places.update(frame.facts)
            self._peripherals.update(frame.facts)
            self._robots.update(frame, state.robot)
            self._samples.update(frame.facts, frame.robots)
            robot = frame.robots.get(state.robot or "")
            self._place_ring("robot", None if robot is None else (robot.x_m, robot.y_m, 0.0))
            self._place_ring("sample", self._samples.positions.get(state.sample or ""))
            self._paths.update(plan, self.layout, state.action)
            self._labels.update(self._wanted_labels(frame, state, self._labels.shown))
            self._drawn = frame, state
        self._move_camera(frame, state)

    def lay_out_labels(self) -> None:
        """Choose the labels that have room, now that bodies or the camera may have moved."""
        if self._drawn is None:
            return
        labels = self._wanted_labels(*self._drawn)
        view = CameraView.of(self.client.camera)
        with self.client.atomic():
            self._labels.choose(labels, view)
            self._labels.update(labels)
            self._floor_labels.make_room([one for one in labels if one.name in self._labels.shown], view)

    def _wanted_labels(
        self, frame: Frame, state: PageState, among: frozenset[str] | None = None
    ) -> list[Label]:
        """The labels of robots and samples, or only those `among` them."""
        labels = []
        for name in frame.heard:
            if among is not None and f"robots/{name}" not in among:
                continue
            robot = frame.robots[name]
            labels.append(
                Label(
                    name=f"robots/{name}",
                    text=label_text(name, robot, frame.time_s),
                    at=(robot.x_m, robot.y_m, LABEL_HEIGHT_M),
                    rank=SELECTED_RANK if name == state.robot else ROBOT_RANK,
                )
            )
        for name, (x_m, y_m, bottom_m) in self._samples.positions.items():
            # The label of a robot that holds it is at the same place.
            if name in self._samples.tracked.held or (among is not None and f"samples/{name}" not in among):
                continue
            labels.append(
                Label(
                    name=f"samples/{name}",
                    text=name,
                    at=(x_m, y_m, bottom_m + HEIGHT_M + 0.05),
                    rank=SELECTED_RANK if name == state.sample else SAMPLE_RANK,
                )
            )
        return labels

    def _place_ring(self, kind: str, position: tuple[float, float, float] | None) -> None:
        handle = self._rings[kind]
        if position is not None:
            handle.position = position
        if handle.visible != (position is not None):
            handle.visible = position is not None

    def _move_camera(self, frame: Frame, state: PageState) -> None:
        if state.whole != self._whole_count:
            self._whole_count = state.whole
            camera.show_whole_world(self.client, self.layout)
        name = state.robot if state.follow and state.robot in frame.robots else None
        if name is not None:
            robot = frame.robots[name]
            camera.follow(self.client, (robot.x_m, robot.y_m), begins=name != self._followed)
        self._followed = name
