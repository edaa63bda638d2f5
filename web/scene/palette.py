"""The view's colours (red, green, blue, 0 to 255): muted for the building, strong for what moves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """The colours that depend on the page's theme.

    Neighbouring floors have the first and the second colour in turn; so do neighbouring aisles. `zones`: by rule.
    """

    floors: tuple[Colour, Colour]
    aisles: tuple[Colour, Colour]
    slope: Colour
    zones: Mapping[str, Colour]
    trim: Colour


LIGHT = Theme(
    floors=((206, 211, 205), (194, 203, 208)),
    aisles=((205, 208, 196), (192, 204, 205)),
    slope=(211, 201, 180),
    zones={
        "named": (190, 208, 190),
        "keep_out": (222, 170, 164),
        "one_robot": (196, 184, 222),
        "slow": (226, 208, 150),
    },
    trim=(46, 52, 54),
)
DARK = Theme(
    floors=((58, 66, 70), (50, 60, 68)),
    aisles=((66, 74, 70), (54, 70, 72)),
    slope=(78, 72, 60),
    zones={
        "named": (62, 84, 70),
        "keep_out": (112, 58, 58),
        "one_robot": (82, 70, 110),
        "slow": (104, 90, 46),
    },
    trim=(176, 184, 186),
)
WALL: Colour = (120, 128, 126)
OPENINGS: dict[str, Colour] = {"door": (198, 143, 62), "hatch": (86, 145, 140), "gap": (150, 158, 156)}
PLACES: dict[str, Colour] = {
    "door": (222, 160, 66),
    "interchange": (70, 155, 145),
    "bay": (104, 134, 176),
    "rack": (104, 134, 176),
    "dock": (176, 128, 104),
    "home": (160, 160, 158),
    "charger": (214, 184, 60),
    "lander": (150, 110, 170),
    "place": (140, 150, 120),
}
OBSTACLE: Colour = (132, 122, 112)
BEACON: Colour = (190, 60, 60)
BEAM: Colour = (214, 120, 110)
ROBOTS: tuple[Colour, ...] = (
    (31, 111, 139),
    (52, 152, 110),
    (196, 88, 62),
    (128, 92, 168),
    (170, 130, 30),
    (70, 90, 110),
)
NOSE: Colour = (240, 240, 232)
SAMPLE: Colour = (228, 186, 40)
OCCUPIED: Colour = (44, 74, 124)
SELECTED: Colour = (255, 122, 24)
WHISKER_HIT: Colour = (206, 92, 60)
WHISKER_FREE: Colour = (168, 182, 184)


def batched(colours: Sequence[Colour]) -> NDArray[np.uint8]:
    """The colours of a batched node's instances, shape (N, 3), in linear light as viser expects."""
    display = np.array(colours, dtype=np.float64).reshape(-1, 3) / 255
    linear = np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)
    instances: NDArray[np.uint8] = np.rint(linear * 255).astype(np.uint8)
    return instances


def of_robots(names: Sequence[str]) -> dict[str, Colour]:
    """Each robot's colour, by its position in the world's list."""
    return {name: ROBOTS[index % len(ROBOTS)] for index, name in enumerate(names)}


def faded(colour: Colour, share: float, theme: Theme) -> Colour:
    """The colour mixed with the floor's, of which it is `share`."""
    red, green, blue = (
        round(share * own + (1 - share) * floor) for own, floor in zip(colour, theme.floors[0], strict=True)
    )
    return red, green, blue
