"""The simulated doors, hatches and lifts of a world: their mechanisms and their software."""

from collections.abc import Mapping, Sequence

from robots.adapters.peripheral import PeripheralAgent, PeripheralProfile
from robots.clock import Clock
from robots.contract.memory_file import TextMemory
from robots.world import Peripheral, WorldFile
from sim.physics.scene import Scene
from sim.snapshot import PeripheralState
from sim.world.hub import Hub
from sim.world.mechanisms import Fault, SimulatedMechanism


class Peripherals:
    """All that a world simulates of them; `move` and `tick` in each control cycle."""

    def __init__(
        self,
        world: WorldFile,
        *,
        scene: Scene,
        hub: Hub,
        clock: Clock,
        run: str,
        states: Mapping[str, PeripheralState],
    ) -> None:
        """:param states: of those that go on from a snapshot."""
        specs: Sequence[Peripheral] = world.simulated_peripherals
        self._memories = {
            spec.name: TextMemory(states[spec.name].memory if spec.name in states else "") for spec in specs
        }
        self.mechanisms = {
            spec.name: SimulatedMechanism(spec, scene, states.get(spec.name)) for spec in specs
        }
        self._agents = {
            spec.name: PeripheralAgent(
                profile_of(spec),
                mechanism=self.mechanisms[spec.name],
                link=hub.link_of(spec.name),
                clock=clock,
                store=self._memories[spec.name],
                run=run,
                round_trip_s=world.links[spec.name].round_trip_s,
            )
            for spec in specs
        }

    @property
    def is_still(self) -> bool:
        return not any(mechanism.is_moving for mechanism in self.mechanisms.values())

    def tick(self, step_s: float) -> None:
        """Move the panels for a control cycle and let the software run."""
        for name, agent in self._agents.items():
            mechanism = self.mechanisms[name]
            if mechanism.broken is not Fault.SILENT:
                agent.tick()
                mechanism.move(step_s)

    def snapshot(self) -> dict[str, PeripheralState]:
        return {
            name: mechanism.snapshot(self._memories[name].text) for name, mechanism in self.mechanisms.items()
        }


def profile_of(spec: Peripheral) -> PeripheralProfile:
    """What the software of a door, hatch or lift is told of it."""
    x_m, y_m = spec.centre
    return PeripheralProfile(
        name=spec.name,
        x_m=x_m,
        y_m=y_m,
        levels=spec.levels,
        closes_after_s=spec.stays_open_s if not spec.is_lift and spec.normally == "closed" else None,
    )
