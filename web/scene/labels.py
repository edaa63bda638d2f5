"""Labels in a page's picture of the world: those of robots and samples that do not overlap, and those of places that
none of them covers.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from web.scene.camera import CameraView, Floats
from web.viser_private import move

LETTER_PX = 8.0
LINE_PX = 20.0
"""Width and height of a letter of a label, generously."""
FLOOR_LETTER_WIDTH = 0.65
FLOOR_LINE_HEIGHT = 1.4
"""Width and height of a letter of a floor label with its frame, in heights of a letter."""
MAX_LABELS = 60
SELECTED_RANK = 0
ROBOT_RANK = 1
SAMPLE_RANK = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """A text at a point of the world, metres."""

    name: str
    text: str
    at: tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Label(Text):
    """A label above its point that faces the camera; lower ranks are placed first."""

    rank: int


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorLabel(Text):
    """A label on the floor, south of its point. `letters_m`: height of its letters, metres."""

    letters_m: float


def without_overlap(labels: Sequence[Label], view: CameraView) -> list[Label]:
    """Choose labels by rank and nearness, each only where it overlaps none chosen before."""
    if not labels:
        return []
    spots = view.project(_points(labels))
    boxes = _boxes(labels, spots)
    x, y, depth = spots.T
    seen = (depth > 0) & (x >= 0) & (x <= view.width_px) & (y >= 0) & (y <= view.height_px)
    left = np.lexsort((depth, [label.rank for label in labels]))
    left = left[seen[left]]
    chosen: list[Label] = []
    while len(left) and len(chosen) < MAX_LABELS:
        chosen.append(labels[left[0]])
        left = left[~_overlaps(boxes[left[:1]], boxes[left])[0]]
    return chosen


def covered(floor: Sequence[FloorLabel], shown: Sequence[Label], view: CameraView) -> list[bool]:
    """Tell which of the floor labels are behind one that is shown."""
    if not floor or not shown:
        return [False] * len(floor)
    spots = view.project(_points(floor))
    high = view.px_per_m(spots[:, 2]) * [label.letters_m for label in floor]
    half = high * FLOOR_LETTER_WIDTH * [len(label.text) / 2 for label in floor]
    x = spots[:, 0]
    y = spots[:, 1]
    below = np.stack([x - half, y, x + half, y + high * FLOOR_LINE_HEIGHT], axis=-1)
    over = _overlaps(below, _boxes(shown, view.project(_points(shown))))
    return [bool(row.any()) for row in over]


def _points(labels: Sequence[Text]) -> Floats:
    return np.array([label.at for label in labels], dtype=np.float64)


def _boxes(labels: Sequence[Label], spots: Floats) -> Floats:
    """The labels' boxes in the picture, shape (N, 4): left, top, right and bottom, pixels."""
    half = np.array([len(label.text) * LETTER_PX / 2 for label in labels])
    x = spots[:, 0]
    y = spots[:, 1]
    return np.stack([x - half, y - LINE_PX, x + half, y], axis=-1)


def _overlaps(these: Floats, those: Floats) -> NDArray[np.bool_]:
    """Tell which boxes overlap, shape (these, those)."""
    one = these[:, None, :]
    other = those[None, :, :]
    apart = (one[..., :2] >= other[..., 2:]) | (other[..., :2] >= one[..., 2:])
    return ~(apart[..., 0] | apart[..., 1])


class LabelsView:
    """Draws the chosen labels; the others are hidden, not removed, for they return."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._handles: dict[str, viser.LabelHandle] = {}
        self.shown: frozenset[str] = frozenset()
        """The names of those that were chosen."""

    def choose(self, labels: Sequence[Label], view: CameraView) -> None:
        """Choose the labels that are shown until the next call."""
        self.shown = frozenset(label.name for label in without_overlap(labels, view))

    def update(self, labels: Iterable[Label]) -> None:
        wanted: Mapping[str, Label] = {label.name: label for label in labels if label.name in self.shown}
        for name, handle in self._handles.items():
            if handle.visible != (name in wanted):
                handle.visible = name in wanted
        for name, label in wanted.items():
            handle = self._handles.get(name) or self._add(label)
            move(handle, label.at)
            if handle.text != label.text:
                handle.text = label.text

    def _add(self, label: Label) -> viser.LabelHandle:
        handle = self._scene.add_label(
            f"/labels/{label.name}", label.text, anchor="bottom-center", font_screen_scale=0.9
        )
        self._handles[label.name] = handle
        return handle


class FloorLabelsView:
    """Draws labels on the floor, and hides those that a label of a robot or a sample covers."""

    def __init__(self, scene: viser.SceneApi, labels: Sequence[FloorLabel]) -> None:
        self._labels = labels
        self._handles = [
            scene.add_label(
                f"/places/{label.name}",
                label.text,
                position=label.at,
                font_size_mode="scene",
                font_scene_height=label.letters_m,
                anchor="top-center",
            )
            for label in labels
        ]

    def make_room(self, shown: Sequence[Label], view: CameraView) -> None:
        for handle, hidden in zip(self._handles, covered(self._labels, shown, view), strict=True):
            if handle.visible == hidden:
                handle.visible = not hidden
