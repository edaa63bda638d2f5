"""Operators' requests on missions: read, cancel, pause, resume, plan again, set the recovery policy."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict, Invalid, NotFound, unrecorded
from app.domain.events import (
    MissionCancelRequested,
    MissionPaused,
    MissionRecoverySet,
    MissionReplanRequested,
    MissionResumed,
)
from app.domain.goal_language.terms import GoalTerms
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import mission as mission_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import MissionState, has_ended, is_paused
from app.domain.lifecycles.recovery import RecoveryStep, ask_for_plan, try_again
from app.domain.lifecycles.script import can_be_ordered, order
from app.domain.plan_document import PlanBody
from app.domain.plan_edits import Pins, PlanEdit, words_of
from app.domain.recovery_rules import Policy
from app.missions.mission_speech import conversation_of
from app.planning.problem_builder import ProblemBuilder
from app.planning.waiting_goals import WaitingGoals
from app.store import GoalRow, MissionRow, PlanRow, ResultRow, ScriptRow
from app.store.records import all_of, joint_goal_of, lock_goals, page, read_only
from robots.wire import ControlVerb

Mission = tuple[MissionRow, list[ScriptRow]]


class MissionService:
    """Reads missions and takes operators' orders on them."""

    def __init__(self, core: Core, *, problems: ProblemBuilder, waiting: WaitingGoals) -> None:
        self._database = core.database
        self._events = core.events
        self._workflows = core.workflows
        self._plan_nets = core.plan_nets
        self._problems = problems
        self._waiting = waiting

    def get(self, mission_id: str) -> Mission:
        with self._database.read() as session:
            return _with_scripts(session, _mission(session, mission_id))

    def newest(
        self,
        *,
        world: str | None = None,
        state: str | None = None,
        limit: int = 100,
        after: str | None = None,
    ) -> tuple[Sequence[Mission], str | None]:
        with self._database.read() as session:
            rows, token = page(session, MissionRow, limit=limit, after=after, world=world, state=state)
            scripts = _scripts_by_mission(session, [row.id for row in rows])
            return [(row, scripts.get(row.id, [])) for row in rows], token

    def results(self, mission_id: str) -> Sequence[ResultRow]:
        """What its packets have brought, oldest first, without the images' content."""
        with self._database.read() as session:
            _mission(session, mission_id)
            query = read_only(ResultRow).where(ResultRow.mission_id == mission_id)
            return all_of(session, query.order_by(ResultRow.at_s, ResultRow.created_at, ResultRow.id))

    def conversation(self, mission_id: str) -> Sequence[Mapping[str, Any]]:
        """What its robots have said to each other and reported, and what was said with the service, in order."""
        with self._database.read() as session:
            return conversation_of(session, _mission(session, mission_id))

    def result(self, mission_id: str, result_id: str) -> ResultRow:
        """One result with its content."""
        with self._database.read() as session:
            _mission(session, mission_id)
            row = session.get(ResultRow, result_id)
            if row is None or row.mission_id != mission_id:
                raise NotFound(f"mission {mission_id} has no result {result_id!r}", code="unknown-result")
            return row

    def cancel(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Have every robot stop its script. The mission is cancelled once they have answered."""
        with self._database.write() as session:
            mission = _mission(session, mission_id, to_change=True)
            if mission.cancel_requested:
                return _with_scripts(session, mission)
            _refuse_ended(mission, "cancelled")
            mission.cancel_requested = True
            state = MissionState(mission.state)
            self._events.append(
                session,
                MissionCancelRequested(subject=mission.id, actor=actor, comment=comment, state=state),
            )
            self._workflows.wake(session, mission.workflow)
            return _with_scripts(session, mission)

    def replan(
        self,
        mission_id: str,
        edits: Sequence[PlanEdit],
        actor: str,
        comment: str,
        *,
        goals: Sequence[str] = (),
    ) -> Mission:
        """Have what the mission's robots have not done planned again, with something pinned. They stop meanwhile.

        :param goals: that wait, by id; the mission is to carry them out, too.
        :raises Conflict: if the mission has ended, is being cancelled or recovered, is paused, or is planned again
            already; if one of the goals does not wait, or cannot be true together with the mission's goal.
        :raises Invalid: if an edit cannot be meant of its plan, or a goal is not one that it can carry out, too.
        :raises NotFound: if the mission or a goal is not recorded.
        """
        with self._database.write() as session:
            goal_id = session.scalar(select(MissionRow.goal_id).where(MissionRow.id == mission_id))
            if goal_id is None:
                raise unrecorded("mission", mission_id)
            locked = lock_goals(session, (goal_id, *goals))  # lock order: the goals before the mission
            mission = _mission(session, mission_id, to_change=True)
            _refuse_to_replan(mission)
            goal = locked[goal_id]
            others = [_to_join(session, locked, one, goal) for one in dict.fromkeys(goals)]
            pins = self._pins(session, goal, mission, edits) if edits else ()
            words = words_of(pins)
            reason = ": ".join(filter(None, ("an operator has asked for another plan", comment or words)))
            ask_for_plan(
                mission,
                pins=[pin.model_dump(mode="json") for pin in pins],
                goals=[one.id for one in others],
                reason=reason,
            )
            if others and (refusal := self._problems.build(session, goal).refusal):
                raise Conflict(
                    f"mission {mission.id} cannot carry them out, too: {refusal}", code="cannot-join"
                )
            for one in others:
                self._waiting.join(session, one, mission)
            self._events.append(
                session,
                MissionReplanRequested(
                    subject=mission.id,
                    actor=actor,
                    comment=comment,
                    pinned=words,
                    goals=tuple(one.id for one in others),
                    state=MissionState(mission.state),
                ),
            )
            self._workflows.wake(session, mission.workflow)
            return _with_scripts(session, mission)

    def _pins(self, session: Session, goal: GoalRow, mission: MissionRow, edits: Sequence[PlanEdit]) -> Pins:
        """What the edits pin of the mission's plan."""
        plan = session.get_one(PlanRow, mission.plan_id)
        built = self._problems.build(session, goal)
        pinned = self._problems.pinned(built, PlanBody.model_validate(plan.body).edits)
        net = self._plan_nets.of(session, plan.id)
        return self._problems.pins(edits, net, pinned.problem, world=mission.world)

    def set_recovery(self, mission_id: str, policy: Policy, actor: str) -> Mission:
        """Set the recovery policy for later failures; a repair that waits for a decision still does."""
        with self._database.write() as session:
            mission = _mission(session, mission_id, to_change=True)
            _refuse_ended(mission, "recovered otherwise")
            if mission.recovery != policy:
                mission.recovery = policy
                state = MissionState(mission.state)
                self._events.append(
                    session,
                    MissionRecoverySet(subject=mission.id, actor=actor, policy=policy.value, state=state),
                )
                self._workflows.wake(session, mission.workflow)
            return _with_scripts(session, mission)

    def pause(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Order every robot that is still at work to stand still and to keep its position in its script."""
        with self._database.write() as session:
            return self.pause_in(session, mission_id, actor, comment)

    def pause_in(self, session: Session, mission_id: str, actor: str, comment: str) -> Mission:
        """As `pause`, in a transaction."""
        mission = _mission(session, mission_id, to_change=True)
        _refuse_ended(mission, "paused")
        if mission.cancel_requested:
            raise Conflict(f"mission {mission.id} is being cancelled", code="being-cancelled")
        if not is_paused(mission):
            mission_lifecycle.pause(mission)
            self._order(session, mission, ControlVerb.PAUSE, actor, comment)
        return _with_scripts(session, mission)

    def resume(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Go on after a pause; a stuck mission is recovered again."""
        with self._database.write() as session:
            mission = _mission(session, mission_id, to_change=True)
            if mission.recovery_step == RecoveryStep.STUCK and not is_paused(mission):
                return self._try_again(session, mission, actor, comment)
            if not is_paused(mission):
                raise Conflict(f"mission {mission.id} is {mission.state}, not paused", code="not-paused")
            mission_lifecycle.resume(mission)
            self._order(session, mission, ControlVerb.RESUME, actor, comment)
            return _with_scripts(session, mission)

    def _try_again(self, session: Session, mission: MissionRow, actor: str, comment: str) -> Mission:
        try_again(mission)
        state = MissionState(mission.state)
        self._events.append(
            session, MissionResumed(subject=mission.id, actor=actor, comment=comment, state=state)
        )
        self._workflows.wake(session, mission.workflow)
        return _with_scripts(session, mission)

    def _order(
        self, session: Session, mission: MissionRow, verb: ControlVerb, actor: str, comment: str
    ) -> None:
        ordered = MissionPaused if verb is ControlVerb.PAUSE else MissionResumed
        state = MissionState(mission.state)
        self._events.append(session, ordered(subject=mission.id, actor=actor, comment=comment, state=state))
        for script in _scripts(session, mission.id):
            if can_be_ordered(script, mission):
                order(script, verb)


def _mission(session: Session, mission_id: str, *, to_change: bool = False) -> MissionRow:
    row = session.get(MissionRow, mission_id, with_for_update=to_change)
    if row is None:
        raise unrecorded("mission", mission_id)
    return row


def _refuse_ended(mission: MissionRow, verb: str) -> None:
    if has_ended(mission):
        raise Conflict(
            f"mission {mission.id} is {mission.state}: it cannot be {verb} any longer", code="mission-ended"
        )


def _refuse_to_replan(mission: MissionRow) -> None:
    _refuse_ended(mission, "planned again")
    if mission.cancel_requested:
        raise Conflict(f"mission {mission.id} is being cancelled", code="being-cancelled")
    if mission.replanning is not None:
        raise Conflict(f"mission {mission.id} is being planned again already", code="being-replanned")
    if is_paused(mission):
        raise Conflict(
            f"mission {mission.id} is paused; resume it, then have it planned again", code="mission-paused"
        )
    if mission.state == MissionState.RECOVERING:
        raise Conflict(f"mission {mission.id} is being recovered: {mission.reason}", code="being-recovered")


def _to_join(session: Session, locked: Mapping[str, GoalRow], goal_id: str, own: GoalRow) -> GoalRow:
    """A goal that waits and that the mission for the goal `own` can carry out, too."""
    goal = locked.get(goal_id)
    if goal is None:
        raise unrecorded("goal", goal_id)
    joint = joint_goal_of(session, goal)
    if joint is not None and joint.state in goal_lifecycle.OPEN:
        raise Conflict(
            f"goal {goal.id} is carried out by mission {joint.mission_id} together with others",
            code="goal-committed",
        )
    if goal.state != GoalState.WAITING:
        raise Conflict(
            f"goal {goal.id} is {goal.state}; only goals that wait can join", code="goal-not-waiting"
        )
    if goal.world != own.world:
        raise Invalid(f"goal {goal.id} is of world {goal.world}, not of {own.world}", code="other-world")
    terms = GoalTerms.from_json(goal.terms)
    if terms.constraints or terms.holds or terms.not_before_at_s or goal.deadline_at_s is not None:
        raise Invalid(
            f"goal {goal.id} has constraints, holds or times of its own; it is planned by itself",
            code="cannot-join",
        )
    constraints = GoalTerms.from_json(own.terms).constraints
    if constraints.stages or constraints.worth:
        raise Invalid(
            f"goal {own.id} of the mission has an order or optional parts; no other goal can join it",
            code="cannot-join",
        )
    return goal


def _scripts(session: Session, mission_id: str) -> Sequence[ScriptRow]:
    query = select(ScriptRow).where(ScriptRow.mission_id == mission_id).order_by(ScriptRow.robot)
    return session.scalars(query).all()


def _scripts_by_mission(session: Session, mission_ids: Sequence[str]) -> Mapping[str, list[ScriptRow]]:
    query = read_only(ScriptRow).where(ScriptRow.mission_id.in_(mission_ids)).order_by(ScriptRow.robot)
    found: dict[str, list[ScriptRow]] = {}
    for script in all_of(session, query):
        found.setdefault(script.mission_id, []).append(script)
    return found


def _with_scripts(session: Session, mission: MissionRow) -> Mission:
    return mission, list(_scripts(session, mission.id))
