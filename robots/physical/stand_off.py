"""Where a robot stands that is near a location; without anything that a world file's check need not load."""

STAND_OFF_M = 0.8
"""`near` a location: on its beacon's emitting axis, this far from the beacon's floor point, facing it."""
