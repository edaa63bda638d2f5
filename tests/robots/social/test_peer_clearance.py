"""Clearance from robot to robot: what has ended is believed of those whom the script names, and of nobody else."""

import pytest

from robots.repertoire import load_repertoire
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    ControlVerb,
    Message,
    Performative,
    Recipient,
    SpeechAct,
)
from tests.robots.social.talkers import Air, Talker
from tests.robots.stories import packet, script

WAITS = "NAVIGATE-door"
DELAYS_S = (0.0, 1.0, 20.0)


def ended(action: str, *tells: str) -> BehaviourPacket:
    recipients = tuple(Recipient(robot=one, script_id=f"script-{one}", within_s=300) for one in tells)
    return packet("NAVIGATE", ref2="hatch").model_copy(update={"id": action, "tells": recipients})


def waiting(robot: str, name: str = "", **told_by: tuple[str, ...]) -> BehaviourScript:
    one = packet("NAVIGATE", ref2="door", after=tuple(told_by)).model_copy(update={"told_by": told_by})
    return script(robot, one, name=name)


def pair(**faults: float) -> tuple[Air, Talker, Talker]:
    air = Air(**faults)  # type: ignore[arg-type]
    return air, air.add("fred"), air.add("ginger")


def test_who_ends_an_action_tells_those_who_wait_for_it_once() -> None:
    air, fred, ginger = pair()
    ginger.accept(waiting("ginger", a5=("fred",)))
    air.run_for(5.0)
    assert ginger.uncleared(WAITS) == {"a5"}
    assert air.sent == []
    fred.social.packet_ended(ended("a5", "ginger"))
    air.run_for(60.0)
    assert ginger.uncleared(WAITS) == frozenset()
    assert [(one.sender, one.performative) for one in air.sent] == [("fred", "inform"), ("ginger", "confirm")]
    assert fred.social.memory().owed == ()
    (report,) = ginger.reports
    assert (report.script_id, report.sender, report.content) == (
        "script-ginger",
        "fred",
        "ended(script-ginger, a5)",
    )
    assert report.answer is Performative.CONFIRM


@pytest.mark.parametrize(
    ("told_by", "speaker"),
    [({"a5": ("basil",)}, "fred"), ({"a5": ()}, "fred"), ({"a6": ("fred",)}, "fred")],
    ids=["another robot does it", "only the service clears", "another action"],
)
def test_nobody_is_believed_whom_the_script_does_not_name(
    told_by: dict[str, tuple[str, ...]], speaker: str
) -> None:
    air, fred, ginger = pair()
    ginger.accept(waiting("ginger", **told_by))
    fred.social.packet_ended(ended("a5", "ginger"))
    air.run_for(30.0)
    assert ginger.uncleared(WAITS) == set(told_by)
    assert [one.performative for one in air.sent] == ["inform", "refuse"]
    assert isinstance(air.sent[1].body, SpeechAct)
    assert air.sent[1].body.content.startswith("not_named(")
    assert fred.social.memory().owed == ()


def test_what_two_robots_do_together_has_ended_when_both_have_said_so() -> None:
    air, fred, ginger = pair()
    basil = air.add("basil")
    ginger.accept(waiting("ginger", a5=("basil", "fred")))
    for speaker, left in ((fred, {"a5"}), (fred, {"a5"}), (basil, set())):
        speaker.social.packet_ended(ended("a5", "ginger"))
        air.run_for(5.0)
        assert ginger.uncleared(WAITS) == left


def test_who_has_no_script_yet_is_told_again_once_it_may_have_one() -> None:
    air, fred, ginger = pair()
    fred.social.packet_ended(ended("a5", "ginger"))
    air.run_for(60.0)
    assert fred.social.memory().owed
    assert ginger.reports == [], "there is nothing to report of a script that is not here"
    assert len(air.sent) < 20
    ginger.accept(waiting("ginger", a5=("fred",)))
    air.run_for(40.0)
    assert ginger.uncleared(WAITS) == frozenset()
    assert fred.social.memory().owed == ()


def test_a_script_that_was_replaced_or_cancelled_takes_no_clearance_and_nobody_insists() -> None:
    air, fred, ginger = pair()
    ginger.accept(waiting("ginger", a5=("fred",)))
    assert ginger.executive.control("script-ginger", ControlVerb.CANCEL, None, 0.0) is None
    ginger.accept(waiting("ginger", "script-ginger-2", a5=("fred",)))
    fred.social.packet_ended(ended("a5", "ginger"))
    air.run_for(30.0)
    assert ginger.uncleared(WAITS) == {"a5"}, "the same name may mean another action in another plan"
    assert fred.social.memory().owed == ()


def test_who_does_not_hear_is_told_at_growing_intervals_until_it_no_longer_waits() -> None:
    air, fred, ginger = pair()
    ginger.accept(waiting("ginger", a5=("fred",)))
    air.cut.add("ginger")
    fred.social.packet_ended(ended("a5", "ginger"))
    air.run_for(299.0)
    assert 30 <= len(air.sent) <= 45
    assert len({one.id for one in air.sent}) == 1
    air.run_for(2.0)
    assert fred.social.memory().owed == ()
    before = len(air.sent)
    air.run_for(60.0)
    assert len(air.sent) == before


def test_it_is_told_at_once_that_it_can_be_heard_again() -> None:
    air, fred, ginger = pair()
    ginger.accept(waiting("ginger", a5=("fred",), a6=("fred",)))
    air.cut.add("ginger")
    fred.social.packet_ended(ended("a5", "ginger"))
    air.run_for(60.0)
    air.cut.clear()
    fred.social.packet_ended(ended("a6", "ginger"))
    air.run_for(4.0)
    assert ginger.uncleared(WAITS) == frozenset()


@pytest.mark.parametrize("seed", range(60))
def test_nothing_starts_early_and_everything_starts_whatever_the_radio_and_the_power_do(seed: int) -> None:
    air, fred, ginger = pair(seed=seed, loss=0.4, longest_s=6.0, repeats=0.3)
    basil = air.add("basil")
    speakers = (fred, basil)
    told_by = {f"a{n}": ("basil", "fred") if n % 3 == 0 else (speakers[n % 2].name,) for n in range(6)}
    fates = Air(seed=seed)._random
    arrives_s = fates.choice(DELAYS_S)
    due = {(action, one): fates.uniform(0.0, 60.0) for action, names in told_by.items() for one in names}
    said: dict[str, set[str]] = {action: set() for action in told_by}
    has_script = False
    for _ in range(800):
        now_s = air.clock.now_s()
        if not has_script and now_s >= arrives_s:
            ginger.accept(waiting("ginger", **told_by))
            has_script = True
        for (action, name), at_s in due.items():
            if name not in said[action] and now_s >= at_s:
                said[action].add(name)
                air.talkers[name].social.packet_ended(ended(action, "ginger"))
        for talker in (fred, basil, ginger):
            if fates.random() < 0.01:
                talker.restart()
        air.step()
        if has_script:
            cleared = told_by.keys() - ginger.uncleared(WAITS)
            assert all(said[action] == set(told_by[action]) for action in cleared), now_s
    assert ginger.uncleared(WAITS) == frozenset()
    assert not fred.social.memory().owed
    assert not basil.social.memory().owed


def test_a_stranger_may_not_speak_for_another() -> None:
    """The link lets a robot send in its own name alone; in its own it is not believed."""
    air, _, ginger = pair()
    ginger.accept(waiting("ginger", a5=("fred",)))
    act = SpeechAct(content="ended(script-ginger, a5)", protocol="macta-inform", conversation_id="c")
    air.add("mallory").send(
        Message(
            performative=Performative.INFORM, sender="mallory", receiver="ginger", sent_at_s=0.0, body=act
        )
    )
    air.run_for(2.0)
    assert ginger.uncleared(WAITS) == {"a5"}


def test_a_tuning_of_a_packet_that_waits_forgets_nobodys_word() -> None:
    air, fred, ginger = pair()
    basil = air.add("basil")
    (later,) = waiting("ginger", a5=("basil", "fred")).packets
    ginger.accept(script("ginger", packet("NAVIGATE", ref2="hatch"), later))
    fred.social.packet_ended(ended("a5", "ginger"))
    air.run_for(5.0)
    ginger.executive.retune(load_repertoire())
    basil.social.packet_ended(ended("a5", "ginger"))
    air.run_for(5.0)
    assert ginger.uncleared(WAITS) == frozenset()
