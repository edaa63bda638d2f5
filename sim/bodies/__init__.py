"""Rovers' simulated bodies: each implements `robots.body.Body`, so that the same software runs on any of them.

`simulated.py` holds what all share (gripper, sensors, battery), `velocity.py` a body that has the velocity it is told.
"""

from sim.bodies.making import make_body
from sim.bodies.simulated import SimulatedBody

__all__ = ["SimulatedBody", "make_body"]
