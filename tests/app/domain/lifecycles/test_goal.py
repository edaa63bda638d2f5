"""A goal's life cycle: any order of commands keeps to the table, and what a command refuses changes nothing."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from app.domain.errors import IllegalTransition
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import OPEN, TO_BE_PLANNED, UNDECIDED, GoalState
from tests.app.domain.lifecycles.refusals import refused

OVER = set(GoalState) - set(OPEN)
ENDS_FROM = (
    GoalState.SUBMITTED,  # there is nothing to do
    GoalState.PLANNING,  # all of it is true already
    GoalState.WAITING,  # another goal's mission has carried it out
    GoalState.COMMITTED,
)


@dataclass
class Goal:
    state: str = GoalState.SUBMITTED
    reason: str = ""
    outcome: str | None = None
    plan_id: str | None = None
    mission_id: str | None = None
    waits_for: dict[str, Any] | None = None


class AnyOrderOfCommands(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.goal = Goal()

    def change(self, command: Callable[[Goal], None], target: GoalState, *sources: GoalState) -> None:
        before = replace(self.goal)
        if refused(lambda: command(self.goal), IllegalTransition):
            assert before.state not in sources
            assert self.goal == before
        else:
            assert before.state in sources
            assert self.goal.state == target

    @rule()
    def resubmit(self) -> None:
        self.change(
            lambda goal: goal_lifecycle.resubmit(goal, "the plan has expired"),
            GoalState.SUBMITTED,
            GoalState.PLANNED,
        )

    @rule()
    def begin_planning(self) -> None:
        self.change(goal_lifecycle.begin_planning, GoalState.PLANNING, *TO_BE_PLANNED)

    @rule()
    def wait(self) -> None:
        self.change(
            lambda goal: goal_lifecycle.wait(goal, "waits for mission m"), GoalState.WAITING, *UNDECIDED
        )

    @rule()
    def propose(self) -> None:
        self.change(
            lambda goal: goal_lifecycle.propose(goal, "plan-1"), GoalState.PLANNED, GoalState.PLANNING
        )

    @rule()
    def give_up(self) -> None:
        self.change(
            lambda goal: goal_lifecycle.give_up(goal, outcome="timed_out", reason="no time"),
            GoalState.UNSOLVABLE,
            *TO_BE_PLANNED,
        )

    @rule()
    def commit(self) -> None:
        self.change(
            lambda goal: goal_lifecycle.commit(goal, plan_id="plan-1", mission_id="mission-1"),
            GoalState.COMMITTED,
            GoalState.PLANNED,
            GoalState.COMMITTED,
        )

    @rule()
    def finish(self) -> None:
        self.change(
            lambda goal: goal_lifecycle.finish(goal, outcome="completed", reason=""),
            GoalState.FINISHED,
            *ENDS_FROM,
        )

    @rule()
    def end_with_another(self) -> None:
        own = self.goal.mission_id
        self.change(
            lambda goal: goal_lifecycle.finish(
                goal, outcome="completed", reason="", carried_out_by="another's"
            ),
            GoalState.FINISHED,
            *ENDS_FROM,
        )
        assert self.goal.mission_id in (own, "another's")

    @rule()
    def withdraw(self) -> None:
        self.change(
            lambda goal: goal_lifecycle.withdraw(goal, outcome="cancelled", reason="cancelled"),
            GoalState.WITHDRAWN,
            *UNDECIDED,
        )

    @invariant()
    def an_outcome_is_known_exactly_when_the_goal_is_over(self) -> None:
        assert (self.goal.outcome is not None) is (self.goal.state in OVER)

    @invariant()
    def a_waiting_goal_says_what_for(self) -> None:
        assert self.goal.state != GoalState.WAITING or self.goal.reason

    @invariant()
    def a_mission_carries_out_what_was_planned(self) -> None:
        if self.goal.mission_id == "another's":
            assert self.goal.state == GoalState.FINISHED
        elif self.goal.mission_id is not None:
            assert self.goal.state in (GoalState.COMMITTED, GoalState.FINISHED)
            assert self.goal.plan_id is not None


TestAnyOrderOfCommands = AnyOrderOfCommands.TestCase
