"""Names on a page's own picture of the world: of robots and samples so many as have room beside each other, of places
those that are not behind one.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from web.scene.eye import Eye, Floats

LETTER_PX, LINE_PX = 8.0, 20.0
"""What a letter of a label takes of the picture, generously."""
LETTER, LINE = 0.65, 1.4
"""What a letter of a floor label takes, with its frame, in heights of a letter."""
MOST = 60
CHOSEN_FIRST, ROBOTS_NEXT, SAMPLES_LAST = 0, 1, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """At a point of the world, metres."""

    name: str
    text: str
    at: tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Label(Text):
    """One that faces who looks, above its point; of those of lower `rank` first."""

    rank: int


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorLabel(Text):
    """One that lies on the floor, below its point, in letters so high, metres."""

    letters_m: float


def with_room(labels: Sequence[Label], eye: Eye) -> list[Label]:
    """Those that are shown: by rank and nearness, each only where no other is yet."""
    if not labels:
        return []
    spots = eye.sees(_points(labels))
    boxes = _boxes(labels, spots)
    x, y, depth = spots.T
    seen = (depth > 0) & (x >= 0) & (x <= eye.width_px) & (y >= 0) & (y <= eye.height_px)
    left = np.lexsort((depth, [label.rank for label in labels]))
    left = left[seen[left]]
    chosen: list[Label] = []
    while len(left) and len(chosen) < MOST:
        chosen.append(labels[left[0]])
        left = left[~_overlaps(boxes[left[:1]], boxes[left])[0]]
    return chosen


def covered(floor: Sequence[FloorLabel], shown: Sequence[Label], eye: Eye) -> list[bool]:
    """Which of the floor's labels are behind one that is shown."""
    if not floor or not shown:
        return [False] * len(floor)
    spots = eye.sees(_points(floor))
    high = eye.px_a_metre(spots[:, 2]) * [label.letters_m for label in floor]
    half = high * LETTER * [len(label.text) / 2 for label in floor]
    x, y = spots[:, 0], spots[:, 1]
    below = np.stack([x - half, y, x + half, y + high * LINE], axis=-1)
    over = _overlaps(below, _boxes(shown, eye.sees(_points(shown))))
    return [bool(row.any()) for row in over]


def _points(labels: Sequence[Text]) -> Floats:
    return np.array([label.at for label in labels], dtype=np.float64)


def _boxes(labels: Sequence[Label], spots: Floats) -> Floats:
    """What labels take of the picture, shape (N, 4): left, top, right and bottom, pixels."""
    half = np.array([len(label.text) * LETTER_PX / 2 for label in labels])
    x, y = spots[:, 0], spots[:, 1]
    return np.stack([x - half, y - LINE_PX, x + half, y], axis=-1)


def _overlaps(these: Floats, those: Floats) -> NDArray[np.bool_]:
    """Shape (these, those)."""
    one, other = these[:, None, :], those[None, :, :]
    apart = (one[..., :2] >= other[..., 2:]) | (other[..., :2] >= one[..., 2:])
    return ~(apart[..., 0] | apart[..., 1])


class LabelsView:
    """Draws the labels that were chosen; those that were not are hidden, not taken away: they come again."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._handles: dict[str, viser.LabelHandle] = {}
        self.shown: frozenset[str] = frozenset()
        """The names of those that were chosen."""

    def choose(self, labels: Sequence[Label], eye: Eye) -> None:
        """Decide anew which are shown."""
        self.shown = frozenset(label.name for label in with_room(labels, eye))

    def update(self, labels: Iterable[Label]) -> None:
        wanted: Mapping[str, Label] = {label.name: label for label in labels if label.name in self.shown}
        for name, handle in self._handles.items():
            if handle.visible != (name in wanted):
                handle.visible = name in wanted
        for name, label in wanted.items():
            handle = self._handles.get(name) or self._add(label)
            handle.position = label.at
            if handle.text != label.text:
                handle.text = label.text

    def _add(self, label: Label) -> viser.LabelHandle:
        handle = self._scene.add_label(
            f"/labels/{label.name}", label.text, anchor="bottom-center", font_screen_scale=0.9
        )
        self._handles[label.name] = handle
        return handle


class FloorLabelsView:
    """Writes on the floor, and hides what a label of a robot or a sample is in front of."""

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

    def make_room(self, shown: Sequence[Label], eye: Eye) -> None:
        for handle, hidden in zip(self._handles, covered(self._labels, shown, eye), strict=True):
            if handle.visible == hidden:
                handle.visible = not hidden
