"""Sends scripts to simulated robots without a service, collects and confirms their reports, and sends clearances."""

from collections.abc import Callable, Sequence
from typing import Self

from robots.wire import (
    BehaviourScript,
    Body,
    Clearance,
    Control,
    ControlVerb,
    Message,
    PacketReport,
    PacketState,
    Performative,
    Receipt,
    Refusal,
    ScriptReport,
    ScriptRequest,
)
from robots.world import WorldFile
from sim.snapshot import WorldSnapshot
from sim.world.agent import AgentFactory
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation


class ScriptRunner:
    """Stands in for the service towards the robots: stores nothing, repeats nothing and recovers nothing.

    `reports` are the packets' reports in the order of arrival; `ended` and `refused` are by the script's id.
    """

    def __init__(
        self,
        world: WorldFile,
        *,
        seed: int,
        jitter_m: float = 0.4,
        make_agent: AgentFactory = behavioural_agent,
    ) -> None:
        self.world = world
        self.simulation = Simulation(world, make_agent=make_agent, seed=seed, jitter_m=jitter_m)
        self.scripts: list[BehaviourScript] = []
        self.reports: list[PacketReport] = []
        self.ended: dict[str, ScriptReport] = {}
        self.refused: dict[str, Refusal] = {}
        self._make_agent = make_agent
        self._finished: set[tuple[str, str]] = set()
        self._seen: set[str] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.simulation.close()

    def restart(self) -> None:
        """End the world and resume it from its snapshot; messages under way are lost."""
        data = self.simulation.snapshot().model_dump_json()
        self.simulation.close()
        snapshot = WorldSnapshot.model_validate_json(data)
        self.simulation = Simulation(self.world, make_agent=self._make_agent, snapshot=snapshot)

    def send(self, scripts: Sequence[BehaviourScript]) -> None:
        """Send scripts to their robots."""
        self.scripts += scripts
        for script in scripts:
            self.tell(script.robot, Performative.REQUEST, ScriptRequest(script=script))

    def cancel(self, script: BehaviourScript) -> None:
        """Cancel a robot's script."""
        order = Control(script_id=script.id, verb=ControlVerb.CANCEL)
        self.tell(script.robot, Performative.CANCEL, order)

    def run(
        self,
        scripts: Sequence[BehaviourScript],
        *,
        timeout_s: float = 600.0,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> bool:
        """Send scripts and step until each has ended or was refused; True if all did.

        :param meanwhile: called at 20 Hz.
        """
        self.send(scripts)
        ids = {script.id for script in scripts}

        def all_ended() -> bool:
            self.receive()
            meanwhile()
            return ids <= {*self.ended, *self.refused}

        return self.simulation.run_until(all_ended, timeout_s=timeout_s)

    def receive(self) -> None:
        """Process the messages that have arrived."""
        for message in self.simulation.link.receive():
            self.take(message)

    def take(self, message: Message) -> None:
        """Process a message that has arrived."""
        body = message.body
        if isinstance(body, Refusal):
            self.refused[body.script_id] = body
        if isinstance(body, PacketReport | ScriptReport):
            self.tell(message.sender, Performative.CONFIRM, Receipt(), in_reply_to=message.id)
            if message.id not in self._seen:
                self._seen.add(message.id)
                self._record(body)

    def _record(self, report: PacketReport | ScriptReport) -> None:
        if isinstance(report, ScriptReport):
            self.ended[report.script_id] = report
            return
        self.reports.append(report)
        if report.state is PacketState.FINISHED:
            self._finished.add((report.script_id, report.packet_id))
            self._send_clearances(report.packet_id)

    def _send_clearances(self, packet_id: str) -> None:
        """Clear the packets that wait for this one, once every robot that executes it has finished it."""
        joint = [
            script for script in self.scripts if any(packet.id == packet_id for packet in script.packets)
        ]
        if all((script.id, packet_id) in self._finished for script in joint):
            for script in self.scripts:
                if any(packet_id in packet.after for packet in script.packets):
                    clearance = Clearance(script_id=script.id, ended=(packet_id,))
                    self.tell(script.robot, Performative.REQUEST, clearance)

    def tell(
        self, robot: str, performative: Performative, body: Body, in_reply_to: str | None = None
    ) -> None:
        """Send a message to a robot, once."""
        self.simulation.link.send(
            Message(
                performative=performative,
                sender="service",
                receiver=robot,
                sent_at_s=self.simulation.clock.now_s(),
                in_reply_to=in_reply_to,
                body=body,
            )
        )
