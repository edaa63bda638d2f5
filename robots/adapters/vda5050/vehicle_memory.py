"""What outlives a restart of the adapter for one vehicle."""

from typing import Literal

from pydantic import Field

from robots.adapters.vda5050.orders import Route
from robots.data import Memory
from robots.wire import BehaviourPacket, BehaviourScript, RobotFault


class VehicleMemory(Memory):
    """The driver's memory.

    `scripts`: the newest that were accepted, for the horizon; `packet`: the one begun last, with its `outcome` and
    `detail` once it has ended; `stop`: why it must end; `route`: the vehicle's order; `released`: its legs that the
    vehicle knows, or may know, as released; `finished`: those that are done; `confirmed`: the vehicle has had it;
    `attempts`: orders that were made for the script; `cancelling`: an order that the vehicle must give up; `requests`:
    counts instant actions, for their ids; `paused`: what is asked for, None once the vehicle goes on again; `pause_id`:
    the startPause that was sent last; `holding`: the object that was picked up last;
    `faults`: those that were reported last.
    """

    scripts: dict[str, BehaviourScript] = Field(default_factory=dict)
    packet: BehaviourPacket | None = None
    outcome: Literal["finished", "failed"] | None = None
    detail: str = ""
    stop: str | None = None
    route: Route | None = None
    released: int = 0
    finished: int = 0
    confirmed: bool = False
    attempts: dict[str, int] = Field(default_factory=dict)
    cancelling: str | None = None
    requests: int = 0
    paused: bool | None = None
    pause_id: str = ""
    holding: str | None = None
    faults: tuple[RobotFault, ...] = ()
