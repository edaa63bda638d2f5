"""The relocation laboratory as the mission logic sees it, and the plan-net of its task made without a search."""

from functools import cached_property

from planner import PlanNet
from robots.world import WorldFile, load_world
from tests.app.sample_store import Step, Store

GOAL = "in(rock_sample, lander)"


def lab_with(**changes: object) -> WorldFile:
    """The world file with parts exchanged."""
    return WorldFile.model_validate({**load_world("relocation_lab").model_dump(), **changes})


class Laboratory(Store):
    """Fred grips the rock sample first, Ginger puts it down (MACTA §1, §5)."""

    def __init__(self, world: WorldFile | None = None) -> None:
        super().__init__(world or load_world("relocation_lab"))

    @cached_property
    def relocation(self) -> PlanNet:
        return self.plan(relocation_steps(), GOAL)


def relocation_steps() -> list[Step]:
    rock, lab = {"object": "rock_sample"}, {"area": "lab"}
    drive = {"robots": "fred", "rel1": "near", "ref1": "home_fred", "rel2": "near", "ref2": "quarry"}
    join = {"robot1": "ginger", "robot2": "fred"}
    come = {"rel1": "near", "ref1": "home_ginger", "rel2": "at", "ref2": "quarry"}
    way = {"rel1": "at", "ref1": "quarry", "rel2": "near", "ref2": "lander"}
    hand_over = {"robot1": "fred", "robot2": "ginger", "rel": "near", "ref": "lander", "spot": "fred_spot"}
    return [
        ("NAVIGATE", {**drive, **lab}),
        ("TRACK", {**join, **lab}),
        ("DOCK", {**rock, "robots": "fred", "rel1": "near", "ref1": "quarry"}),
        ("DOCK2", {**rock, **join, **come, **lab}),
        ("TRANSPORT", {**rock, "robots": "fred+ginger", **way, **lab}),
        ("RELEASE1", {**rock, **hand_over}),
        ("RELEASE2", {**rock, "robots": "ginger", **way}),
    ]
