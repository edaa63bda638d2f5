"""The software of a door or lift, over a fake mechanism."""

from dataclasses import dataclass

from robots.adapters.peripheral import CLOSED, OPEN, PeripheralAgent, PeripheralProfile
from robots.clock import ManualClock
from robots.contract.memory_file import TextMemory
from robots.link import InMemoryLink
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    Clearance,
    Message,
    PacketReport,
    PacketState,
    Performative,
    Refusal,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    UpkeepReport,
)

TICK_S = 0.1


@dataclass
class FakeMechanism:
    """Takes `takes_s` from state to state; a `fault` keeps it where it is."""

    state: str = CLOSED
    fault: str = ""
    takes_s: float = 2.0
    wanted: str = ""
    left_s: float = 0.0

    def go_to(self, state: str) -> None:
        if state not in (self.state, self.wanted):
            self.wanted = state
            self.left_s = self.takes_s

    def stop(self) -> None:
        """It goes on."""

    def move(self, step_s: float) -> None:
        if self.wanted and not self.fault:
            self.state = ""
            self.left_s -= step_s
            if self.left_s <= 0:
                self.state = self.wanted
                self.wanted = ""


def packet(number: int, tag: str, *after: str, **arguments: str) -> BehaviourPacket:
    return BehaviourPacket(
        id=f"a{number}",
        tag=tag,
        arguments={"door": "gate", **arguments},
        after=after,
        expected_start_s=0,
        expected_duration_s=2,
        timeout_s=30,
        wait_timeout_s=60,
    )


class Rig:
    """A door with its clock and the service's end of its link."""

    def __init__(self, profile: PeripheralProfile | None = None, state: str = CLOSED) -> None:
        self.clock = ManualClock()
        self.mechanism = FakeMechanism(state)
        self.profile = profile or PeripheralProfile(name="gate", x_m=1, y_m=2, closes_after_s=5.0)
        self.link, self.far = InMemoryLink.pair()
        self.store = TextMemory()
        self.heard: list[Message] = []
        self.start()

    def start(self) -> None:
        """Start its software, again if it ran."""
        self.agent = PeripheralAgent(
            self.profile,
            mechanism=self.mechanism,
            link=self.far,
            clock=self.clock,
            store=self.store,
            run="run",
        )

    def order(self, *packets: BehaviourPacket) -> None:
        script = BehaviourScript(id="s1", mission_id="m1", robot=self.profile.name, packets=packets)
        self.send(ScriptRequest(script=script))

    def send(self, body: ScriptRequest | Clearance) -> None:
        self.link.send(
            Message(
                performative=Performative.REQUEST,
                sender="service",
                receiver=self.profile.name,
                sent_at_s=self.clock.now_s(),
                body=body,
            )
        )

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.clock.advance(TICK_S)
            self.agent.tick()
            self.mechanism.move(TICK_S)
            self.heard.extend(self.link.receive())

    def states(self, packet_id: str) -> list[PacketState]:
        """The packet's states in order; reports are repeated, for nobody confirms them."""
        bodies = [one.body for one in self.heard]
        told = [one for one in bodies if isinstance(one, PacketReport) and one.packet_id == packet_id]
        return [one.state for one in sorted(told, key=lambda one: one.at_s)]

    @property
    def ended(self) -> list[ScriptReport]:
        return [one.body for one in self.heard if isinstance(one.body, ScriptReport)]

    @property
    def upkeep(self) -> list[UpkeepReport]:
        return [one.body for one in self.heard if isinstance(one.body, UpkeepReport)]


def test_a_door_stays_open_until_it_is_cleared_to_close() -> None:
    door = Rig()
    door.order(packet(1, "OPEN"), packet(2, "CLOSE", "a7"))
    door.run(20.0)
    assert door.mechanism.state == OPEN
    assert door.states("a1")[-1] is PacketState.FINISHED
    assert set(door.states("a2")) == {PacketState.INITIALIZING}
    door.send(Clearance(script_id="s1", ended=("a7",)))
    door.run(5.0)
    assert door.mechanism.state == CLOSED
    assert door.ended[-1].state is ScriptState.FINISHED


def test_a_door_that_nobody_needs_any_more_closes_and_tells_so() -> None:
    door = Rig()
    door.order(packet(1, "OPEN"))
    door.run(4.0)
    assert (door.mechanism.state, door.upkeep) == (OPEN, [])
    door.run(8.0)
    assert door.mechanism.state == CLOSED
    assert [str(one) for one in door.upkeep[0].perceived] == ["closed(gate)"]


def test_a_door_that_is_normally_open_stays_so() -> None:
    door = Rig(PeripheralProfile(name="gate", x_m=0, y_m=0), OPEN)
    door.run(60.0)
    assert (door.mechanism.state, door.upkeep) == (OPEN, [])


def test_a_door_closed_by_hand_tells_so() -> None:
    door = Rig(PeripheralProfile(name="gate", x_m=0, y_m=0), OPEN)
    door.run(1.0)
    door.mechanism.state = CLOSED
    door.run(1.0)
    assert [str(one) for one in door.upkeep[0].perceived] == ["closed(gate)"]


def test_a_door_that_does_not_open_fails_with_the_reason_and_how_it_stands() -> None:
    door = Rig()
    door.mechanism.fault = "its motor does not move"
    door.order(packet(1, "OPEN"))
    door.run(1.0)
    assert door.ended[-1].state is ScriptState.FAILED
    assert door.ended[-1].detail == "OPEN its motor does not move"
    assert [str(one) for one in door.ended[-1].perceived] == ["closed(gate)"]


def test_a_door_that_is_stuck_half_way_says_so() -> None:
    door = Rig(state="")
    door.mechanism.fault = "it is stuck half-way"
    door.order(packet(1, "OPEN"))
    door.run(1.0)
    assert [str(one) for one in door.ended[-1].perceived] == ["half_way(gate)"]


def test_a_door_that_is_open_already_is_so_at_once() -> None:
    door = Rig(state=OPEN)
    door.order(packet(1, "OPEN"), packet(2, "CLOSE", "a7"))
    door.run(1.0)
    assert door.states("a1")[-1] is PacketState.FINISHED


def test_a_door_goes_on_with_its_script_after_a_restart() -> None:
    door = Rig()
    door.order(packet(1, "OPEN"), packet(2, "CLOSE", "a7"))
    door.run(1.0)
    door.start()
    door.run(10.0)
    assert door.mechanism.state == OPEN
    door.send(Clearance(script_id="s1", ended=("a7",)))
    door.run(5.0)
    assert door.ended[-1].state is ScriptState.FINISHED


def test_a_lift_goes_to_the_level_and_refuses_one_that_it_has_not() -> None:
    profile = PeripheralProfile(name="lift", x_m=0, y_m=0, levels=("ground", "upper"))
    lift = Rig(profile, "ground")
    lift.order(packet(1, "MOVE_TO_LEVEL", level1="ground", level2="upper"))
    lift.run(4.0)
    assert lift.mechanism.state == "upper"
    assert [str(one) for one in lift.ended[-1].perceived] == ["lift_at(lift, upper)"]
    other = Rig(profile, "ground")
    other.order(packet(1, "MOVE_TO_LEVEL", level2="attic"))
    other.run(1.0)
    assert any(isinstance(one.body, Refusal) and "attic" in one.body.reason for one in other.heard)


def test_a_door_that_is_shut_by_hand_while_others_go_through_opens_again() -> None:
    door = Rig()
    door.order(packet(1, "OPEN"), packet(2, "CLOSE", "a7"))
    door.run(5.0)
    door.mechanism.state = CLOSED
    door.mechanism.wanted = ""
    door.run(4.0)
    assert door.mechanism.state == OPEN
    assert door.ended == []


def test_a_door_that_does_not_stay_open_fails_before_it_is_cleared_to_close() -> None:
    door = Rig()
    door.order(packet(1, "OPEN"), packet(2, "CLOSE", "a7"))
    door.run(5.0)
    door.start()  # it remembers what it is to hold
    door.mechanism.state = CLOSED
    door.mechanism.fault = "it does not stay open"
    door.run(1.0)
    assert door.ended[-1].state is ScriptState.FAILED
    assert door.ended[-1].detail == "CLOSE it does not stay open"
    assert [str(one) for one in door.ended[-1].perceived] == ["closed(gate)"]


def test_a_door_that_is_not_back_in_time_fails() -> None:
    door = Rig()
    door.order(packet(1, "OPEN"), packet(2, "CLOSE", "a7"))
    door.run(5.0)
    door.mechanism.state = CLOSED
    door.mechanism.takes_s = 1000.0
    door.run(29.0)
    assert door.ended == []
    door.run(2.0)
    assert door.ended[-1].detail == "CLOSE it is no longer open, for 30 s"
