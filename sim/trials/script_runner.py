"""Robots of a simulated world that are given scripts without a service: their reports kept, confirmed and cleared."""

from collections.abc import Callable, Sequence
from typing import Any, Self

from robots.wire import (
    BehaviourScript,
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
from sim.world.agents import behavioural_agent
from sim.world.simulation import AgentMaker, Simulation


class Crew:
    """Speaks with the robots as a service would over a link that never fails; keeps no record and mends nothing.

    `reports` are the packets' reports as they came; `ended` and `refused` go by the script's id.
    """

    def __init__(
        self,
        world: WorldFile,
        *,
        seed: int,
        jitter_m: float = 0.4,
        make_agent: AgentMaker = behavioural_agent,
    ) -> None:
        self.world = world
        self._make_agent = make_agent
        self.simulation = Simulation(world, make_agent=make_agent, seed=seed, jitter_m=jitter_m)
        self.scripts: list[BehaviourScript] = []
        self.reports: list[PacketReport] = []
        self.ended: dict[str, ScriptReport] = {}
        self.refused: dict[str, Refusal] = {}
        self._over: set[tuple[str, str]] = set()
        self._seen: set[str] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.simulation.close()

    def restart(self) -> None:
        """The world ends and goes on from its snapshot; what is in the air between robots and crew is lost."""
        data = self.simulation.snapshot().model_dump_json()
        self.simulation.close()
        snapshot = WorldSnapshot.model_validate_json(data)
        self.simulation = Simulation(self.world, make_agent=self._make_agent, snapshot=snapshot)

    def send(self, scripts: Sequence[BehaviourScript]) -> None:
        """Hand out scripts."""
        self.scripts += scripts
        for each in scripts:
            self._say(each.robot, Performative.REQUEST, ScriptRequest(script=each))

    def cancel(self, script: BehaviourScript) -> None:
        """Have a robot stop its script."""
        order = Control(script_id=script.id, verb=ControlVerb.CANCEL)
        self._say(script.robot, Performative.CANCEL, order)

    def run(
        self,
        scripts: Sequence[BehaviourScript],
        *,
        timeout_s: float = 600.0,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> bool:
        """Hand out scripts and wait until each has ended or was refused; True if all did.

        :param meanwhile: is called at 20 Hz.
        """
        self.send(scripts)
        names = {each.id for each in scripts}

        def over() -> bool:
            self.hear()
            meanwhile()
            return names <= {*self.ended, *self.refused}

        return self.simulation.run_until(over, timeout_s=timeout_s)

    def hear(self) -> None:
        """Take in what the robots have said since."""
        for message in self.simulation.link.receive():
            body = message.body
            if isinstance(body, Refusal):
                self.refused[body.script_id] = body
            if isinstance(body, PacketReport | ScriptReport):
                self._say(message.sender, Performative.CONFIRM, Receipt(), in_reply_to=message.id)
                if message.id not in self._seen:
                    self._seen.add(message.id)
                    self._note(body)

    def _note(self, report: PacketReport | ScriptReport) -> None:
        if isinstance(report, ScriptReport):
            self.ended[report.script_id] = report
            return
        self.reports.append(report)
        if report.state is PacketState.FINISHED:
            self._over.add((report.script_id, report.packet_id))
            self._clear(report.packet_id)

    def _clear(self, action: str) -> None:
        """Tell the robots that wait for it that an action has ended, once all who do it have said so."""
        doers = [each for each in self.scripts if any(step.id == action for step in each.packets)]
        if all((each.id, action) in self._over for each in doers):
            for each in self.scripts:
                if any(action in step.after for step in each.packets):
                    clearance = Clearance(script_id=each.id, ended=(action,))
                    self._say(each.robot, Performative.REQUEST, clearance)

    def _say(self, robot: str, performative: Performative, body: Any, in_reply_to: str | None = None) -> None:
        now_s = self.simulation.clock.now_s()
        self.simulation.link.send(
            Message(
                performative=performative,
                sender="service",
                receiver=robot,
                sent_at_s=now_s,
                in_reply_to=in_reply_to,
                body=body,
            )
        )
