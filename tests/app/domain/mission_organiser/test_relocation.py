"""From the plan-net of the co-operative relocation to two scripts that are coupled by sensing alone."""

from app.domain.mission_organiser import Organised, load_library, organise
from planner import Keeping
from robots.wire import BehaviourPacket
from tests.app.laboratory import Laboratory
from tests.app.sample_store import said

LAB = Laboratory()


def packets() -> dict[tuple[str, str], BehaviourPacket]:
    """By robot and tag."""
    result = organise(LAB.relocation, load_library(LAB.base), LAB.repertoires, "mission-1", LAB.base)
    assert isinstance(result, Organised), result
    return {(script.robot, one.tag): one for script in result.scripts for one in script.packets}


def test_each_robot_gets_its_part_of_the_papers_story() -> None:
    assert list(packets()) == [
        *(("fred", tag) for tag in ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1")),
        *(("ginger", tag) for tag in ("TRACK", "DOCK2", "TRANSPORT", "RELEASE2")),
    ]


def test_the_robots_are_coupled_by_what_they_sense_and_by_nothing_else() -> None:
    assert not any(packet.after for packet in packets().values())
    assert all(ordering.kept_by is not Keeping.CLEARANCE for ordering in LAB.relocation.orderings)


def test_each_awaits_what_the_other_brings_about() -> None:
    awaits = {key: packet.awaits for key, packet in packets().items() if packet.awaits}
    in_fred, in_ginger = said("in(rock_sample, fred)"), said("in(rock_sample, ginger)")
    assert awaits == {
        ("ginger", "DOCK2"): (in_fred,),
        ("fred", "TRANSPORT"): (in_ginger,),
        ("ginger", "TRANSPORT"): (in_fred,),
        ("fred", "RELEASE1"): (in_ginger, said("brought(rock_sample, lander)")),
        ("ginger", "RELEASE2"): (said("holds_alone(ginger, rock_sample)"),),
    }


def test_a_script_for_joint_carrying_names_the_partner() -> None:
    found = packets()
    for me, other in (("fred", "ginger"), ("ginger", "fred")):
        arguments = found[me, "TRANSPORT"].arguments
        assert (arguments["robots"], arguments["robot"], arguments["partner"]) == ("fred+ginger", me, other)
    assert "partner" not in found["fred", "DOCK"].arguments


def test_what_a_robot_achieves_in_a_joint_action_names_no_other_robot() -> None:
    for (robot, tag), packet in packets().items():
        if tag == "TRANSPORT":
            assert all(robot in fact.args for fact in packet.requires if fact not in packet.awaits)
