"""Steps without use are left out, and two of one kind give way to one; of a robot that moves between places."""

import pytest

from planner import KnowledgeBase
from planner.engines.hierarchical.fragments.action_elimination import is_intended, merged, needed
from planner.engines.hierarchical.fragments.steps import Step, Task

A, B, C, D = (1 << number for number in range(4))


class Moves:
    """Makes steps that need one place and bring about another."""

    def __init__(self, knowledge_base: KnowledgeBase) -> None:
        self._operators = {operator.spec.name: operator for operator in knowledge_base.operators}

    def __call__(
        self,
        start: int,
        end: int,
        *,
        cost: float = 10.0,
        tag: str = "NAVIGATE",
        robot: str = "fred",
        intended: bool = True,
    ) -> Step:
        return Step(
            op=self._operators[tag],
            args=(robot, str(start), str(end)),
            cost=cost,
            needs=start,
            removes=start,
            adds=end,
            intended=end if intended else 0,
            justifying=end if intended else 0,
            agents=(robot,),
        )


@pytest.fixture
def move(knowledge_base: KnowledgeBase) -> Moves:
    return Moves(knowledge_base)


def task(*steps: Step, goal: int = C) -> Task:
    return Task(objects=frozenset(), steps=steps, initial=A, goal=goal, width=4)


def test_two_steps_give_way_to_a_cheaper_one_of_their_operator_and_robot(move: Moves) -> None:
    detour, direct = [move(A, B), move(B, C)], move(A, C, cost=19.0)
    assert merged(task(*detour, direct), detour) == (direct,)


@pytest.mark.parametrize("other", [{"cost": 20.0}, {"tag": "TRANSPORT"}, {"robot": "ginger"}])
def test_they_give_way_to_no_other(move: Moves, other: dict[str, float | str]) -> None:
    detour, direct = [move(A, B), move(B, C)], move(A, C, **{"cost": 1.0, **other})  # type: ignore[arg-type]
    assert merged(task(*detour, direct), detour) == tuple(detour)


def test_a_step_goes_with_those_that_only_it_made_possible(move: Moves) -> None:
    there_and_back, way = [move(A, B), move(B, A)], move(A, C)
    assert needed(task(*there_and_back, way), [*there_and_back, way]) == (way,)
    assert needed(task(way), [way]) == (way,)


def test_a_step_whose_use_is_not_intended_has_none(move: Moves) -> None:
    way, by_chance = move(A, C), move(A, C, intended=False)
    assert is_intended(task(way), [way])
    assert not is_intended(task(by_chance), [by_chance])
    assert not is_intended(task(way, goal=D), [way])
