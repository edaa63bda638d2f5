"""Pictures of the scene: what is ahead is in them, and taking one changes nothing."""

import struct
import zlib
from math import pi

import numpy as np

from robots.physical.body import Pose
from robots.world.walls import Panel
from sim.physics.camera import SKY, Pixels, png
from sim.physics.scene import SAMPLE_COLOUR, Placed, Scene
from tests.sim.rig import run_s, simulate, two_rooms


def shot(scene: Scene, heading_rad: float = 0.0) -> Pixels:
    scene.put_rover("fred", Pose(x_m=0, y_m=0, heading_rad=heading_rad))
    return scene.picture("fred", width=80, height=60, view_deg=50)


def yellow(pixels: Pixels) -> tuple[int, float]:
    """How many pixels are a sample's, and in which column their middle is."""
    red, green, blue = (pixels[:, :, colour].astype(int) for colour in range(3))
    is_sample = (red > 2 * blue) & (abs(red - green) < red * (1 - SAMPLE_COLOUR[1] / SAMPLE_COLOUR[0]) + 20)
    columns = np.nonzero(is_sample)[1]
    return len(columns), float(columns.mean()) if len(columns) else -1.0


def test_what_stands_ahead_is_in_the_picture_and_what_stands_behind_is_not() -> None:
    pose = Pose(x_m=0, y_m=0, heading_rad=0)
    scene = Scene([], {"fred": pose}, {"rock": Placed((1.0, 0.0))})
    ahead, middle = yellow(shot(scene))
    assert ahead > 20
    assert abs(middle - 39.5) < 2
    _, left = yellow(shot(scene, -0.2))
    assert left < middle - 5, "the robot has turned right, so what was ahead is on its left"
    assert yellow(shot(scene, pi))[0] == 0
    assert shot(scene)[0, 0].tolist() == list(SKY)
    scene.close()


def test_a_wall_hides_what_stands_behind_it() -> None:
    wall = Panel(start=(0.6, -1.0), end=(0.6, 1.0))
    scene = Scene([wall], {"fred": Pose(x_m=0, y_m=0, heading_rad=0)}, {"rock": Placed((1.0, 0.0))})
    assert yellow(shot(scene))[0] == 0
    scene.close()


def test_taking_a_picture_changes_nothing() -> None:
    plain, _ = simulate(two_rooms(second=(1.4, 0.6, 0)))
    pictured, _ = simulate(two_rooms(second=(1.4, 0.6, 0)))
    for _ in range(5):
        first = pictured.scene.picture("fred", width=40, height=30, view_deg=50)
        assert np.array_equal(first, pictured.scene.picture("fred", width=40, height=30, view_deg=50))
        for simulation in (plain, pictured):
            simulation.bodies["fred"].set_velocity(0.4, 0.5)
            run_s(simulation, 0.2)
    assert plain.truth() == pictured.truth()
    for simulation in (plain, pictured):
        simulation.close()


def test_a_png_holds_the_pixels() -> None:
    pixels = np.arange(4 * 3 * 3, dtype=np.uint8).reshape(3, 4, 3)
    file = png(pixels)
    assert file.startswith(b"\x89PNG\r\n\x1a\n")
    chunks = {}
    at = 8
    while at < len(file):
        size, kind = struct.unpack(">I4s", file[at : at + 8])
        data = file[at + 8 : at + 8 + size]
        assert struct.unpack(">I", file[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + data)
        chunks[kind] = data
        at += 12 + size
    assert struct.unpack(">IIBB", chunks[b"IHDR"][:10]) == (4, 3, 8, 2)
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(3, 13)
    assert not rows[:, 0].any()
    assert np.array_equal(rows[:, 1:].reshape(3, 4, 3), pixels)
    assert chunks[b"IEND"] == b""
