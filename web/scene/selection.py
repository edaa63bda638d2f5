"""What is selected on the page, marked in the world: a ring round the robot, one round the sample."""

from collections.abc import Mapping

import viser

from web.scene import palette
from web.scene.frame import RADIUS_M, Frame
from web.scene.geometry import ring

HEIGHT_M = 0.02


class SelectionView:
    """Two rings, each seen only while something of its kind is selected and its place is known."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._rings = {
            kind: scene.add_mesh_simple(
                f"/selection/{kind}",
                *ring(inner, inner + 0.07, HEIGHT_M),
                color=palette.SELECTED,
                side="double",
                visible=False,
                cast_shadow=False,
                receive_shadow=False,
            )
            for kind, inner in (("robot", RADIUS_M + 0.12), ("sample", 0.14))
        }

    def update(
        self,
        frame: Frame,
        robot: str | None,
        sample: str | None,
        samples: Mapping[str, tuple[float, float, float]],
    ) -> None:
        told = frame.robots.get(robot or "")
        self._mark("robot", None if told is None else (told.x_m, told.y_m, 0.0))
        self._mark("sample", samples.get(sample or ""))

    def _mark(self, kind: str, at: tuple[float, float, float] | None) -> None:
        handle = self._rings[kind]
        if handle.visible != (at is not None):
            handle.visible = at is not None
        if at is not None:
            handle.position = at
