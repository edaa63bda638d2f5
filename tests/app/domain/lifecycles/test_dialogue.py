"""A dialogue's life: from the first word to one end, and never back."""

from dataclasses import dataclass
from itertools import product

import pytest

from app.domain.errors import IllegalTransition
from app.domain.lifecycles.dialogue import OPEN, DialogueState, become, begin, is_open

S = DialogueState
ENDS = set(S) - set(OPEN)


@dataclass
class Talk:
    state: str = ""
    reason: str = ""


def can_become(state: DialogueState, target: DialogueState) -> bool:
    try:
        become(Talk(state), target, "because")
    except IllegalTransition:
        return False
    return True


def test_what_has_ended_stays_so_and_what_is_open_can_end() -> None:
    for state, target in product(ENDS, S):
        assert not can_become(state, target), (state, target)
    for state in OPEN:
        assert is_open(Talk(state))
        assert can_become(state, S.WITHDRAWN)
        assert any(can_become(state, end) for end in ENDS)


def test_what_the_robot_has_been_told_is_neither_asked_nor_proposed_again() -> None:
    for state, target in product((S.SAID, S.AGREED), (S.ASKING, S.PROPOSED, S.SAID)):
        assert not can_become(state, target)


def test_a_dialogue_does_not_begin_with_the_robots_answer() -> None:
    begun = Talk()
    begin(begun, S.REFUSED, "on a mission")
    assert (begun.state, begun.reason) == ("refused", "on a mission")
    for state in (S.AGREED, S.FAILED, S.TIMED_OUT, S.NOT_UNDERSTOOD):
        with pytest.raises(IllegalTransition):
            begin(Talk(), state)
