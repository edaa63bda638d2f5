"""Moves rovers and samples of a simulated world from outside. A robot is not told; it must sense what has happened."""

from dataclasses import replace
from math import cos, dist, sin

from robots.physical.body import RADIUS_M, Pose
from robots.world.walls import clearance_m, panels_of
from sim.world.simulation import Simulation

CLEARANCE_M = RADIUS_M + 0.02
"""Least distance of a rover's middle from a wall when it is set down."""


def push(simulation: Simulation, rover: str, *, ahead_m: float = 0.0, left_m: float = 0.0) -> None:
    """Push a rover over the floor: its wheels turn with the part along its heading only.

    :raises ValueError: if there is no room for it.
    """
    pose = simulation.scene.pose(rover)
    cosine = cos(pose.heading_rad)
    sine = sin(pose.heading_rad)
    x_m = pose.x_m + ahead_m * cosine - left_m * sine
    y_m = pose.y_m + ahead_m * sine + left_m * cosine
    set_down(simulation, rover, replace(pose, x_m=x_m, y_m=y_m))


def has_room(simulation: Simulation, rover: str, pose: Pose) -> bool:
    """True if a rover can stand there without touching a wall or another rover."""
    point = (pose.x_m, pose.y_m)
    others = [simulation.scene.pose(name) for name in simulation.bodies if name != rover]
    free = all(dist(point, (other.x_m, other.y_m)) > 2 * CLEARANCE_M for other in others)
    return free and clearance_m(point, panels_of(simulation.world.walls)) >= CLEARANCE_M


def set_down(simulation: Simulation, rover: str, pose: Pose) -> None:
    """:raises ValueError: if there is no room for it."""
    if not has_room(simulation, rover, pose):
        raise ValueError(f"no room for {rover} at ({pose.x_m:.2f}, {pose.y_m:.2f})")
    simulation.scene.put_rover(rover, pose)
