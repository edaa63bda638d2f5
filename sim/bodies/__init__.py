"""Rovers' simulated bodies: each implements `robots.physical.body.Body`, so that the same software runs on any of them.

The world file names a robot's body (velocity-set, wheeled, avatar) and its sonar: real, virtual (avatars) or both.
"""

from sim.bodies.avatar import FloorMap
from sim.bodies.base import SimulatedBody
from sim.bodies.factory import make_bodies

__all__ = ["FloorMap", "SimulatedBody", "make_bodies"]
