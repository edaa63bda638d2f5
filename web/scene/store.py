"""The building, drawn once: floors, walls with their openings, places and their beacons."""

from math import atan2, cos, radians, sin, tan

import numpy as np
import viser

from web.layout import Floor, Layout, Location, Point, Rock, Wall
from web.scene import palette
from web.scene.geometry import box, cylinder, merged, turned

FLOOR_M = 0.04
WALL_HEIGHT_M, WALL_WIDTH_M = 0.32, 0.08
OPENING_HEIGHT_M = 0.10
ROCK_HEIGHT_M = 0.4
PAD_M, PAD_HEIGHT_M = 0.44, 0.012
LETTERS_M = 0.17
"""Height of the letters on the floor."""
BEACON_HEIGHT_M, BEAM_M = 0.36, 0.26
CAMERA_FOV_RAD = radians(45)
CAMERA_ELEVATION_RAD = radians(58)
SLIMMEST_ASPECT = 0.85


def draw_store(server: viser.ViserServer, layout: Layout) -> None:
    """Draw everything of the layout that never moves."""
    for index, compartment in enumerate(layout.compartments):
        colours = palette.FLOORS[index % 2], palette.AISLES
        _draw_floor(server, f"/{compartment.name}/floor", compartment, colours[0], 0.0)
        for number, aisle in enumerate(compartment.aisles):
            _draw_floor(server, f"/{compartment.name}/{aisle.name}", aisle, colours[1][number % 2], 0.004)
    _draw_walls(server, layout.walls)
    _draw_rocks(server, layout.obstacles)
    for kind in sorted({place.kind for place in layout.locations}):
        _draw_places(server, kind, [place for place in layout.locations if place.kind == kind])
    _label_places(server, layout)
    _draw_beacons(server, layout.locations)


def aim_camera(server: viser.ViserServer, layout: Layout) -> None:
    """Set the camera south of the store and above it, so far off that the whole of it is in view."""
    (west, south), (east, north) = layout.bounds
    middle = ((west + east) / 2, (south + north) / 2, 0.0)
    # The floor's depth looks shorter from this height; its width has to fit a window higher than wide.
    depth = (north - south) * sin(CAMERA_ELEVATION_RAD)
    extent = max(depth, (east - west) / SLIMMEST_ASPECT) * 1.18
    away = extent / 2 / tan(CAMERA_FOV_RAD / 2) + (north - south) / 2 * cos(CAMERA_ELEVATION_RAD)
    camera = server.initial_camera
    camera.fov = CAMERA_FOV_RAD
    camera.look_at = middle
    camera.position = (
        middle[0],
        middle[1] - away * cos(CAMERA_ELEVATION_RAD),
        away * sin(CAMERA_ELEVATION_RAD),
    )


def _draw_floor(
    server: viser.ViserServer, name: str, floor: Floor, colour: palette.Colour, raised_m: float
) -> None:
    size = (floor.x[1] - floor.x[0], floor.y[1] - floor.y[0], FLOOR_M)
    middle = (sum(floor.x) / 2, sum(floor.y) / 2, raised_m - FLOOR_M / 2)
    vertices, faces = box(size)
    server.scene.add_mesh_simple(
        name, vertices, faces, color=colour, position=middle, cast_shadow=False, receive_shadow=False
    )


def light_store(server: viser.ViserServer) -> None:
    """Soft light from everywhere and a little from the south-west, so that edges are told apart."""
    server.scene.add_light_ambient("/lights/ambient", intensity=1.7)
    server.scene.add_light_directional(
        "/lights/sun", intensity=1.5, position=(-4.0, -7.0, 10.0), cast_shadow=False
    )


def wall_pieces(wall: Wall) -> list[tuple[str, float, float]]:
    """The wall along its length: (kind, from, to) in metres from its start, kind `wall` or an opening's."""
    pieces, reached = [], 0.0
    for opening in sorted(wall.openings, key=lambda opening: opening.at_m):
        begin, end = opening.at_m - opening.width_m / 2, opening.at_m + opening.width_m / 2
        if begin > reached:
            pieces.append(("wall", reached, begin))
        pieces.append((opening.kind, max(begin, reached), end))
        reached = end
    if wall.length_m > reached:
        pieces.append(("wall", reached, wall.length_m))
    return pieces


def _draw_walls(server: viser.ViserServer, walls: tuple[Wall, ...]) -> None:
    positions, headings, scales, colours = [], [], [], []
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
        server.scene.add_batched_meshes_simple(
            "/walls",
            *box(),
            batched_wxyzs=turned(headings),
            batched_positions=np.array(positions, dtype=np.float32),
            batched_scales=np.array(scales, dtype=np.float32),
            batched_colors=palette.batched(colours),
            lod="off",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )


def _draw_rocks(server: viser.ViserServer, rocks: tuple[Rock, ...]) -> None:
    """Each where the world file has it: a seed may have put it a little elsewhere."""
    for rock in rocks:
        stump = cylinder(rock.radius_m, 0.0, ROCK_HEIGHT_M, top_radius_m=0.8 * rock.radius_m, sides=12)
        server.scene.add_mesh_simple(
            f"/obstacles/{rock.name}",
            *stump,
            color=palette.ROCK,
            position=(*rock.at, 0.0),
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )


def _draw_places(server: viser.ViserServer, kind: str, places: list[Location]) -> None:
    colour = palette.PLACES.get(kind, palette.PLACES["place"])
    server.scene.add_batched_meshes_simple(
        f"/places/{kind}",
        *box((PAD_M, PAD_M, PAD_HEIGHT_M), (0.0, 0.0, PAD_HEIGHT_M / 2 + 0.004)),
        batched_wxyzs=turned([0.0] * len(places)),
        batched_positions=np.array([(*place.at, 0.0) for place in places], dtype=np.float32),
        batched_colors=palette.batched([colour] * len(places)),
        lod="off",
        cast_shadow=False,
        receive_shadow=False,
    )


def _label_places(server: viser.ViserServer, layout: Layout) -> None:
    """Each place's name south of its pad; of a rack's berths the numbers on their pads and the name south of all."""
    south = {place.name: place.at[1] - PAD_M / 2 - 0.04 for place in layout.locations}
    for place in layout.locations:
        if place.kind != "home" and place.name not in layout.berths:  # a home's robot's label says enough
            _label(server, place, place.name, (place.at[0], south[place.name]))
    for rack in layout.racks:
        _label(server, rack, rack.name, (rack.at[0], min(south[berth] for berth in rack.berths)))
    for berth in (place for place in layout.locations if place.name in layout.berths):
        _label(server, berth, berth.name.rpartition("_")[2], (berth.at[0], berth.at[1] + LETTERS_M / 2))


def _label(server: viser.ViserServer, place: Location, text: str, top: Point) -> None:
    server.scene.add_label(
        f"/places/{place.kind}/{place.name}",
        text,
        position=(*top, 0.0),
        font_size_mode="scene",
        font_scene_height=LETTERS_M,
        anchor="top-center",
    )


def _draw_beacons(server: viser.ViserServer, places: tuple[Location, ...]) -> None:
    post = merged(
        [cylinder(0.014, 0.0, BEACON_HEIGHT_M, sides=8), box((0.07, 0.07, 0.07), (0.0, 0.0, BEACON_HEIGHT_M))]
    )
    server.scene.add_batched_meshes_simple(
        "/beacons",
        *post,
        batched_wxyzs=turned([0.0] * len(places)),
        batched_positions=np.array([(*place.at, 0.0) for place in places], dtype=np.float32),
        batched_colors=palette.batched([palette.BEACON] * len(places)),
        lod="off",
        cast_shadow=False,
        receive_shadow=False,
    )
    beams = [
        [(*place.at, BEACON_HEIGHT_M), _beam_end(place.at, degrees)]
        for place in places
        for degrees in place.approach_deg
    ]
    if beams:
        points = np.array(beams, dtype=np.float32)
        server.scene.add_line_segments("/beacons/beams", points, palette.BEAM, thickness=0.015)


def _beam_end(at: tuple[float, float], degrees: float) -> tuple[float, float, float]:
    return at[0] + BEAM_M * cos(radians(degrees)), at[1] + BEAM_M * sin(radians(degrees)), BEACON_HEIGHT_M
