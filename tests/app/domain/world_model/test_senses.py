"""What robots sense, and what follows for plans made before."""

import pytest

from app.domain.errors import Invalid
from app.domain.mission_organiser import Organised, OrganiserFailure, load_library, organise
from app.domain.plan_document import PlanBody
from app.domain.world_model import planning_problem
from app.domain.world_model.edits import ChangeRobot, apply_edits
from app.domain.world_model.factsheets import addition, difference
from app.domain.world_model.senses import restricted_senses, senses_of, unsensed
from planner import Keeping, keep_in_step
from robots.repertoire import Repertoire, load_repertoire
from robots.repertoire.sensed_facts import SensedFact
from robots.wire import Factsheet
from robots.world import RobotSpec, WorldFile
from robots.world.parts import STORE_TAGS
from tests.app.sample_store import Store

STORE = Store()
LIBRARY = load_library(STORE.base)
PERCEIVES = load_repertoire().senses
CLUTTERED = SensedFact.model_validate(
    {"fact": "cluttered($me, $place)", "by": {"sense": "measured", "quantity": "clutter", "least": 0.2}}
)


def saying(senses: tuple[str, ...] | None, robot: str = "store_2") -> WorldFile:
    """The sample store where one robot says what it senses."""
    edit = ChangeRobot(name=robot, senses=senses)
    return apply_edits(STORE.world, [edit], STORE.facts, STORE.base).world


def test_the_robots_of_the_store_sense_all_that_is_sensed_by_their_sensors() -> None:
    assert restricted_senses(STORE.world, STORE.base, PERCEIVES) == {}
    assert planning_problem(STORE.world, STORE.facts, [], knowledge_base=STORE.base).senses == {}
    known = senses_of(STORE.world.robot("store_2"), PERCEIVES)
    assert {"in", "clear", "vacant", "near", "brought", "holds_alone"} <= known


@pytest.mark.parametrize("senses", [(), ("clear",), ("in", "clear", "vacant")])
def test_a_robot_senses_what_it_says(senses: tuple[str, ...]) -> None:
    world = saying(senses)
    assert senses_of(world.robot("store_2"), PERCEIVES) == set(senses)
    assert restricted_senses(world, STORE.base, PERCEIVES) == {"store_2": set(senses)}
    problem = planning_problem(world, STORE.facts, [], knowledge_base=STORE.base, perceives=PERCEIVES)
    assert problem.senses == {"store_2": set(senses)}


def test_without_a_word_of_its_own_a_robot_senses_what_its_sensors_measure() -> None:
    repertoire = Repertoire(load_repertoire().specs, (CLUTTERED,))
    plain = STORE.world.robot("yard_1")
    scanning = RobotSpec.model_validate(dict(plain) | {"sensors": ["scanner"]})
    assert "cluttered" in senses_of(scanning, repertoire.senses)
    assert "cluttered" not in senses_of(plain, repertoire.senses)
    assert "in" in senses_of(plain, repertoire.senses)


def test_a_body_without_infra_red_sees_nothing_of_others_work() -> None:
    assert load_repertoire().senses(own=("gripper", "bumper")) == {"robot_attribute"}


def test_a_word_that_is_no_predicate_is_refused_with_the_choices() -> None:
    with pytest.raises(Invalid, match=r"robots.store_2.senses: unknown predicate 'smell'; choices: .*vacant"):
        saying(("smell",))


def test_a_factsheet_says_what_its_robot_senses() -> None:
    sheet = Factsheet(
        repertoire=STORE_TAGS, speed_m_s=0.5, turn_rad_s=1.5, senses=(), start=(4.0, 1.4, -90.0)
    )
    assert addition("visitor_1", sheet, STORE.world).robot.senses == ()
    spec = STORE.world.robot("yard_1")
    change = difference(sheet, spec)
    assert change is not None
    assert change.values == {"senses": ()}
    same = sheet.model_copy(update={"senses": None})
    assert difference(same, spec) is None
    told = RobotSpec.model_validate(dict(spec) | {"senses": ("in", "clear")})
    assert difference(sheet.model_copy(update={"senses": ("clear", "in")}), told) is None
    assert difference(same, told) is None, "what a factsheet leaves out stays"


def blind_plan() -> PlanBody:
    net = STORE.store_sample_1()
    problem = planning_problem(saying(()), STORE.facts, net.goals, knowledge_base=STORE.base)
    kept = keep_in_step(net, problem.facts, problem.objects, STORE.base, problem.senses)
    return PlanBody.of_plan_net(kept, STORE.base)


def test_a_robot_without_senses_gets_no_awaits_but_waits_for_the_actions() -> None:
    body = blind_plan()
    assert body.senses == {"store_2": ()}
    assert body.clearances == 1
    net = PlanBody.model_validate_json(body.model_dump_json()).to_plan_net(STORE.base)
    assert PlanBody.of_plan_net(net, STORE.base) == body
    organised = organise(net, LIBRARY, STORE.repertoires, "mission-1", STORE.base)
    assert isinstance(organised, Organised)
    store_2, yard_1 = organised.scripts
    assert not any(packet.awaits for packet in store_2.packets)
    dock = next(packet for packet in store_2.packets if packet.tag == "DOCK")
    release = next(packet for packet in yard_1.packets if packet.tag == "RELEASE2")
    assert dock.after == (release.id,)


def test_a_plan_that_relies_on_senses_which_its_robot_lacks_now_is_refused() -> None:
    net = STORE.store_sample_1()
    lacking = restricted_senses(saying(("clear",)), STORE.base)
    refused = organise(net, LIBRARY, STORE.repertoires, "mission-1", STORE.base, senses=lacking)
    assert isinstance(refused, OrganiserFailure)
    assert "store_2 is to sense in(sample_1, interchange_2) before" in refused.reason
    assert "senses clear: plan again, or name in in the senses of store_2" in refused.reason
    assert list(unsensed(net, {}, STORE.base)) == []
    again = blind_plan().to_plan_net(STORE.base)
    assert list(unsensed(again, restricted_senses(saying(()), STORE.base), STORE.base)) == []


def test_a_world_file_keeps_what_its_robots_say() -> None:
    world = saying(())
    assert WorldFile.model_validate_json(world.model_dump_json()) == world
    assert any(ordering.kept_by is Keeping.CLEARANCE for ordering in blind_plan().orderings)
