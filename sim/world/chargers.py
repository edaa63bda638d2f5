"""Which rovers are at a charger: each charges one at a time, whether it is a rover's home or shared (our choice)."""

from collections.abc import Collection, Mapping
from math import dist

from robots.world import WorldFile
from sim.bodies import SimulatedBody
from sim.physics.scene import Scene

RANGE_M = 1.1
"""Distance from the charger's beacon within which a rover can be charged: by its approach point."""


class Chargers:
    """The chargers of a world. Those that charge a rover are known by the rovers that are being charged."""

    def __init__(self, world: WorldFile) -> None:
        self._of = {
            spec.name: [(place.name, place.at) for place in world.chargers_of(spec)]
            for spec in world.simulated
        }

    def serve(self, bodies: Mapping[str, SimulatedBody], scene: Scene) -> Collection[str]:
        """The rovers that are charged if they stand still: of several at a charger the one that it charges already,
        else the first."""
        needing = [name for name, body in bodies.items() if self._of[name] and body.battery.needs_charge]
        needing.sort(key=lambda name: not bodies[name].battery.charging)
        taken: set[str] = set()
        served: set[str] = set()
        for name in needing:
            pose = scene.pose(name)
            near = (place for place, at in self._of[name] if dist(at, (pose.x_m, pose.y_m)) <= RANGE_M)
            free = next((place for place in near if place not in taken), None)
            if free is not None:
                taken.add(free)
                served.add(name)
        return served
