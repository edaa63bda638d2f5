"""Roles in goals: where a goal names a robot it may name a role, for those that play it when the goal is planned."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar, cast

from app.domain.goal_language.issues import GoalIssue, unknown_name
from app.domain.goal_language.words import joined, natural_key
from app.domain.world_model.problem import objects_of
from robots.wire import SymbolicFact
from robots.world import WorldFile

Term = TypeVar("Term")

Players = Mapping[str, tuple[str, ...]]
"""By role, the robots that play it."""


def players_of(world: WorldFile) -> Players:
    """The roles that robots of the world play; one that is called as a robot means the robot."""
    players: dict[str, tuple[str, ...]] = {}
    for spec in sorted(world.robots, key=lambda spec: natural_key(spec.name)):
        if spec.role is not None and spec.role.name not in world.robots_by_name:
            players[spec.role.name] = (*players.get(spec.role.name, ()), spec.name)
    return players


def robots_for(names: Iterable[str], world: WorldFile) -> tuple[str, ...]:
    """The names with the robots that play it in place of each role."""
    players = players_of(world)
    return tuple(dict.fromkeys(robot for name in names for robot in players.get(name, (name,))))


def with_players(
    goals: Sequence[SymbolicFact], stages: Sequence[Term], world: WorldFile
) -> tuple[tuple[SymbolicFact, ...], tuple[Term, ...]]:
    """The goals, and their stages if there are any, with one for each player in place of each that names a role.

    :param stages: or another term of each goal, which those of its players have, too.
    """
    players = players_of(world)
    roles = players.keys() - objects_of(world).keys() if players else set[str]()
    if not any(arg in roles for goal in goals for arg in goal.args):
        return tuple(goals), tuple(stages)
    staged: list[Term | None] = list(stages) if len(stages) == len(goals) else [None] * len(goals)
    found: dict[SymbolicFact, Term | None] = {}
    for goal, stage in zip(goals, staged, strict=True):
        role = next((arg for arg in goal.args if arg in roles), None)
        for robot in (None,) if role is None else players[role]:
            found.setdefault(goal if robot is None else _replaced(goal, role, robot), stage)
    return tuple(found), cast(tuple[Term, ...], tuple(found.values())) if stages else ()


def with_roles(
    goals: Sequence[SymbolicFact], stages: Sequence[int], said: Players
) -> tuple[tuple[SymbolicFact, ...], tuple[int, ...]]:
    """The reverse for roles that a sentence has said: a goal that is stated of each player is one of the role."""
    staged = dict(zip(goals, stages, strict=True)) if stages else dict.fromkeys(goals, 0)
    for role, robots in said.items():
        for goal, stage in list(staged.items()):
            one = next((arg for arg in goal.args if arg in robots), None)
            each = [_replaced(goal, one, robot) for robot in robots]
            if one is None or goal not in staged or any(staged.get(other) != stage for other in each):
                continue
            kept = [(known, at) for known, at in staged.items() if known == goal or known not in each]
            staged = {_replaced(goal, one, role) if known == goal else known: at for known, at in kept}
    return tuple(staged), tuple(staged.values()) if stages else ()


def unknown_robot(name: str, world: WorldFile) -> GoalIssue:
    """The issue that no robot has the name, and none plays a role of that name."""
    players = players_of(world)
    issue = unknown_name(
        "robot", name, (*sorted((spec.name for spec in world.robots), key=natural_key), *players)
    )
    played = [f"{role} ({', '.join(robots)})" for role, robots in sorted(players.items())]
    return GoalIssue(
        code=issue.code,
        kind=issue.kind,
        detail=f"{issue.detail}; the roles that robots play are {joined(played, last='and')}"
        if played
        else issue.detail,
        thing=name,
        choices=issue.choices,
    )


def _replaced(goal: SymbolicFact, name: str | None, other: str) -> SymbolicFact:
    return goal.model_copy(update={"args": tuple(other if arg == name else arg for arg in goal.args)})
