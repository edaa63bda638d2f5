"""Puts the on-robot software into simulated bodies, told no more than a real robot would be."""

from math import radians

from robots.executive.agent import BehaviouralAgent
from robots.physical.profile import Architecture, BeaconSpec, RobotProfile
from robots.repertoire import Repertoire, load_repertoire
from sim.world.simulation import Fitting


def behavioural_agent(fitting: Fitting, repertoire: Repertoire | None = None) -> BehaviouralAgent:
    """An agent with the map of its own reach, the names of its fellows, and the pose it was told.

    :param repertoire: None is the one that ships.
    """
    beacons = {
        place.name: BeaconSpec(
            x_m=place.at[0], y_m=place.at[1], approach_rad=tuple(radians(axis) for axis in place.approach_deg)
        )
        for place in fitting.reach
    }
    profile = RobotProfile(
        name=fitting.spec.name,
        start=fitting.told,
        beacons=beacons,
        speed_m_s=fitting.spec.speed_m_s,
        turn_rad_s=fitting.spec.turn_rad_s,
        repertoire=tuple(fitting.spec.repertoire),
        others=fitting.others,
        home=fitting.spec.home,
        architecture=Architecture(fitting.spec.architecture),
        whisker_least_m=fitting.spec.whisker_least_m,
        lengths_m=fitting.lengths_m,
        round_trip_s=fitting.round_trip_s,
    )
    return BehaviouralAgent(
        profile=profile,
        body=fitting.body,
        link=fitting.link,
        clock=fitting.clock,
        repertoire=(repertoire or load_repertoire()).tuned(fitting.spec.tuning),
        memory=fitting.memory,
    )
