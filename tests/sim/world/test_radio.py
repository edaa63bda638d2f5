"""The laws of the radio, and the hub that sends through it."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from robots.link import InMemoryLink
from robots.wire import Message, Performative, Receipt
from robots.world import Contact, LinkSpec, Outage, load_world
from sim.world.hub import Hub
from sim.world.radio import MAX_UNDER_WAY, Direction, Radio, radios_of
from tests.sim.world.test_hub import report, telemetry

LINKS = st.builds(
    LinkSpec,
    loss=st.floats(0, 0.95),
    delay_s=st.floats(0, 5),
    jitter_s=st.floats(0, 5),
    duplication=st.floats(0, 1),
    light_time_s=st.floats(0, 5),
)
INSTANTS = st.lists(st.floats(0, 50), max_size=30).map(sorted)
Came = list[tuple[float, str]]


def said(link: LinkSpec, instants: list[float], *, seed: int = 0, robot: str = "fred") -> Came:
    """What arrives of a report sent at each instant, with the time of its arrival to a twentieth of a second."""
    radio, came = Radio(link, robot=robot, seed=seed), []
    times = sorted({*instants, *(step / 20 for step in range(20 * 70))})
    for now_s in times:
        for index, at_s in enumerate(instants):
            if at_s == now_s:
                radio.send(Direction.UP, report(f"r{index}", at_s), now_s)
        came += [(now_s, message.sender) for message in radio.arrived(Direction.UP, now_s)]
    return came


@given(LINKS, INSTANTS)
def test_nothing_arrives_that_was_not_sent_nor_more_than_twice(link: LinkSpec, instants: list[float]) -> None:
    copies = Counter(sender for _, sender in said(link, instants))
    assert set(copies) <= {f"r{index}" for index in range(len(instants))}
    assert max(copies.values(), default=0) <= 2


@given(LINKS, INSTANTS)
def test_a_message_takes_what_the_link_says(link: LinkSpec, instants: list[float]) -> None:
    least_s = link.light_time_s + link.delay_s
    for came_s, sender in said(link, instants):
        took_s = came_s - instants[int(sender[1:])]
        assert least_s - 1e-9 <= took_s <= least_s + link.jitter_s + 0.05 + 1e-9


@given(LINKS, INSTANTS, st.integers(0, 5))
def test_the_same_seed_and_messages_have_the_same_fate(
    link: LinkSpec, instants: list[float], seed: int
) -> None:
    assert said(link, instants, seed=seed) == said(link, instants, seed=seed)


def test_robots_and_seeds_have_fates_of_their_own() -> None:
    link, instants = LinkSpec(loss=0.5), [float(second) for second in range(40)]
    fates = [said(link, instants, seed=seed, robot=robot) for seed in (0, 1) for robot in ("fred", "ginger")]
    assert len({tuple(fate) for fate in fates}) == 4


def test_as_much_is_lost_and_repeated_as_the_link_says() -> None:
    radio, arrived = Radio(LinkSpec(loss=0.3, duplication=0.2)), 0
    for step in range(10_000):
        radio.send(Direction.DOWN, report("fred", step), step / 20)
        arrived += len(radio.arrived(Direction.DOWN, step / 20))
    assert abs(arrived / 10_000 - 0.7 * 1.2) < 0.03  # 4.5 standard deviations


@given(st.lists(st.floats(0, 50), max_size=30).map(sorted), st.booleans())
def test_a_sure_link_keeps_the_order_whatever_it_delays(instants: list[float], far: bool) -> None:
    senders = [sender for _, sender in said(LinkSpec(light_time_s=10.0 if far else 0.0), instants)]
    assert senders == [f"r{index}" for index in range(len(instants))]


def test_what_leaves_or_would_arrive_without_contact_is_lost() -> None:
    link = LinkSpec(light_time_s=2, outages=(Outage(start_s=10, end_s=20),))
    assert said(link, [7.0, 8.5, 12.0, 19.5, 20.5]) == [(9.0, "r0"), (22.5, "r4")]
    windows = LinkSpec(contacts=(Contact(for_s=5, every_s=30),))
    assert [sender for _, sender in said(windows, [1.0, 6.0, 29.0, 31.0])] == ["r0", "r3"]


def test_telemetry_changes_no_letters_fate() -> None:
    link, fates = LinkSpec(loss=0.5, jitter_s=1.0), []
    for chatter in (0, 3):
        radio = Radio(link, seed=4)
        for second in range(50):
            for _ in range(chatter):
                radio.send(Direction.UP, telemetry("fred", second), second)
            radio.send(Direction.UP, report("fred", second), second)
        fates.append([m.sent_at_s for m in radio.arrived(Direction.UP, 100) if m.body.kind != "telemetry"])
    assert fates[0] == fates[1]


def test_the_air_holds_only_so_much_telemetry() -> None:
    radio = Radio(LinkSpec(light_time_s=1000))
    for step in range(MAX_UNDER_WAY + 50):
        radio.send(Direction.UP, telemetry("fred", step), step / 20)
    radio.send(Direction.UP, report("fred", 1), 60.0)
    arrived = radio.arrived(Direction.UP, 5000)
    assert (len(arrived), arrived[-1].body.kind) == (MAX_UNDER_WAY + 1, "packet_report")


def test_the_hub_sends_through_the_radio_both_ways() -> None:
    service, far = InMemoryLink.pair()
    hub = Hub(far, ["fred"], radios={"fred": Radio(LinkSpec(delay_s=3))})
    letter = Message(
        performative=Performative.CONFIRM, sender="service", receiver="fred", sent_at_s=0, body=Receipt()
    )
    service.send(letter)
    hub.link_of("fred").send(report("fred", 0))
    for now_s, there in ((0.0, 0), (2.9, 0), (3.0, 1), (3.1, 0)):
        hub.receive(now_s)
        hub.flush(now_s)
        assert (len(hub.link_of("fred").receive()), len(service.receive())) == (there, there), now_s


def test_every_robot_has_the_radio_that_its_world_file_says() -> None:
    world = load_world("sample_store_radio")
    radios = radios_of(world, seed=3)
    assert {name: radio.link for name, radio in radios.items()} == {
        robot.name: world.link_of(robot) for robot in world.robots
    }
