"""A robot tells what it believes and is committed to when it is asked."""

from robots.deliberative.mind import Mind
from robots.deliberative.reader import digest_of
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import (
    MAX_TOLD,
    MAX_TOLD_CHARACTERS,
    MindQuery,
    MindReport,
    Performative,
    RuleSet,
    ToldAgent,
)
from tests.robots.fake_world import FakeWorld
from tests.robots.stories import EAST, Service, room, run_for

GUARD = """AGENT guard;
ACTUATOR say;
BELIEF(startup) => COMMIT(SEQ(adoptBelief(seen("bay 3", -1.5)), adoptBelief(not(lit(yard)))));
BELIEF(seen(?place, ?_)) => COMMIT(Self, Now + 100, adoptBelief(stale(?place)));
BELIEF(startup) => COMMIT(adoptBelief(role(porter)));
"""
PORTER = "ROLE porter;\nBELIEF(startup) => COMMIT(adoptBelief(unused));\n"


def at_rest() -> tuple[FakeWorld, Service]:
    world = room(noise=0.0)
    link = world.add("fred", Pose(x_m=1.0, y_m=1.5, heading_rad=EAST), mind=mind)
    return world, Service(world, link, "fred")


def mind(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), ())


def asked(world: FakeWorld, service: Service) -> MindReport:
    query = service.send(MindQuery(), Performative.QUERY)
    run_for(world, [service], 0.2)
    (answer,) = (one for one in service.heard if one.in_reply_to == query.id)
    assert answer.performative is Performative.INFORM
    assert isinstance(answer.body, MindReport)
    return answer.body


def test_a_robot_tells_its_beliefs_its_commitments_and_the_rules_that_made_them() -> None:
    world, service = at_rest()
    files = {"guard": GUARD, "porter": PORTER}
    service.send(RuleSet(version=4, files=files))
    run_for(world, [service], 1.0)
    told = asked(world, service)
    assert (told.version, told.digests) == (4, {name: digest_of(text) for name, text in files.items()})
    (guard,) = told.agents
    assert (guard.name, guard.roles) == ("guard", ("porter",))
    beliefs = {one.term: one for one in guard.beliefs}
    seen = beliefs['seen("bay 3", -1.5)']
    assert (seen.value, seen.origin, seen.source) == (True, "adopted", "guard:3")
    assert 0.0 < seen.since_s < told.at_s
    assert not beliefs["lit(yard)"].value
    assert guard.belief_count == len(guard.beliefs)
    waiting, *ended = guard.commitments
    assert (waiting.rule, waiting.state, waiting.bindings) == ("guard:4", "adopted", {"place": '"bay 3"'})
    assert waiting.due_s == waiting.made_s + 100
    assert {one.rule: one.state for one in ended} == {"guard:3": "fulfilled", "guard:5": "fulfilled"}
    assert all(one.ended_s is not None for one in ended)


def test_a_dropped_commitment_is_told_with_its_reason() -> None:
    world, service = at_rest()
    text = GUARD.replace("COMMIT(Self, Now + 100,", "COMMIT(Self, Now + 100, BELIEF(seen(?place, ?_)),")
    text += "BELIEF(seen(?p, ?y)) & BELIEF(not(lit(yard))) => COMMIT(retractBelief(seen(?p, ?y)));\n"
    service.send(RuleSet(version=1, files={"guard": text, "porter": PORTER}))
    run_for(world, [service], 1.0)
    (guard,) = asked(world, service).agents
    (dropped,) = (one for one in guard.commitments if one.rule == "guard:4")
    assert (dropped.state, dropped.reason) == ("dropped", "condition")
    assert dropped.words == "its condition no longer holds"


def test_a_robot_without_rules_tells_of_none() -> None:
    world, service = at_rest()
    told = asked(world, service)
    assert (told.version, told.agents, told.conversations) == (0, (), ())


def test_what_is_told_is_of_bounded_size() -> None:
    profile = RobotProfile(name="fred", start=Pose(x_m=0, y_m=0, heading_rad=EAST), beacons={})
    many = Mind(profile, load_repertoire(), ())
    long = "x" * 1000
    files = {
        f"agent_{number}": f"AGENT agent_{number};\n"
        + "".join(f'BELIEF(fact({one}, "{long}"));\n' for one in range(40))
        for number in range(16)
    }
    assert many.follow(files, 1, 0.0) is None
    told: tuple[ToldAgent, ...] = many.told()
    assert sum(len(one.beliefs) for one in told) == MAX_TOLD
    assert all(one.belief_count > len(one.beliefs) for one in told)
    assert max(len(belief.term) for one in told for belief in one.beliefs) == MAX_TOLD_CHARACTERS
    assert told[0].beliefs[-1].term.startswith("fact(39, "), "the newest are told"
