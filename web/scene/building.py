"""The building, drawn once: floors, walls with their openings, places and their beacons."""

from collections.abc import Sequence
from math import atan2, cos, radians, sin

import numpy as np
import viser

from web.api_types import Fact, Floor, Layout, Location, Obstacle, Point, Wall
from web.scene import palette
from web.scene.geometry import box, cylinder, merged
from web.scene.labels import FloorLabel
from web.scene.nodes import OnClick, add_instances, add_mesh, on_instance_click

FLOOR_M = 0.04
WALL_HEIGHT_M = 0.32
WALL_WIDTH_M = 0.08
OPENING_HEIGHT_M = 0.10
OBSTACLE_HEIGHT_M = 0.4
PAD_M = 0.44
PAD_HEIGHT_M = 0.012
LETTERS_M = 0.17
"""Height of the letters on the floor."""
BEACON_HEIGHT_M = 0.36
BEAM_M = 0.26


def draw_building(scene: viser.SceneApi, layout: Layout, theme: palette.Theme) -> None:
    """Draw everything of the layout that never moves."""
    for index, compartment in enumerate(layout.compartments):
        _draw_floor(scene, f"/{compartment.name}/floor", compartment, theme.floors[index % 2], 0.0)
        for number, aisle in enumerate(compartment.aisles):
            _draw_floor(scene, f"/{compartment.name}/{aisle.name}", aisle, theme.aisles[number % 2], 0.004)
    for slope in layout.slopes:
        _draw_floor(scene, f"/slopes/{slope.name}", slope, theme.slope, 0.006)
    for number, zone in enumerate(layout.zones):
        _draw_floor(scene, f"/zones/{zone.name}", zone, theme.zones[zone.rule], 0.008 + 0.0005 * number)
    _draw_walls(scene, layout.walls)
    _draw_obstacles(scene, layout.obstacles)
    if layout.locations:
        _draw_beacons(scene, layout.locations)


def _draw_floor(
    scene: viser.SceneApi, name: str, floor: Floor, colour: palette.Colour, raised_m: float
) -> None:
    size = (floor.x[1] - floor.x[0], floor.y[1] - floor.y[0], FLOOR_M)
    middle = (sum(floor.x) / 2, sum(floor.y) / 2, raised_m - FLOOR_M / 2)
    add_mesh(scene, name, box(size), colour, middle)


def wall_pieces(wall: Wall) -> list[tuple[str, float, float]]:
    """The wall along its length: (kind, from, to) in metres from its start, kind `wall` or an opening's."""
    pieces = []
    reached = 0.0
    for opening in sorted(wall.openings, key=lambda opening: opening.at_m):
        begin = opening.at_m - opening.width_m / 2
        end = opening.at_m + opening.width_m / 2
        if begin > reached:
            pieces.append(("wall", reached, begin))
        pieces.append((opening.kind, max(begin, reached), end))
        reached = end
    if wall.length_m > reached:
        pieces.append(("wall", reached, wall.length_m))
    return pieces


def _draw_walls(scene: viser.SceneApi, walls: tuple[Wall, ...]) -> None:
    positions = []
    headings = []
    scales = []
    colours = []
    for wall in walls:
        heading = atan2(wall.end[1] - wall.start[1], wall.end[0] - wall.start[0])
        for kind, begin, end in wall_pieces(wall):
            if kind == "gap":
                continue
            height = WALL_HEIGHT_M if kind == "wall" else OPENING_HEIGHT_M
            middle = (begin + end) / 2
            positions.append(
                (wall.start[0] + middle * cos(heading), wall.start[1] + middle * sin(heading), height / 2)
            )
            headings.append(heading)
            scales.append((end - begin + (WALL_WIDTH_M if kind == "wall" else 0), WALL_WIDTH_M, height))
            colours.append(palette.WALL if kind == "wall" else palette.OPENINGS.get(kind, palette.WALL))
    if positions:
        add_instances(
            scene,
            "/walls",
            box(),
            positions,
            colours,
            headings_rad=headings,
            scales=scales,
            flat_shading=True,
        )


def _draw_obstacles(scene: viser.SceneApi, obstacles: tuple[Obstacle, ...]) -> None:
    """Draw the obstacles at their places in the world file; a seed may have moved them slightly."""
    for one in obstacles:
        cone = cylinder(one.radius_m, 0.0, OBSTACLE_HEIGHT_M, top_radius_m=0.8 * one.radius_m, sides=12)
        add_mesh(scene, f"/obstacles/{one.name}", cone, palette.OBSTACLE, (*one.at, 0.0), flat_shading=True)


class PlacesView:
    """The pads of the places, one batched node per kind; those with a sample are darker."""

    def __init__(self, scene: viser.SceneApi, layout: Layout, on_click: OnClick) -> None:
        self._kinds: dict[str, tuple[tuple[str, ...], viser.BatchedMeshHandle]] = {}
        self._occupied: frozenset[str] = frozenset()
        for kind in sorted({place.kind for place in layout.locations}):
            places = [place for place in layout.locations if place.kind == kind]
            names = tuple(place.name for place in places)
            self._kinds[kind] = names, _pads(scene, kind, places, on_click)

    def update(self, facts: Sequence[Fact]) -> None:
        """Show which places hold a sample, by the facts."""
        occupied = frozenset(fact.args[1] for fact in facts if fact.predicate == "in" and len(fact.args) == 2)
        if occupied == self._occupied:
            return
        self._occupied = occupied
        for kind, (names, pads) in self._kinds.items():
            colours = [palette.OCCUPIED if name in occupied else _colour(kind) for name in names]
            pads.batched_colors = palette.batched(colours)


def _colour(kind: str) -> palette.Colour:
    return palette.PLACES.get(kind, palette.PLACES["place"])


def _pads(
    scene: viser.SceneApi, kind: str, places: list[Location], on_click: OnClick
) -> viser.BatchedMeshHandle:
    pad = box((PAD_M, PAD_M, PAD_HEIGHT_M), (0.0, 0.0, PAD_HEIGHT_M / 2 + 0.004))
    positions = [(*place.at, 0.0) for place in places]
    pads = add_instances(scene, f"/places/{kind}", pad, positions, [_colour(kind)] * len(places))
    on_instance_click(pads, [place.name for place in places], on_click)
    return pads


def place_labels(layout: Layout) -> list[FloorLabel]:
    """Each place's name south of its pad; berths' numbers on their pads, with their rack's name south of them."""
    south = {place.name: place.at[1] - PAD_M / 2 - 0.04 for place in layout.locations}
    labels = [
        _label(place, place.name, (place.at[0], south[place.name]))
        for place in layout.locations
        if place.kind != "home" and place.name not in layout.berths  # a home is labelled by its robot
    ]
    for rack in layout.racks:
        labels.append(_label(rack, rack.name, (rack.at[0], min(south[berth] for berth in rack.berths))))
    for berth in (place for place in layout.locations if place.name in layout.berths):
        labels.append(
            _label(berth, berth.name.rpartition("_")[2], (berth.at[0], berth.at[1] + LETTERS_M / 2))
        )
    return labels


def _label(place: Location, text: str, top: Point) -> FloorLabel:
    return FloorLabel(name=f"{place.kind}/{place.name}", text=text, at=(*top, 0.0), letters_m=LETTERS_M)


def _draw_beacons(scene: viser.SceneApi, places: tuple[Location, ...]) -> None:
    post = merged(
        [cylinder(0.014, 0.0, BEACON_HEIGHT_M, sides=8), box((0.07, 0.07, 0.07), (0.0, 0.0, BEACON_HEIGHT_M))]
    )
    positions = [(*place.at, 0.0) for place in places]
    add_instances(scene, "/beacons", post, positions, [palette.BEACON] * len(places))
    beams = [
        [(*place.at, BEACON_HEIGHT_M), _beam_end(place.at, degrees)]
        for place in places
        for degrees in place.approach_deg
    ]
    if beams:
        points = np.array(beams, dtype=np.float32)
        scene.add_line_segments("/beacons/beams", points, palette.BEAM, thickness=0.015)


def _beam_end(at: tuple[float, float], degrees: float) -> tuple[float, float, float]:
    return at[0] + BEAM_M * cos(radians(degrees)), at[1] + BEAM_M * sin(radians(degrees)), BEACON_HEIGHT_M
