"""Names of robots and samples: so many as have room beside each other on a page's own picture of the world."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import viser

from web.scene.eye import Eye

LETTER_PX, LINE_PX = 8.0, 20.0
"""What a letter of a label takes of the picture, generously."""
MOST = 60
CHOSEN_FIRST, ROBOTS_NEXT, SAMPLES_LAST = 0, 1, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Label:
    """A text at a point of the world, metres; of those of lower `rank` first."""

    name: str
    text: str
    at: tuple[float, float, float]
    rank: int


def with_room(labels: Sequence[Label], eye: Eye) -> list[Label]:
    """Those that are shown: by rank and nearness, each only where no other is yet."""
    if not labels:
        return []
    spots = eye.sees(np.array([label.at for label in labels]))
    shown: list[tuple[float, float, float, float]] = []
    chosen = []
    for index in sorted(range(len(labels)), key=lambda i: (labels[i].rank, spots[i, 2])):
        x, y, depth = spots[index]
        if depth <= 0 or not (0 <= x <= eye.width_px and 0 <= y <= eye.height_px):
            continue
        half = len(labels[index].text) * LETTER_PX / 2
        box = (x - half, y - LINE_PX, x + half, y)
        if any(_overlap(box, other) for other in shown):
            continue
        shown.append(box)
        chosen.append(labels[index])
        if len(chosen) == MOST:
            break
    return chosen


def _overlap(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


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
