"""Rovers' simulated bodies: each implements `robots.body.Body`, so that the same software runs on any of them.

`simulated.py` holds what all share (gripper, sensors, battery). Each kind has its own way to move and to count it:
`velocity.py` has the velocity it is told, `wheeled.py` drives by its `axle.py` and counts by its `encoders.py`,
`avatar.py` is virtual, takes up a velocity as the first does, and goes by the `floor.py`. The world file says which one
a robot has, and by which sonar it hears: the real one, a virtual one that hears avatars by the `workbench.py`, or both
in a row.
"""

from sim.bodies.base import SimulatedBody
from sim.bodies.factory import make_bodies
from sim.bodies.floor import FloorMap

__all__ = ["FloorMap", "SimulatedBody", "make_bodies"]
