"""Rules that the service sends: version, refusal by name, and what a power failure leaves."""

import pytest

from robots.deliberative.mind import Mind
from robots.deliberative.reader import digest_of
from robots.deliberative.terms import Term
from robots.executive.agent import BehaviouralAgent
from robots.executive.memory import RobotMemory
from robots.executive.mind_memory import MindMemory
from robots.link import InMemoryLink
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import Performative, RuleSet, RulesReport
from tests.robots.fake_world import FakeWorld
from tests.robots.stories import EAST, Service, room, run_for

WANDERER = "AGENT wanderer;\nACTUATOR activate;\nBELIEF(startup) => COMMIT(activate(WANDER()));\n"
KEEPER = (
    'AGENT keeper;\nBELIEF(startup) & !BELIEF(seen(?_)) => COMMIT(adoptBelief(seen("bay 3", -1.5)));\n'
    "BELIEF(seen(?_, ?_)) => COMMIT(adoptBelief(done));\n"
)


def mind(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), ())


def at_rest() -> tuple[FakeWorld, Service]:
    world = room(noise=0.0)
    link = world.add("fred", Pose(x_m=1.0, y_m=1.5, heading_rad=EAST), mind=mind)
    return world, Service(world, link, "fred")


def sent(world: FakeWorld, service: Service, rules: RuleSet) -> tuple[Performative, RulesReport]:
    request = service.send(rules)
    run_for(world, [service], 0.5)
    (answer,) = (one for one in service.heard if one.in_reply_to == request.id)
    assert isinstance(answer.body, RulesReport)
    return answer.performative, answer.body


def believed(world: FakeWorld) -> set[str]:
    memory = world.agents["fred"].memory().mind.rules
    assert memory is not None
    return {text for some in memory.beliefs.values() for text in some}


def test_rules_that_are_sent_are_followed_and_reported_with_their_digests() -> None:
    world, service = at_rest()
    answer = sent(world, service, RuleSet(version=1, files={"wanderer": WANDERER}))
    assert answer == (
        Performative.AGREE,
        RulesReport(version=1, digests={"wanderer": digest_of(WANDERER)}),
    )
    run_for(world, [service], 1.0)
    assert [one.tag for one in service.upkeep] == ["WANDER"]


def test_rules_that_do_not_fit_are_refused_by_name_and_the_present_ones_stay() -> None:
    world, service = at_rest()
    sent(world, service, RuleSet(version=1, files={"keeper": KEEPER}))
    bad = WANDERER.replace("WANDER()", "WANDR()")
    performative, report = sent(world, service, RuleSet(version=2, files={"wanderer": bad}))
    assert performative is Performative.REFUSE
    assert report.reason == "wanderer:3:27: unknown packet WANDR; did you mean WANDER?"
    assert report.digests == {"keeper": digest_of(KEEPER)}
    _, report = sent(world, service, RuleSet(version=3, files={"rover": WANDERER}))
    assert report.reason == "rover:1:1: the file says that it is wanderer"


def test_an_older_version_changes_nothing_and_no_files_end_all_rules() -> None:
    world, service = at_rest()
    sent(world, service, RuleSet(version=2, files={"keeper": KEEPER}))
    _, late = sent(world, service, RuleSet(version=1, files={"wanderer": WANDERER}))
    assert (late.reason, late.digests) == ("", {"keeper": digest_of(KEEPER)})
    _, none = sent(world, service, RuleSet(version=3))
    assert none == RulesReport(version=3)


def test_a_power_failure_leaves_the_rules_and_what_was_adopted() -> None:
    world, service = at_rest()
    sent(world, service, RuleSet(version=4, files={"keeper": KEEPER}))
    assert believed(world) == {'seen("bay 3", -1.5)', "done"}
    memory = RobotMemory.model_validate_json(world.agents["fred"].memory().model_dump_json())
    profile = world.agents["fred"].profile
    service.link, theirs = InMemoryLink.pair()
    restored = mind(profile)
    world.agents["fred"] = BehaviouralAgent(
        profile=profile,
        body=world.bodies["fred"],
        link=theirs,
        clock=world.clock,
        memory=memory,
        deliberation=restored,
    )
    assert Term("seen", ("bay 3", -1.5)) in restored.agents[0].beliefs
    _, late = sent(world, service, RuleSet(version=3, files={"wanderer": WANDERER}))
    assert late.digests == {"keeper": digest_of(KEEPER)}


CHANGING = (
    "AGENT changing;\nBELIEF(role(defender));\nBELIEF(at(0.12345678901234));\nBELIEF(startup) & !BELIEF(changed)"
    " => COMMIT(SEQ(adoptBelief(changed), retractBelief(at(0.12345678901234)), retractBelief(role(?_)),"
    " adoptBelief(role(attacker))));\n"
)


def roles(one: Mind) -> set[str]:
    return {str(known.term) for known in one.agents[0].beliefs if known.term.functor == "role"}


def test_what_was_retracted_is_not_believed_again_after_a_power_failure_nor_by_other_rules() -> None:
    world, service = at_rest()
    changing = CHANGING.replace("?_", "defender")
    sent(world, service, RuleSet(version=1, files={"changing": changing}))
    saved = world.agents["fred"].memory().mind.rules
    assert saved is not None
    restored = mind(world.agents["fred"].profile)
    restored.recall(MindMemory.model_validate_json(saved.model_dump_json()), 9.0)
    assert roles(restored) == {"role(attacker)"}
    assert Term("at", (0.12345678901234,)) not in restored.agents[0].beliefs
    files = {"changing": changing + "BELIEF(role(goalkeeper));\n"}
    assert restored.follow(files, 2, 10.0) is None
    assert roles(restored) == {"role(attacker)", "role(goalkeeper)"}


def test_a_role_that_was_retracted_is_played_once_it_is_given_anew() -> None:
    world, service = at_rest()
    files = {"changing": CHANGING.replace("BELIEF(role(defender));\n", "").replace("?_", "guard")}
    sent(world, service, RuleSet(version=1, files=files, role="guard"))
    saved = world.agents["fred"].memory().mind.rules
    assert saved is not None
    restored = mind(world.agents["fred"].profile)
    restored.recall(saved, 9.0)
    assert roles(restored) == {"role(attacker)"}
    assert restored.follow(files, 2, 10.0, "porter") is None
    assert restored.follow(files, 3, 11.0, "guard") is None
    assert roles(restored) == {"role(attacker)", "role(guard)"}


def test_a_memory_without_what_was_retracted_is_read() -> None:
    world, service = at_rest()
    sent(world, service, RuleSet(version=1, files={"changing": CHANGING.replace("?_", "defender")}))
    saved = world.agents["fred"].memory().mind.rules
    assert saved is not None
    earlier = saved.model_dump(mode="json")
    del earlier["retracted"]
    restored = mind(world.agents["fred"].profile)
    restored.recall(MindMemory.model_validate(earlier), 9.0)
    assert roles(restored) == {"role(defender)", "role(attacker)"}


def test_a_robot_without_a_deliberative_level_refuses_rules() -> None:
    world = room(noise=0.0)
    service = Service(world, world.add("fred", Pose(x_m=1.0, y_m=1.5, heading_rad=EAST)), "fred")
    performative, report = sent(world, service, RuleSet(version=1, files={"wanderer": WANDERER}))
    assert (performative, report.reason) == (Performative.REFUSE, "fred has no deliberative level")


def test_a_message_holds_a_limited_number_of_files() -> None:
    with pytest.raises(ValueError, match="at most 16"):
        RuleSet(version=1, files={f"agent_{number}": "AGENT a;" for number in range(17)})


DUTY = "AGENT duty;"
GUARD = "ROLE guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"


def test_a_role_that_is_sent_is_believed_and_lasts_until_it_is_sent_no_more() -> None:
    world, service = at_rest()
    files = {"duty": DUTY, "guard": GUARD}
    _, idle = sent(world, service, RuleSet(version=1, files=files))
    assert (idle.role, believed(world)) == ("", set()), "its rules apply only in the role"
    _, played = sent(world, service, RuleSet(version=2, files=files, role="guard"))
    assert (played.role, believed(world)) == ("guard", {"on_duty"})
    memory = RobotMemory.model_validate_json(world.agents["fred"].memory().model_dump_json())
    rules = memory.mind.rules
    assert rules is not None
    restored = mind(world.agents["fred"].profile)
    restored.recall(rules, 9.0)
    assert restored.role == "guard"
    assert Term("role", ("guard",)) in restored.agents[0].beliefs
    _, ended = sent(world, service, RuleSet(version=3, files=files))
    assert ended.role == ""


def test_an_agents_rules_may_ask_for_a_role_that_has_no_file() -> None:
    world, service = at_rest()
    files = {"keeper": "AGENT keeper;\nBELIEF(role(porter)) => COMMIT(adoptBelief(carries));\n"}
    sent(world, service, RuleSet(version=1, files=files, role="porter"))
    assert believed(world) == {"carries"}
