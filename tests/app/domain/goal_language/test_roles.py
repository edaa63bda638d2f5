"""Goals name roles in place of robots: for those that play them when the goal is planned."""

import pytest

from app.domain.goal_language.check import check_request
from app.domain.goal_language.constraints import Constraints
from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.goal_language.roles import players_of, with_players
from app.domain.world_model import initial_facts
from planner import load_knowledge_base
from robots.wire import SymbolicFact
from robots.world import RoleSpec, WorldFile, load_world

STORE = load_world("sample_store")
ROLES = {"yard_1": "guard", "yard_2": "guard", "store_1": "left_porter"}


def playing(roles: dict[str, str]) -> WorldFile:
    robots = [
        spec.model_copy(update={"role": RoleSpec(name=roles[spec.name]) if spec.name in roles else None})
        for spec in STORE.robots
    ]
    return WorldFile.model_construct(**{**dict(STORE), "robots": tuple(robots)})


WORLD = playing(ROLES)
FACTS = initial_facts(WORLD, load_knowledge_base())


def near(robot: str, place: str) -> SymbolicFact:
    return SymbolicFact(predicate="near", args=(robot, place))


def read(text: str, world: WorldFile = WORLD) -> Understood:
    understood = understand(text, world, FACTS)
    assert isinstance(understood, Understood), understood
    return understood


def asked(text: str) -> Clarification:
    found = understand(text, WORLD, FACTS)
    assert isinstance(found, Clarification), found
    return found


def test_who_plays_a_role() -> None:
    assert players_of(WORLD) == {"guard": ("yard_1", "yard_2"), "left_porter": ("store_1",)}
    assert players_of(playing({"yard_1": "yard_2"})) == {}, "a robot of that name is meant"


@pytest.mark.parametrize(
    ("text", "goals"),
    [
        ("send all guards to door_2", [near("guard", "door_2")]),
        ("send the guards to door_2", [near("guard", "door_2")]),
        ("send the left porter to door_2", [near("left_porter", "door_2")]),
        ("send left_porter to door_2", [near("left_porter", "door_2")]),
        ("send any guard to door_2", [near("yard_1", "door_2")]),
        ("send yard_2 and the other guard to door_1", [near("yard_2", "door_1"), near("yard_1", "door_1")]),
        ("park all guards", [near("yard_1", "home_yard_1"), near("yard_2", "home_yard_2")]),
    ],
)
def test_a_sentence_names_a_role_where_it_names_robots(text: str, goals: list[SymbolicFact]) -> None:
    assert list(read(text).goals) == goals


def test_one_of_several_players_is_asked_for_and_too_many_are_refused() -> None:
    which = asked("send the guard to door_2")
    assert (which.code, which.choices) == ("robot-needed", ("yard_1", "yard_2"))
    assert which.detail == "which guard? There are 2: yard_1 and yard_2"
    many = asked("send three guards to door_2")
    assert (many.code, many.detail) == ("robot-needed", "3 guards are asked for, there are 2")


def test_constraints_name_roles_and_hold_for_their_players() -> None:
    said = read("move sample_1 to bay_7 without guards").constraints
    assert said.without == ("guard",)
    assert said.in_world(WORLD).excluded == {"yard_1", "yard_2"}
    assert said.in_world(playing({"store_1": "guard"})).excluded == {"store_1"}
    only = read("move sample_1 to bay_7 with yard_1 and the left porter").constraints
    assert set(only.robots) == {"yard_1", "left_porter"}
    assert only.in_world(WORLD).excluded == {"yard_2", "store_2"}


def test_a_role_stands_for_its_players_at_the_time_each_in_the_stage_of_the_goal() -> None:
    said = read("send all guards to door_2, then send store_1 to bay_1")
    assert (said.goals, said.constraints.stages) == (
        (near("guard", "door_2"), near("store_1", "bay_1")),
        (0, 1),
    )
    found = with_players(said.goals, said.constraints.stages, WORLD)
    assert found == (
        (near("yard_1", "door_2"), near("yard_2", "door_2"), near("store_1", "bay_1")),
        (0, 0, 1),
    )
    later = playing({"store_2": "guard"})
    assert with_players(said.goals, said.constraints.stages, later)[0][0] == near("store_2", "door_2")
    assert with_players([near("yard_1", "door_2")], (), WORLD) == ((near("yard_1", "door_2"),), ())


@pytest.mark.parametrize(
    ("world", "words"),
    [
        (WORLD, "the roles that robots play are guard (yard_1, yard_2) and left_porter (store_1)"),
        (
            playing({"yard_1": "keepers"}),
            "did you mean keepers?; the roles that robots play are keepers (yard_1)",
        ),
        (STORE, "there is no robot 'keeper'"),
    ],
)
def test_a_role_that_nobody_plays_is_refused_with_the_roles_that_there_are(
    world: WorldFile, words: str
) -> None:
    base = load_knowledge_base()
    for goals, constraints in (
        ([near("keeper", "door_2")], Constraints()),
        ([near("yard_1", "door_2")], Constraints(robots=("keeper",))),
    ):
        (issue,) = check_request(goals, constraints, world, FACTS, base)
        assert (issue.code, issue.thing) == ("unknown-robot", "keeper")
        assert words in issue.detail
        assert set(players_of(world)) <= set(issue.choices)
