"""Which objects are near a problem's goals."""

from types import SimpleNamespace
from typing import cast

from planner import Fact
from planner.engines.hierarchical.fragments.relevance import goal_neighbourhood
from planner.engines.hierarchical.fragments.world_index import WorldIndex

LINKS = {"sample": ["bay", "rover"], "bay": ["sample", "aisle"], "rover": ["yard"], "yard": ["gate"]}
INDEX = cast(
    WorldIndex,
    SimpleNamespace(
        objects=dict.fromkeys(("sample", "bay", "rover", "aisle", "yard", "gate"), "thing"),
        linked_by_fluents=lambda name: LINKS.get(name, []),
    ),
)
GOAL = Fact("object_position", ("sample", "in", "bay"))


def test_each_object_has_its_steps_from_the_goals() -> None:
    assert goal_neighbourhood(INDEX, [GOAL], 0) == {"sample": 0, "bay": 0}
    assert goal_neighbourhood(INDEX, [GOAL], 1) == {"sample": 0, "bay": 0, "rover": 1, "aisle": 1}
    assert goal_neighbourhood(INDEX, [GOAL], 2) == {"sample": 0, "bay": 0, "rover": 1, "aisle": 1, "yard": 2}
