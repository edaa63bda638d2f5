"""Robots that meet where there is room for one: rules decide who backs out, by speech or by rank."""

from collections.abc import Callable, Mapping

import pytest

from robots.deliberative.actuators import Utterance
from robots.deliberative.mind import Mind
from robots.deliberative.reader import read_rules, rules_of
from robots.physical.body import Pose
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import PacketReport, ScriptState
from robots.world.rule_files import shipped_rules
from tests.robots.fake_world import STEP_S, FakeWorld, Segment
from tests.robots.stories import EAST, NORTH, SOUTH, WEST, Service, packet, run_for, script

NAMES = ("fred", "ginger")
WAYS = {"fred": ("west_north", "east_south"), "ginger": ("east_north", "west_south")}
HIGH = 1.5 + 1.3 / 2
LOW = 1.5 - 1.3 / 2


def passage(seed: int) -> FakeWorld:
    """Two rooms of 3 m by 3 m, and an aisle between them, 3.5 m long and 1.3 m wide."""
    outline = [0j, 3, 3 + LOW * 1j, 6.5 + LOW * 1j, 6.5, 9.5, 9.5 + 3j, 6.5 + 3j]
    outline += [6.5 + HIGH * 1j, 3 + HIGH * 1j, 3 + 3j, 3j]
    walls: list[Segment] = list(zip(outline, outline[1:] + outline[:1], strict=True))
    beacons = {
        "west_north": BeaconSpec(x_m=1.5, y_m=2.9, approach_rad=(SOUTH,)),
        "west_south": BeaconSpec(x_m=1.5, y_m=0.1, approach_rad=(NORTH,)),
        "east_north": BeaconSpec(x_m=8.0, y_m=2.9, approach_rad=(SOUTH,)),
        "east_south": BeaconSpec(x_m=8.0, y_m=0.1, approach_rad=(NORTH,)),
    }
    return FakeWorld(walls=walls, beacons=beacons, samples={}, seed=seed, noise=0.5)


class Meeting:
    """Two robots that are each to drive to where the other comes from.

    :param rules: None: without any. :param deaf: robots that do not hear what is said.
    """

    def __init__(self, rules: Mapping[str, str | None], *, seed: int = 0, deaf: frozenset[str] = frozenset()):
        self.world = passage(seed)
        self.minds: dict[str, Mind] = {}
        self.said: list[tuple[str, str, object]] = []
        self.services: dict[str, Service] = {}
        starts = {
            "fred": Pose(x_m=2.6, y_m=1.4, heading_rad=EAST),
            "ginger": Pose(x_m=6.9, y_m=1.5, heading_rad=WEST),
        }
        for name, other in zip(NAMES, reversed(NAMES), strict=True):
            text = rules[name]
            made = self._mind(text, other, deaf) if text is not None else None
            link = self.world.add(name, starts[name], (other,), mind=made)
            self.services[name] = Service(self.world, link, name)
            start, goal = WAYS[name]
            go = packet("NAVIGATE", ref1=start, ref2=goal, timeout_s=90)
            self.services[name].order(script(name, go))

    def _mind(self, text: str, other: str, deaf: frozenset[str]) -> Callable[[RobotProfile], Mind]:
        def made(profile: RobotProfile) -> Mind:
            def speak(utterance: Utterance) -> str | None:
                self.said.append((profile.name, utterance.performative, utterance.content))
                heard = Utterance(
                    performative=utterance.performative, other=profile.name, content=utterance.content
                )
                if other in self.minds and other not in deaf:
                    self.minds[other].hear(heard, self.world.clock.now_s())
                return None

            mind = Mind(profile, load_repertoire(), [rules_of(text, "give_way.rules")], speak=speak)
            self.minds[profile.name] = mind
            return mind

        return made

    def run(self, limit_s: float = 150.0) -> dict[str, ScriptState | None]:
        while self.world.clock.now_s() < limit_s and not all(one.report for one in self.services.values()):
            run_for(self.world, list(self.services.values()), STEP_S)
        return {name: one.report.state if one.report else None for name, one in self.services.items()}

    def backed_out(self) -> list[str]:
        return [
            name
            for name, service in self.services.items()
            if any("stands for MOVE_TO of give_way" in one.detail for one in _packets(service))
        ]


def _packets(service: Service) -> list[PacketReport]:
    return [one.body for one in service.heard if isinstance(one.body, PacketReport)]


def shipped() -> str:
    return read_rules(shipped_rules()["give_way"]).text


PASSED = dict.fromkeys(NAMES, ScriptState.FINISHED)


@pytest.mark.parametrize("seed", range(2))
def test_one_of_two_that_speak_backs_out_and_both_arrive(seed: int) -> None:
    meeting = Meeting(dict.fromkeys(NAMES, shipped()), seed=seed)
    assert meeting.run() == PASSED
    (yielded,) = meeting.backed_out()
    (asker,) = {"fred", "ginger"} - {yielded}
    assert [(who, what) for who, what, _ in meeting.said][-2:] == [(yielded, "agree"), (asker, "inform")]


def test_without_speech_the_one_whose_name_comes_later_backs_out() -> None:
    meeting = Meeting(dict.fromkeys(NAMES, shipped()), deaf=frozenset(NAMES))
    assert meeting.run() == PASSED
    assert meeting.backed_out() == ["ginger"]


def test_the_rules_of_one_robot_are_enough() -> None:
    meeting = Meeting({"fred": None, "ginger": shipped()})
    assert meeting.run() == PASSED
    assert meeting.backed_out() == ["ginger"]


def test_an_empty_file_leaves_each_the_first_of_its_own_manoeuvres() -> None:
    meeting = Meeting(dict.fromkeys(NAMES, "AGENT give_way;"))
    meeting.run()
    met = [one for service in meeting.services.values() for one in _packets(service) if "met" in one.events]
    assert met
    assert all(("backs off" in one.detail) is ("(1 of 4)" in one.detail) for one in met)
    assert meeting.backed_out() == []
