"""An operator drives a robot: slowly, clear of what is in the way, one at a time, and never on an old word."""

import pytest

from robots.executive.agent import BehaviouralAgent
from robots.link import InMemoryLink
from robots.physical.body import RADIUS_M, Pose
from robots.wire import Message, PacketState, Performative, SetPoint, SetPointRefusal
from tests.robots.fake_world import STEP_S, FakeBody, FakeWorld
from tests.robots.stories import EAST, NORTH, Service, packet, room, run, run_for, script

START = Pose(x_m=1.0, y_m=1.5, heading_rad=EAST)
VALID_S = 0.5


class Operator:
    """Sends set-points over a service's end of the link, each with a greater number."""

    def __init__(self, service: Service, driver: str = "ada") -> None:
        self.service, self.driver, self.number = service, driver, 0

    def set_point(self, speed_m_s: float = 0.0, turn_rad_s: float = 0.0, *, ends: bool = False) -> Message:
        self.number += 1
        wanted = SetPoint(
            driver=self.driver,
            number=self.number,
            speed_m_s=speed_m_s,
            turn_rad_s=turn_rad_s,
            valid_s=VALID_S,
            ends=ends,
        )
        return self.service.send(wanted)

    def drive(self, time_s: float, speed_m_s: float = 0.0, turn_rad_s: float = 0.0) -> None:
        """Send the same five times a second."""
        for tick in range(round(time_s / STEP_S)):
            if tick % 4 == 0:
                self.set_point(speed_m_s, turn_rad_s)
            self.service.world.tick()
            self.service.listen()

    @property
    def refusal(self) -> str:
        """Why the robot last refused; empty if it agreed."""
        answers = [m.body for m in self.service.heard if isinstance(m.body, SetPointRefusal)]
        return next((one.reason for one in reversed(answers) if one.driver == self.driver), "")


def fred(start: Pose = START, battery: float = 1.0) -> tuple[FakeWorld, Service, FakeBody]:
    world = room()
    service = Service(world, world.add("fred", start), "fred")
    world.bodies["fred"].battery = battery
    return world, service, world.bodies["fred"]


def test_a_robot_drives_as_its_operator_wishes_and_tells_who_that_is() -> None:
    _, service, body = fred()
    ada = Operator(service)
    ada.drive(3, 0.2)
    assert body.pose.x_m == pytest.approx(1 + 0.2 * 3, abs=0.08), "sensors come on first"
    ada.drive(1, 0.0, 0.5)
    assert body.pose.heading_rad == pytest.approx(0.5, abs=0.06)
    told = service.telemetry[-1]
    assert (told.driven_by, told.packet_tag) == ("ada", "TELEOPERATE")


def test_no_faster_than_the_limit_whatever_is_commanded() -> None:
    _, service, body = fred()
    ada = Operator(service)
    ada.drive(1, 2.0, 0.0)
    x_m = body.pose.x_m
    ada.drive(2, 2.0)
    assert body.pose.x_m - x_m == pytest.approx(0.6, abs=0.03)
    ada.drive(0.4, 0.0, 3.0)
    assert body.velocity[1] == pytest.approx(1.0, abs=0.01)


def test_it_stands_when_no_set_point_comes_and_is_free_soon_after() -> None:
    world, service, body = fred()
    ada = Operator(service)
    ada.drive(2, 0.2)
    assert body.velocity[0] > 0
    ada.set_point(0.2)
    run_for(world, [service], VALID_S + 0.15)
    assert body.velocity == (0.0, 0.0)
    assert service.telemetry[-1].driven_by == "ada"
    run_for(world, [service], 6 * VALID_S)
    assert service.telemetry[-1].driven_by is None
    assert service.telemetry[-1].packet_tag is None
    ada.set_point(0.2)
    run_for(world, [service], 0.5)
    assert "fred is no longer driven: released" in ada.refusal
    assert body.velocity == (0.0, 0.0)


def test_the_beginning_and_the_end_are_reported_with_who_drove_and_where_it_then_is() -> None:
    world, service, _ = fred(Pose(x_m=1.0, y_m=2.0, heading_rad=-NORTH))
    ada = Operator(service)
    ada.drive(3, 0.3)
    ada.set_point(ends=True)
    run_for(world, [service], 0.3)
    began, ended = service.upkeep
    assert (began.tag, began.state, began.driver, began.perceived) == (
        "TELEOPERATE",
        PacketState.RUNNING,
        "ada",
        (),
    )
    assert (ended.state, ended.driver) == (PacketState.FINISHED, "ada")
    assert "near(fred, door)" in map(str, ended.perceived)
    assert service.telemetry[-1].driven_by is None


@pytest.mark.parametrize("speed_m_s", [0.3, -0.3])
def test_it_is_not_driven_into_a_wall(speed_m_s: float) -> None:
    _, service, body = fred(Pose(x_m=4.0 if speed_m_s > 0 else 2.0, y_m=1.5, heading_rad=EAST))
    ada = Operator(service)
    ada.drive(16, speed_m_s)
    gap_m = min(abs(6 - body.pose.x_m), abs(body.pose.x_m)) - RADIUS_M
    assert 0.03 < gap_m < 0.3, "near, but not at it"
    x_m = body.pose.x_m
    ada.drive(2, 0.0)
    assert body.pose.x_m == pytest.approx(x_m, abs=0.01), "a set-point to stand is one"


def test_one_operator_at_a_time() -> None:
    world, service, body = fred()
    ada, bob = Operator(service), Operator(service, "bob")
    ada.drive(1, 0.2)
    bob.set_point(-0.2)
    ada.drive(0.4, 0.2)
    assert bob.refusal == "ada drives fred"
    assert body.velocity[0] > 0
    ada.set_point(ends=True)
    run_for(world, [service], 0.2)
    bob.drive(1, -0.2)
    assert service.telemetry[-1].driven_by == "bob"
    assert body.velocity[0] < 0


def test_a_script_ends_the_drive_and_no_drive_ends_a_script() -> None:
    world, service, _ = fred()
    ada = Operator(service)
    ada.drive(1, 0.2)
    service.order(script("fred", packet("NAVIGATE", ref2="door"), name="mission-script"))
    ada.drive(0.6, 0.2)
    assert ada.refusal == "fred is no longer driven: gave way to script mission-script"
    (ended,) = [one for one in service.upkeep if one.state is PacketState.FINISHED]
    assert (ended.driver, ended.detail) == ("ada", "gave way to script mission-script")
    bob = Operator(service, "bob")
    bob.set_point(0.2)
    run_for(world, [service], 0.2)
    assert bob.refusal == "fred is busy with script mission-script"
    assert run(world, [service], lambda: service.report is not None)


def test_a_set_point_that_was_long_under_way_or_overtaken_moves_nothing() -> None:
    world, service, body = fred()
    ada = Operator(service)
    ada.set_point(0.2)
    for _ in range(20):  # its letters lie in the air while the world goes on
        world.clock.advance(0.05)
    run_for(world, [service], 1)
    assert (body.pose, ada.refusal) == (START, "")
    ada.drive(1, 0.2)
    newest = ada.number
    ada.number = 1
    ada.set_point(-0.3)
    ada.number = newest
    run_for(world, [service], 0.1)
    assert body.velocity[0] > 0


def test_set_points_do_not_make_it_forget_what_it_has_answered() -> None:
    _, service, _ = fred()
    order = script("fred", packet("NAVIGATE", ref2="moon"))
    request = service.order(order)
    ada = Operator(service)
    ada.drive(60, 0.0, 0.1)
    service.link.send(request)
    ada.drive(0.2, 0.0, 0.1)
    answers = [one for one in service.heard if one.in_reply_to == request.id]
    assert [one.performative for one in answers] == [Performative.REFUSE] * 2
    assert answers[0].id == answers[1].id


def test_what_is_too_weak_or_holds_something_with_another_is_not_driven() -> None:
    world, service, _ = fred(battery=0.1)
    ada = Operator(service)
    ada.drive(0.2, 0.2)
    assert ada.refusal == "fred rests, battery at 10%: 20% needed"
    world = room({"sample": 1 + 1.84j})
    service = Service(world, world.add("fred", Pose(x_m=1, y_m=1.5, heading_rad=NORTH), ["ginger"]), "fred")
    world.add("ginger", Pose(x_m=1.0, y_m=2.18, heading_rad=-NORTH))
    world.bodies["fred"].set_gripper(closed=True)
    ada = Operator(service)
    ada.drive(4, -0.2)
    assert world.bodies["fred"].at == 1 + 1.5j
    assert "with ginger by it" in ada.refusal


def test_a_restart_ends_the_drive() -> None:
    world = room()
    ours, theirs = InMemoryLink.pair()
    world.add("fred", START, link=theirs)
    service, before = Service(world, ours, "fred"), world.agents["fred"]
    Operator(service).drive(1, 0.2)
    world.agents["fred"] = BehaviouralAgent(
        profile=before.profile,
        body=world.bodies["fred"],
        link=theirs,
        clock=world.clock,
        memory=before.memory(),
    )
    run_for(world, [service], 0.5)
    assert world.bodies["fred"].velocity == (0.0, 0.0)
    assert service.telemetry[-1].packet_tag is None
    assert service.upkeep[-1].state is PacketState.FINISHED
