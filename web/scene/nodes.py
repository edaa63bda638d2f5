"""Nodes of the scene: many bodies of one shape as one batched node, and clicks on them.

Without shadows and levels of detail: a browser without graphics hardware is slow at both.
"""

from collections.abc import Callable, Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from web.scene import palette
from web.scene.geometry import HIDDEN_M, Mesh, turned

OnClick = Callable[[str], None]
"""Receives the name of what was clicked on."""
HIDDEN = (0.0, 0.0, HIDDEN_M)
"""Position of instances that are not visible."""


def add_instances(
    scene: viser.SceneApi,
    name: str,
    mesh: Mesh,
    positions: Sequence[tuple[float, float, float]],
    colours: Sequence[palette.Colour],
    *,
    headings_rad: Sequence[float] | None = None,
    scales: Sequence[tuple[float, float, float]] | None = None,
    flat_shading: bool = False,
    visible: bool = True,
) -> viser.BatchedMeshHandle:
    """Add a body for each position, metres."""
    return scene.add_batched_meshes_simple(
        name,
        *mesh,
        batched_wxyzs=turned(headings_rad or [0.0] * len(positions)),
        batched_positions=np.array(positions, dtype=np.float32).reshape(-1, 3),
        batched_scales=None if scales is None else np.array(scales, dtype=np.float32),
        batched_colors=palette.batched(colours),
        flat_shading=flat_shading,
        visible=visible,
        lod="off",
        cast_shadow=False,
        receive_shadow=False,
    )


def add_mesh(
    scene: viser.SceneApi,
    name: str,
    mesh: Mesh,
    colour: palette.Colour,
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    flat_shading: bool = False,
    visible: bool = True,
) -> viser.MeshHandle:
    """Add one body."""
    return scene.add_mesh_simple(
        name,
        *mesh,
        color=colour,
        position=position,
        flat_shading=flat_shading,
        visible=visible,
        cast_shadow=False,
        receive_shadow=False,
    )


def add_lines(scene: viser.SceneApi, name: str, thickness_m: float) -> viser.LineSegmentsHandle:
    """Add a node for line segments, which are set later."""
    points: NDArray[np.float32] = np.zeros((1, 2, 3), dtype=np.float32)
    return scene.add_line_segments(name, points, points.astype(np.uint8), thickness=thickness_m)


def on_instance_click(handle: viser.BatchedMeshHandle, names: Sequence[str], on_click: OnClick) -> None:
    """Call with the name of the clicked instance; `names` in the instances' order."""

    def clicked(event: viser.SceneNodePointerEvent[viser.BatchedMeshHandle]) -> None:
        if event.instance_index is not None and event.instance_index < len(names):
            on_click(names[event.instance_index])

    handle.on_click(clicked)
