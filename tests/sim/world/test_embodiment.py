"""A robot's mind rests at a safe point, goes on in another body, and does nothing twice, whenever the power fails."""

from math import hypot

import pytest

from benchmarks.embodiments import run
from robots.wire import (
    Control,
    ControlVerb,
    Message,
    MindOrder,
    MindOrderReport,
    MindVerb,
    PacketReport,
    PacketState,
    Performative,
    Receipt,
    ScriptReport,
    ScriptRequest,
    ScriptState,
)
from robots.world import Edition, load_world
from sim.snapshot import WorldSnapshot
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.sim.rig import run_s
from tests.sim.world.test_changed_world import other_body, to_the_door

FILE = load_world("sample_store")
ROBOT = "yard_1"


class Trial:
    """yard_1 is on its way to a door; the test is the service, which keeps what it has told until it is answered."""

    def __init__(self) -> None:
        self.simulation = Simulation(FILE, make_agent=behavioural_agent, seed=3, jitter_m=0.0)
        self.answers: dict[str, Message] = {}
        self.reports: dict[str, PacketReport | ScriptReport] = {}
        """By the id of the message, which a robot repeats."""
        self._ids = 0
        self.send(ScriptRequest(script=to_the_door(ROBOT)))
        self.run(1.0)

    def send(self, body: ScriptRequest | MindOrder | Control, *, message_id: str = "") -> str:
        self._ids += 1
        message = Message(
            id=message_id or f"asked-{self._ids}",
            performative=Performative.REQUEST,
            sender="service",
            receiver=ROBOT,
            sent_at_s=self.simulation.clock.now_s(),
            body=body,
        )
        self.simulation.link.send(message)
        return message.id

    def order(
        self, verb: MindVerb, fence: int, *, within_s: float = 3.0, lease_s: float | None = None
    ) -> MindOrderReport | None:
        """What the robot answers within the time; None if nothing."""
        now_s = self.simulation.clock.now_s()
        asked = self.send(
            MindOrder(
                verb=verb,
                fence=fence,
                within_s=within_s,
                lease_until_s=None if lease_s is None else now_s + lease_s,
            )
        )
        self.simulation.run_until(lambda: self._receive() or asked in self.answers, timeout_s=within_s + 1.0)
        body = self.answers[asked].body if asked in self.answers else None
        assert body is None or isinstance(body, MindOrderReport)
        return body

    def run(self, seconds: float) -> float:
        """The way that the robot makes meanwhile, in metres."""
        before = self.simulation.truth().robots[ROBOT]
        run_s(self.simulation, seconds)
        self._receive()
        now = self.simulation.truth().robots[ROBOT]
        return hypot(now.x_m - before.x_m, now.y_m - before.y_m)

    def kill(self, edition: Edition | None = None) -> None:
        """The power fails, and the world goes on from its snapshot; messages under way are lost."""
        snapshot = WorldSnapshot.model_validate_json(self.simulation.snapshot().model_dump_json())
        self.simulation.close()
        self.simulation = Simulation(FILE, make_agent=behavioural_agent, snapshot=snapshot, edition=edition)

    def finish(self) -> None:
        """The script comes to its end, with each report once."""
        assert self.simulation.run_until(lambda: self._receive() or self._has_ended, timeout_s=60.0)
        states = [one.state for one in self.reports.values() if isinstance(one, PacketReport)]
        assert states.count(PacketState.FINISHED) == 1
        assert states.count(PacketState.FAILED) == 0
        ends = [one.state for one in self.reports.values() if isinstance(one, ScriptReport)]
        assert ends == [ScriptState.FINISHED]

    @property
    def _has_ended(self) -> bool:
        return any(isinstance(one, ScriptReport) for one in self.reports.values())

    def _receive(self) -> bool:
        for message in self.simulation.link.receive():
            if message.sender != ROBOT:
                continue
            if message.in_reply_to is not None:
                self.answers[message.in_reply_to] = message
            if isinstance(message.body, PacketReport | ScriptReport):
                self.reports[message.id] = message.body
                receipt = Message(
                    performative=Performative.CONFIRM,
                    sender="service",
                    receiver=ROBOT,
                    sent_at_s=0.0,
                    in_reply_to=message.id,
                    body=Receipt(),
                )
                self.simulation.link.send(receipt)
        return False


def agreed(report: MindOrderReport | None) -> bool:
    return report is not None and report.reason == ""


def test_a_mind_rests_until_it_is_told_to_go_on_and_orders_wait_meanwhile() -> None:
    trial = Trial()
    assert trial.run(0.5) > 0.1, "it is on its way"
    assert agreed(trial.order(MindVerb.REST, 1))
    pause = trial.send(Control(script_id=f"{ROBOT}-script", verb=ControlVerb.PAUSE, number=1))
    assert trial.run(2.0) < 0.001
    assert pause not in trial.answers
    assert agreed(trial.order(MindVerb.GO_ON, 1))
    trial.run(0.5)
    assert trial.answers[pause].performative is Performative.AGREE, "it was only late"
    trial.send(Control(script_id=f"{ROBOT}-script", verb=ControlVerb.RESUME, number=2))
    trial.finish()


def test_a_lower_fencing_number_is_refused_and_a_repeated_order_changes_nothing() -> None:
    trial = Trial()
    assert agreed(trial.order(MindVerb.REST, 4))
    assert agreed(trial.order(MindVerb.REST, 4)), "it rests already"
    assert agreed(trial.order(MindVerb.GO_ON, 4))
    late = trial.order(MindVerb.REST, 3)
    assert late is not None
    assert late.reason == "fencing number 3 is over, 4 is in force"
    again = trial.order(MindVerb.REST, 4)
    assert again is not None
    assert again.reason, "the order to rest was overtaken"
    assert agreed(trial.order(MindVerb.GO_ON, 4))
    trial.finish()


@pytest.mark.parametrize("killed", ["asked", "at rest", "exchanged unsaid", "exchanged", "going on"])
def test_the_script_comes_to_its_end_once_whenever_the_power_fails(killed: str) -> None:
    trial = Trial()
    edition = Edition(1, other_body(FILE, ROBOT, "avatar"))
    if killed == "asked":
        trial.send(MindOrder(verb=MindVerb.REST, fence=1))
        trial.simulation.step_control_cycle()
        trial.kill()
    assert agreed(trial.order(MindVerb.REST, 1))
    if killed == "at rest":
        trial.kill()
        assert trial.run(1.0) < 0.001
    if killed == "exchanged unsaid":
        trial.kill(edition)
    else:
        trial.simulation.take_up(edition)
    if killed == "exchanged":
        trial.kill()
    assert trial.run(1.0) < 0.001, "it is in no body that acts"
    if killed == "going on":
        trial.send(MindOrder(verb=MindVerb.GO_ON, fence=1))
        trial.simulation.step_control_cycle()
        trial.kill()
    assert agreed(trial.order(MindVerb.GO_ON, 1))
    assert trial.simulation.world.robot(ROBOT).body.kind == "avatar"
    trial.finish()


def test_a_mind_whose_lease_ends_rests_though_nobody_can_tell_it() -> None:
    trial = Trial()
    assert agreed(trial.order(MindVerb.GO_ON, 1, lease_s=1.0))
    trial.run(1.7)
    assert trial.run(1.0) < 0.001
    trial.kill()
    assert trial.run(1.0) < 0.001
    assert agreed(trial.order(MindVerb.GO_ON, 1, lease_s=100.0)), "the lease is renewed"
    trial.finish()


def test_the_main_job_comes_true_while_minds_move_and_the_power_fails() -> None:
    ended = run(0.5, 1)
    assert ended.succeeded, ended
    assert ended.moves["embodied"] > 2
    assert ended.failures["world"] > 0
