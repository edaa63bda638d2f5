"""Makes the on-robot software for simulated bodies, with no more knowledge than a real robot has."""

from collections.abc import Iterator, Sequence
from functools import cache, partial
from math import radians
from pathlib import Path

from robots.deliberative.mind import Mind
from robots.deliberative.rule_set import read_rule_set
from robots.executive.agent import BehaviouralAgent
from robots.physical.body import ALL_SENSORS
from robots.physical.profile import Architecture, Area, BeaconSpec, RobotProfile
from robots.repertoire import Repertoire, load_repertoire, read_repertoire
from robots.social import RuleSpeech, SocialLevel
from robots.world import DELEGATION, Zone, ZoneRule
from sim.world.agent import AgentFactory, AgentSetup


def agents_with(packet_files: Sequence[Path] | None) -> AgentFactory:
    """Makes agents whose repertoires have the packets of these files; picklable. None: those that ship."""
    if packet_files is None:
        return behavioural_agent
    return partial(agent_with_packets, packet_files=tuple(packet_files))


def agent_with_packets(setup: AgentSetup, packet_files: tuple[Path, ...]) -> BehaviouralAgent:
    return behavioural_agent(setup, _repertoire(packet_files))


@cache
def _repertoire(packet_files: tuple[Path, ...]) -> Repertoire:
    return read_repertoire(packet_files)


def behavioural_agent(setup: AgentSetup, repertoire: Repertoire | None = None) -> BehaviouralAgent:
    """An agent that knows the beacons of its reach, its fellows' names, and the pose it was told.

    :param repertoire: None is the one that ships.
    """
    spec = setup.spec
    beacons = {
        place.name: BeaconSpec(
            x_m=place.at[0], y_m=place.at[1], approach_rad=tuple(radians(axis) for axis in place.approach_deg)
        )
        for place in setup.reach
    }
    profile = RobotProfile(
        name=spec.name,
        start=setup.told,
        beacons=beacons,
        speed_m_s=spec.speed_m_s,
        turn_rad_s=spec.turn_rad_s,
        repertoire=tuple(spec.repertoire),
        others=setup.others,
        home=spec.home,
        battery_wh=spec.battery_wh,
        architecture=Architecture(spec.architecture),
        sensors=ALL_SENSORS | {sensor.kind for sensor in spec.sensors if sensor.takes_images},
        whisker_least_m=spec.whisker_least_m,
        samples=setup.samples,
        keep_out=tuple(areas_of(setup.zones, ZoneRule.KEEP_OUT)),
        one_robot=tuple(areas_of(setup.zones, ZoneRule.ONE_ROBOT)),
        slow=tuple(((*zone.x, *zone.y), zone.max_speed_m_s) for zone in setup.zones if zone.max_speed_m_s),
        lengths_m=setup.lengths_m,
        round_trip_s=setup.round_trip_s,
    )
    society = (
        SocialLevel(
            spec.name,
            setup.clock,
            abilities=spec.repertoire,
            round_trip_s=setup.peer_round_trip_s,
            takes_legs=spec.speaks is None or DELEGATION in spec.speaks,
        )
        if setup.speaks
        else None
    )
    speech = None if society is None else RuleSpeech(society)
    packets = (repertoire or load_repertoire()).tuned(spec.tuning)
    mind = Mind(
        profile,
        packets,
        read_rule_set(spec.rule_files),
        speak=None if speech is None else speech.speak,
        role="" if spec.role is None else spec.role.name,
    )
    if speech is not None:
        speech.listen(mind)
    return BehaviouralAgent(
        society=society,
        profile=profile,
        body=setup.body,
        link=setup.link,
        clock=setup.clock,
        repertoire=packets,
        memory=setup.memory,
        deliberation=mind,
        factsheet=setup.factsheet,
        program=setup.program,
    )


def areas_of(zones: Sequence[Zone], rule: ZoneRule) -> Iterator[Area]:
    """The rectangles of the zones with this rule."""
    return ((*zone.x, *zone.y) for zone in zones if zone.rule is rule)
