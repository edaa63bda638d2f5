"""Edits of a plan: what an operator pins of it, by action, and what that means for the goals that the actions serve."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from app.domain.errors import Invalid
from app.domain.goal_language.words import joined
from app.domain.world_model.berths import berths_of, interchanges
from app.domain.world_model.vocabulary import planner_fact, symbolic
from planner import KnowledgeBase, PlanNet, PlanningProblem
from planner.repair import CannotPin, Pin, PlanHandles, pinned
from robots.wire import SymbolicFact
from robots.world import WorldFile

MAX_EDITS = 20
"""Edits in one request."""
Name = Annotated[str, Field(min_length=1, max_length=120)]


class PlanEdit(BaseModel):
    """What is to be otherwise about an action, and with it about all that is done for the goal that it serves."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    action: Name = Field(description="id of an action of the plan")
    robot: Name | None = Field(
        default=None, description="this robot does what one of the action's robots does for the goal"
    )
    without: Name | None = Field(default=None, description="this robot does nothing for the goal")
    avoid: Name | None = Field(default=None, description="nothing for the goal is done at this place")
    via: Name | None = Field(default=None, description="samples go through this interchange on their way")
    not_before_s: float | None = Field(
        default=None, ge=0, le=1e7, description="the goal is not achieved earlier, seconds from now"
    )
    after: Name | None = Field(
        default=None,
        description="id of another action of the plan: the goal comes true only after the one that this serves",
    )

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        changes = (self.robot, self.without, self.avoid, self.via, self.not_before_s, self.after)
        if all(one is None for one in changes):
            raise ValueError(
                'say what is to be otherwise: "robot", "without", "avoid", "via", "not_before_s" or "after"'
            )
        return self


class GoalPin(BaseModel):
    """What is pinned for a goal of a plan."""

    model_config = ConfigDict(frozen=True)

    goal: SymbolicFact
    barred: tuple[str, ...] = Field(default=(), description="robots that are not recruited for it")
    avoided: tuple[str, ...] = Field(default=(), description="places that nothing done for it uses")
    not_before_at_s: float | None = Field(
        default=None, description="it is not achieved earlier, by the world's clock"
    )
    after: tuple[SymbolicFact, ...] = Field(
        default=(), description="goals of the plan after which it comes true"
    )
    words: tuple[str, ...] = Field(default=(), description="what was asked for")

    def and_also(self, other: "GoalPin") -> "GoalPin":
        """Both of a goal's pins."""
        times = [one for one in (self.not_before_at_s, other.not_before_at_s) if one is not None]
        return GoalPin(
            goal=self.goal,
            barred=tuple(sorted({*self.barred, *other.barred})),
            avoided=tuple(sorted({*self.avoided, *other.avoided})),
            not_before_at_s=max(times, default=None),
            after=tuple(dict.fromkeys((*self.after, *other.after))),
            words=tuple(dict.fromkeys((*self.words, *other.words))),
        )


Pins = tuple[GoalPin, ...]


def together(pins: Iterable[GoalPin]) -> Pins:
    """One pin for each goal."""
    by_goal: dict[SymbolicFact, GoalPin] = {}
    for pin in pins:
        by_goal[pin.goal] = by_goal[pin.goal].and_also(pin) if pin.goal in by_goal else pin
    return tuple(by_goal.values())


def words_of(pins: Pins) -> str:
    """What was asked for, in words."""
    return "; ".join(dict.fromkeys(words for pin in pins for words in pin.words))


def pins_of(
    edits: Sequence[PlanEdit],
    plan_net: PlanNet,
    problem: PlanningProblem,
    knowledge_base: KnowledgeBase,
    *,
    world: WorldFile,
    now_s: float,
) -> Pins:
    """What the edits pin.

    :param problem: the one that the plan-net solves, with what is pinned already.
    :param now_s: by the world's clock.
    :raises Invalid: if an edit cannot be meant of this plan, with what can, or what is pinned contradicts itself.
    """
    handles = PlanHandles(plan_net, problem, knowledge_base)
    pins = together(_pin(edit, handles, knowledge_base, world, now_s) for edit in edits)
    orders = {
        planner_fact(pin.goal, knowledge_base, problem.objects): frozenset(
            planner_fact(one, knowledge_base, problem.objects) for one in pin.after
        )
        for pin in pins
        if pin.after
    }
    try:
        handles.refuse_contradictions(orders)
    except CannotPin as error:
        named = next((edit.action for edit in edits if edit.after is not None), "")
        raise Invalid(str(error), code="cannot-edit", thing=named) from error
    return pins


def _pin(
    edit: PlanEdit, handles: PlanHandles, knowledge_base: KnowledgeBase, world: WorldFile, now_s: float
) -> GoalPin:
    barred: set[str] = set()
    after: tuple[SymbolicFact, ...] = ()
    words: list[str] = []
    try:
        goal = symbolic(handles.goal_of(edit.action), knowledge_base)
        if edit.robot is not None:
            barred |= handles.barred_for(edit.action, edit.robot)
            words.append(f"{edit.robot} for {goal}")
        if edit.without is not None:
            barred |= handles.without(edit.action, edit.without)
            words.append(f"without {edit.without} for {goal}")
        if edit.after is not None:
            after = (symbolic(handles.after(edit.action, edit.after), knowledge_base),)
            words.append(f"{goal} after {after[0]}")
    except CannotPin as error:
        raise Invalid(str(error), code="cannot-edit", thing=edit.action) from error
    avoided: set[str] = set()
    if edit.avoid is not None:
        avoided.update(_places(edit.avoid, goal, world))
        words.append(f"avoiding {edit.avoid} for {goal}")
    if edit.via is not None:
        avoided.update(_other_ways(edit.via, goal, world))
        words.append(f"via {edit.via} for {goal}")
    not_before_at_s = None
    if edit.not_before_s is not None:
        not_before_at_s = round(now_s + edit.not_before_s, 3)
        words.append(f"{goal} not before {edit.not_before_s:g} s from then")
    return GoalPin(
        goal=goal,
        barred=tuple(sorted(barred)),
        avoided=tuple(sorted(avoided)),
        not_before_at_s=not_before_at_s,
        after=after,
        words=tuple(words),
    )


def _places(name: str, goal: SymbolicFact, world: WorldFile) -> tuple[str, ...]:
    """The place of that name, or its berths."""
    known = dict.fromkeys((*world.places_by_location, *world.location_of))
    if name not in known:
        raise Invalid(f"there is no place {name!r} in {world.name}", code="unknown-place", thing=name)
    places = berths_of(name, world) or (name,)
    if needed := [place for place in (name, *places) if place in goal.args]:
        detail = f"{goal} is about {joined(needed[:1])}, which it cannot avoid"
        raise Invalid(detail, code="cannot-edit", thing=name)
    return tuple(places)


def _other_ways(name: str, goal: SymbolicFact, world: WorldFile) -> Iterator[str]:
    """The places of the interchanges that samples avoid on their way through this one; not the goal's own."""
    ways = interchanges(world)
    if name not in ways:
        passed = joined(ways, last="and") or "none here"
        detail = f"{name} is no interchange of {world.name}; samples go through {passed}"
        raise Invalid(detail, code="no-interchange", thing=name, choices=ways)
    for way in ways:
        places = berths_of(way, world) or (way,)
        if way != name and not {way, *places}.intersection(goal.args):
            yield from places


def applied(
    pins: Pins, problem: PlanningProblem, knowledge_base: KnowledgeBase, *, now_s: float
) -> PlanningProblem:
    """The problem whose plans keep to the pins; those about what the world no longer has are left out.

    :param now_s: the plan's start by the world's clock.
    """
    return pinned(
        problem,
        [
            Pin(
                goal=planner_fact(pin.goal, knowledge_base, problem.objects),
                barred=frozenset(pin.barred),
                avoided=frozenset(pin.avoided),
                not_before_s=max(0.0, (pin.not_before_at_s or now_s) - now_s),
                after=frozenset(
                    planner_fact(one, knowledge_base, problem.objects)
                    for one in pin.after
                    if all(name in problem.objects for name in one.args)
                ),
            )
            for pin in pins
            if all(name in problem.objects for name in pin.goal.args)
        ],
        knowledge_base,
    )
