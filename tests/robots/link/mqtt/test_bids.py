"""Robots with links of their own call for bids and bid over a broker."""

from robots.link.mqtt import Broker, FleetLink, RobotLink
from robots.physical.body import Pose
from robots.social import Heard, SocialLevel
from robots.social.legs import call_of, offer_of
from robots.social.protocols import CONTRACT_NET
from robots.wire import Performative
from tests.mosquitto import Mosquitto, needs_mosquitto
from tests.robots.link.mqtt.ends import WORLD
from tests.robots.stories import NORTH, packet, room
from tests.waiting import until

DRIVE = packet("NAVIGATE", ref1="door", ref2="yard")


@needs_mosquitto
def test_a_robot_on_a_broker_bids_for_the_leg_that_another_calls_for(broker: Mosquitto) -> None:
    at = Broker.at(broker.url)
    world = room()
    heard: list[Heard] = []
    society = {name: SocialLevel(name, world.clock) for name in ("ginger", "basil")}
    society["basil"].listen(lambda one: heard.append(one) is None)
    links = {name: RobotLink(WORLD, [name], at) for name in society}
    fleet = FleetLink(WORLD, ["fred"], at, run="run-1")
    try:
        for link in links.values():
            link.start()
        fleet.start()
        until(lambda: all(one.connected and one.run == "run-1" for one in links.values()), "they are online")
        for x_m, (name, link) in enumerate(links.items(), start=1):
            world.add(name, Pose(x_m=x_m, y_m=1.5, heading_rad=NORTH), link=link, society=society[name])
        world.tick()
        society["basil"].say(
            Performative.CFP,
            "ginger",
            call_of("leg_1", [DRIVE]),
            protocol=CONTRACT_NET,
            within_s=600.0,
            is_of_rules=True,
        )
        until(lambda: world.tick() or bool(heard), "the bid comes")
    finally:
        fleet.close()
        for link in links.values():
            link.close()
    assert (heard[0].sender, heard[0].performative) == ("ginger", Performative.PROPOSE)
    assert offer_of(heard[0].content).work_s == 10.0
