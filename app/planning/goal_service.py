"""Takes goals: parses them, checks them against the world, records them and queues them for planning."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import cache, partial
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Busy, Conflict, Invalid, unrecorded
from app.domain.events import GoalStopRequested, GoalSubmitted, GoalWithdrawn
from app.domain.goal_language.check import GoalIssue, blocking, check_request, preference_conflicts
from app.domain.goal_language.completion import completions, replacements, span_of
from app.domain.goal_language.constraints import UNCONSTRAINED, Constraints, check_constraints
from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.goal_language.hold_checks import (
    check_holds,
    goals_of_holds,
    held_issues,
    standing_conflicts,
)
from app.domain.goal_language.issues import unknown_name
from app.domain.goal_language.references import Aims
from app.domain.goal_language.stated_holds import (
    HoldPreview,
    StandingHold,
    StatedHold,
    kept_by,
    kept_by_standing,
)
from app.domain.goal_language.syntax import grammar
from app.domain.goal_language.terms import GoalHold, GoalTerms, Reading
from app.domain.goal_language.times import Due
from app.domain.goal_language.verbs import Verbs, shipped_verbs
from app.domain.ids import new_id
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import OPEN
from app.domain.lifecycles.plan import PlanState
from app.domain.recovery_rules import policy_for
from app.domain.tender_document import Allocation
from app.domain.world_model import Facts
from app.planning.goal_planning import finish_without_mission
from app.planning.hold_service import HoldService, open_aims, open_goals
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.proposals import close_plans
from app.planning.requests import PlanningRequests
from app.planning.tenders import Tenders
from app.planning.waiting_goals import STATED_BY
from app.store import GoalRow, MissionRow
from app.store.records import joint_goal_of, lock_goal, page, refuse_removed
from app.store.roles import with_roles_in_force
from app.store.standing_holds import standing_holds
from robots.clock import Clock
from robots.wire import SymbolicFact
from robots.world import WorldFile

CANCELLED = "cancelled"
"""The outcome of a goal that was cancelled before it was carried out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalRequest:
    """A goal as an operator submits it.

    :param text: a sentence; None if `goal` is given, or `holds` alone.
    :param constraints: beside those of the sentence; likewise `holds`.
    :param deadline_s: from now, by the world's clock; None also if the sentence states a deadline.
    :param not_before_s: how long it is not to be true, from now, by the world's clock.
    :param recovery: a `Policy`; None: by `auto_approve`.
    """

    world: str | None
    text: str | None = None
    goal: Sequence[SymbolicFact] | None = None
    constraints: Constraints = UNCONSTRAINED
    holds: Sequence[StatedHold] = ()
    priority: int = 0
    deadline_s: float | None = None
    not_before_s: float | None = None
    auto_approve: bool = False
    recovery: str | None = None
    allocation: Allocation = Allocation.CENTRAL
    planning: PlanningWish = field(default_factory=PlanningWish)


@dataclass(frozen=True, slots=True, kw_only=True)
class Checked:
    """How a goal is understood: its facts and terms, or the first issue with them, and possible completions.

    :param deadline_s: seconds from now, by the world's clock.
    """

    goals: Sequence[SymbolicFact] = ()
    constraints: Constraints = UNCONSTRAINED
    deadline_s: float | None = None
    due: Due | None = None
    readings: Sequence[Reading] = ()
    holds: Sequence[HoldPreview] = ()
    preferences: Sequence["CheckedPreference"] = ()
    issue: Clarification | GoalIssue | None = None
    completions: Sequence[str] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedPreference:
    """A preference in words, what it costs to break it, and why no plan can keep it; empty if one may."""

    preference: str
    cost_s: float
    conflict: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Stated(Understood):
    """What a request asks for in the present world.

    :param emptying: those of the goals that make true what is to be kept, the last ones.
    :param standing: the holds that stood before.
    """

    emptying: tuple[SymbolicFact, ...] = ()
    standing: Sequence[StandingHold] = ()

    @classmethod
    def of(
        cls,
        said: Understood,
        emptying: tuple[SymbolicFact, ...],
        readings: tuple[Reading, ...],
        standing: Sequence[StandingHold],
    ) -> "_Stated":
        stages = said.constraints.stages
        constraints = said.constraints
        worth = said.constraints.worth
        if stages and emptying:
            constraints = constraints.model_copy(update={"stages": (*stages, *(0 for _ in emptying))})
        if worth and emptying:
            constraints = constraints.model_copy(update={"worth": (*worth, *(None for _ in emptying))})
        return cls(
            goals=(*said.goals, *emptying),
            constraints=constraints,
            due=said.due,
            readings=(*said.readings, *readings),
            holds=said.holds,
            emptying=emptying,
            standing=standing,
        )


class GoalService:
    """Takes, reads, stops and cancels goals."""

    def __init__(
        self,
        core: Core,
        *,
        world: Callable[[str | None], WorldFile],
        clocks: Mapping[str, Clock],
        limits: PlanningLimits,
        open_goals: int,
        requests: PlanningRequests,
        holds: HoldService,
        verbs: Verbs | None = None,
        paces: Mapping[str, Callable[[], float | None]] | None = None,
        tenders: Tenders | None = None,
        wall_clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param world: the running world of a name, or the only one; raises NotFound.
        :param open_goals: maximum of open goals.
        :param verbs: of sentences; default: those that ship with Macta.
        :param paces: by world, its seconds per wall-clock second now, None: as fast as possible; default: 1.
        :param tenders: None: robots do not bid for goals.
        :param wall_clock: what times of day in sentences are resolved by, in the machine's time zone.
        """
        self._database = core.database
        self._events = core.events
        self._facts = core.facts
        self._knowledge_base = core.knowledge_base
        self._world = world
        self._clocks = clocks
        self._limits = limits
        self._requests = requests
        self._holds = holds
        self._open_goals = open_goals
        self._verbs = verbs or shipped_verbs()
        grammar()  # read now, so that the first sentence does not wait for it
        self._paces = paces or {}
        self._tenders = tenders
        self._wall_clock = wall_clock

    def submit(self, request: GoalRequest, *, actor: str, key: str | None = None) -> GoalRow:
        """Record a goal and have it planned. The same idempotency key returns the same goal again.

        :raises Invalid: if it is not understood or can never be achieved, naming the thing and the choices.
        :raises Conflict: if the present world contradicts it, likewise; nothing is recorded then.
        :raises Busy: if too many goals are open.
        """
        world = self._world(request.world)
        self._limits.check(request.planning)
        goal_id = new_id("goal") if key is None else f"goal-{hashlib.sha256(key.encode()).hexdigest()[:12]}"
        with self._database.write() as session:
            if key is not None:
                self._database.lock(session, goal_id)  # another process may have a request with the same key
                if (known := session.get(GoalRow, goal_id)) is not None:
                    return _same(known, request, world)
            refuse_removed(session, world.name)
            world = with_roles_in_force(session, world)
            self._refuse_too_many(session)
            facts = self._facts.facts(session, world.name)
            stated = self._stated(session, request, world, facts)
            if stated.holds:  # until the commit no mission begins that puts something there
                self._facts.lock(session, world.name)
            goals = stated.goals
            if request.allocation is Allocation.CONTRACT_NET and stated.constraints.has_optional_goals:
                raise Invalid(
                    "robots do not bid for optional goals; leave out worth, or allocation",
                    code="optional-goals-not-tendered",
                )
            _refuse(self._issues(session, stated, world, facts), request.text or "")
            deadline_s = self._deadline_s(world.name, request.deadline_s, stated.due)
            later_s = request.not_before_s
            if later_s is not None and deadline_s is not None and deadline_s <= later_s:
                raise Invalid(
                    f"the goal is not to be true for {later_s:g} s, and due in {deadline_s:g} s",
                    code="due-before-it-may-be",
                )
            row = GoalRow(
                id=goal_id,
                world=world.name,
                text=request.text or _words(goals, stated.holds),
                goal=[goal.model_dump(mode="json") for goal in goals],
                priority=request.priority,
                deadline_s=deadline_s,
                deadline_at_s=_after(self._clocks[world.name], deadline_s),
                terms={},
                auto_approve=request.auto_approve,
                recovery=_policy(request),
                allocation=request.allocation.value,
                limits=request.planning.to_json(),
                state=GoalState.SUBMITTED,
                reason="",
                attempts=0,
                created_by=actor,
            )
            session.add(row)
            if stated.holds:
                session.flush()
            holds = self._holds.begin(session, row, stated.holds, world, actor=actor)
            row.terms = _terms(
                request, stated, holds, not_before_at_s=_after(self._clocks[world.name], later_s)
            )
            if goals:
                self._requests.plan_goal(session, row, actor=actor)
            else:
                self._finish(session, row, stated.holds, actor=actor)
            return row

    def _finish(self, session: Session, goal: GoalRow, holds: Sequence[StatedHold], *, actor: str) -> None:
        """End a goal that only keeps places that are empty and facts that are true: there is nothing to plan."""
        kept = " and ".join(hold.words for hold in holds)
        reason = f"nothing to carry out; holds {kept}"
        self._events.append(session, GoalSubmitted(subject=goal.id, text=goal.text, actor=actor))
        finish_without_mission(session, self._events, goal, reason)

    def _issues(
        self, session: Session, stated: "_Stated", world: WorldFile, facts: Facts
    ) -> tuple[GoalIssue, ...]:
        """What stands against the goal in the present world, without notes."""
        constraints = stated.constraints.and_also(kept_by(stated.holds))
        base = self._knowledge_base
        of_goals = (
            check_request(stated.goals, constraints, world, facts, base)
            if stated.goals or not stated.holds
            else check_constraints(constraints, (), world, facts)
        )
        held = () if constraints.after else held_issues(stated.goals, stated.standing, world, facts)
        others = standing_conflicts(stated.holds, stated.standing, world)
        return (
            *self._unknown_missions(session, stated.constraints, world.name),
            *check_holds(stated.holds, world, facts, base, self._now()),
            *blocking((*held, *others, *of_goals)),
            *self._holds.issues(session, world, stated.holds),
        )

    def check(self, request: GoalRequest) -> Checked:
        """How `submit` would understand a goal in the present world. Nothing is recorded."""
        world = self._world(request.world)
        text = request.text or ""
        with self._database.read() as session:
            world = with_roles_in_force(session, world)
            facts = self._facts.facts(session, world.name)
            stated = self._understood(session, request, world, facts)
            if isinstance(stated, Clarification):
                return Checked(issue=stated, completions=completions(text, stated, world, facts, self._verbs))
            issue = next(iter(self._issues(session, stated, world, facts)), None)
            preferences = self._preferences(stated, world, facts) if issue is None else ()
        if issue is not None:
            issue = replace(issue, span=span_of(text, issue.thing))
        return Checked(
            goals=stated.goals,
            constraints=stated.constraints,
            deadline_s=self._deadline_s(world.name, None, stated.due),
            due=stated.due,
            readings=stated.readings,
            holds=[HoldPreview.of(hold, self._now()) for hold in stated.holds],
            preferences=preferences,
            issue=issue,
            completions=replacements(text, issue) if issue else (),
        )

    def _preferences(self, stated: "_Stated", world: WorldFile, facts: Facts) -> Sequence[CheckedPreference]:
        """The preferences, and which of them no plan can keep."""
        constraints = stated.constraints.and_also(kept_by(stated.holds))
        conflicts = preference_conflicts(stated.goals, constraints, world, facts, self._knowledge_base)
        return [
            CheckedPreference(preference=preference.words, cost_s=preference.cost_s, conflict=conflict)
            for preference, conflict in zip(constraints.preferences, conflicts, strict=True)
        ]

    def _open_missions(self, session: Session, world: str) -> Mapping[str, float]:
        """The world's open missions, each with the seconds until its expected end by the world's clock."""
        query = select(MissionRow).where(MissionRow.world == world, MissionRow.state.in_(OPEN))
        now_s = self._clocks[world].now_s()
        return {
            mission.id: mission.estimate_s
            + (0.0 if mission.started_at_s is None else mission.started_at_s - now_s)
            for mission in session.scalars(query.order_by(MissionRow.created_at, MissionRow.id))
        }

    def _unknown_missions(
        self, session: Session, constraints: Constraints, world: str
    ) -> tuple[GoalIssue, ...]:
        """The issues with missions that the goal comes after, and that are none of the world."""
        if not constraints.after:
            return ()
        query = select(MissionRow.id).where(MissionRow.world == world, MissionRow.id.in_(constraints.after))
        known = set(session.scalars(query))
        return tuple(
            unknown_name("mission", name, tuple(self._open_missions(session, world)))
            for name in constraints.after
            if name not in known
        )

    def _stated(self, session: Session, request: GoalRequest, world: WorldFile, facts: Facts) -> "_Stated":
        """What the request asks for.

        :raises Invalid: if its sentence is not understood, or states a second deadline.
        """
        stated = self._understood(session, request, world, facts)
        if isinstance(stated, Clarification):
            raise stated.refusal()
        if stated.due is not None and request.deadline_s is not None:
            raise Invalid(
                'the sentence states a deadline, and so does "deadline_s"; say one', code="two-deadlines"
            )
        return stated

    def _now(self) -> datetime:
        return datetime.fromtimestamp(self._wall_clock.epoch_s()).astimezone()

    def _understood(
        self, session: Session, request: GoalRequest, world: WorldFile, facts: Facts
    ) -> "_Stated | Clarification":
        """What the request asks for, chosen within the holds that stand, with the goals that its own holds need."""
        standing = standing_holds(session, world.name)
        held = kept_by_standing(standing)
        aims = cache(partial(open_aims, session, world.name))
        said = self._said(session, request, world, facts, beside=held, aims=aims)
        if isinstance(said, Clarification):
            return said
        within = said.constraints.and_also(held)
        emptying = goals_of_holds(said.holds, said.goals, world, facts, within=within, aims=aims)
        if isinstance(emptying, Clarification):
            return emptying
        return _Stated.of(said, *emptying, standing)

    def _said(
        self,
        session: Session,
        request: GoalRequest,
        world: WorldFile,
        facts: Facts,
        *,
        beside: Constraints,
        aims: Aims,
    ) -> Understood | Clarification:
        """What the request says.

        :param beside: what else limits its choices; `aims`: what other goals are to make true.
        """
        holds = tuple(request.holds)
        if request.text is None:
            return Understood(goals=tuple(request.goal or ()), constraints=request.constraints, holds=holds)
        stated = understand(
            request.text,
            world,
            facts,
            verbs=self._verbs,
            now=self._now(),
            missions=partial(self._open_missions, session, world.name),
            goals=partial(open_goals, session, world.name),
            aims=aims,
            beside=request.constraints.and_also(beside).and_also(kept_by(holds)),
        )
        if isinstance(stated, Clarification):
            return stated
        ordered = {constraints.stages for constraints in (stated.constraints, request.constraints)} - {()}
        if len(ordered) > 1:
            return Clarification(
                code="two-orders",
                detail='the sentence says an order with "then", and "stages" says another; say one',
                thing="then",
                span=span_of(request.text or "", "then"),
            )
        said, asked = stated.constraints, request.constraints
        if said.robots and asked.robots:  # those that both allow: roles are robots from now on
            said, asked = said.of_robots(world), asked.of_robots(world)
        return replace(
            stated,
            constraints=said.and_also(asked),
            holds=(*stated.holds, *holds),
        )

    def _deadline_s(self, world: str, requested_s: float | None, due: Due | None) -> float | None:
        """Seconds from now by the world's clock. A time of day is by the wall clock, at the world's present pace."""
        if due is None:
            return requested_s
        pace = self._paces[world]() if world in self._paces else 1.0
        return due.in_s if due.at is None else due.in_s * (1.0 if pace is None else pace)

    def _refuse_too_many(self, session: Session) -> None:
        count = (
            session.scalar(
                select(func.count()).select_from(GoalRow).where(GoalRow.state.in_(goal_lifecycle.OPEN))
            )
            or 0
        )
        if count >= self._open_goals:
            raise Busy(
                f"{count} goals are open, the limit (MACTA_OPEN_GOALS); cancel some, decide on their plans, or submit "
                "the goal again when missions have ended",
                code="too-many-goals",
            )

    def get(self, goal_id: str) -> GoalRow:
        with self._database.read() as session:
            row = session.get(GoalRow, goal_id)
        if row is None:
            raise unrecorded("goal", goal_id)
        return row

    def stop(self, goal_id: str, *, actor: str) -> GoalRow:
        """End planning with the best plan so far. Without effect once the goal is planned.

        :raises Conflict: if planning has not begun.
        """
        with self._database.write() as session:
            goal = lock_goal(session, goal_id)
            if goal.state in (GoalState.SUBMITTED, GoalState.WAITING):
                raise Conflict(f"goal {goal.id} is not being planned yet", code="not-planning")
            if goal.state == GoalState.PLANNING and not goal.stop_requested:
                goal.stop_requested = True
                self._events.append(session, GoalStopRequested(subject=goal.id, actor=actor))
            return goal

    def cancel(self, goal_id: str, *, actor: str, comment: str = "") -> GoalRow:
        """Withdraw a goal that no mission carries out yet. Its planning ends; its proposed plans expire.

        :raises Conflict: if a mission carries it out, or it has ended otherwise.
        """
        with self._database.write() as session:
            goal = lock_goal(session, goal_id)
            if goal.outcome == CANCELLED:
                return goal
            _refuse_begun(goal, joint_goal_of(session, goal))
            reason = f"cancelled: {comment}" if comment else "cancelled"
            goal_lifecycle.withdraw(goal, outcome=CANCELLED, reason=reason)
            goal.planning = None
            if self._tenders is not None:
                self._tenders.release(session, goal)
            close_plans(session, self._events, goal, PlanState.EXPIRED, "its goal was cancelled")
            self._events.append(session, GoalWithdrawn(subject=goal.id, actor=actor, reason=goal.reason))
            return goal

    def newest(
        self,
        *,
        world: str | None = None,
        state: str | None = None,
        limit: int = 100,
        after: str | None = None,
    ) -> tuple[Sequence[GoalRow], str | None]:
        with self._database.read() as session:
            return page(session, GoalRow, limit=limit, after=after, world=world, state=state)


def _refuse_begun(goal: GoalRow, joint: GoalRow | None) -> None:
    """:param joint: the goal that carries it out together with others."""
    if joint is not None and joint.state in goal_lifecycle.OPEN:
        then = "which ends all" if joint.created_by == STATED_BY else "then the goal"
        raise Conflict(
            f"goal {goal.id} is carried out together with others; cancel mission {joint.mission_id}, {then}",
            code="goal-committed",
        )
    if goal.state == GoalState.COMMITTED:
        raise Conflict(
            f"goal {goal.id} is being carried out; cancel mission {goal.mission_id}", code="goal-committed"
        )
    if goal.state not in goal_lifecycle.UNDECIDED:
        raise Conflict(f"goal {goal.id} is {goal.state}, it cannot be cancelled", code="goal-ended")


def _words(goals: Sequence[SymbolicFact], holds: Sequence[StatedHold]) -> str:
    """A request without a sentence in words."""
    return " and ".join((*map(str, goals), *(f"keep {hold.words}" for hold in holds)))


def _terms(
    request: GoalRequest, stated: _Stated, holds: Sequence[GoalHold], *, not_before_at_s: float | None
) -> dict[str, Any]:
    terms = GoalTerms(
        constraints=stated.constraints,
        requested=request.constraints,
        due=stated.due,
        readings=tuple(stated.readings),
        holds=tuple(holds),
        requested_holds=tuple(request.holds),
        emptying=stated.emptying,
        not_before_s=request.not_before_s,
        not_before_at_s=not_before_at_s,
    )
    return terms.model_dump(mode="json")


def _after(clock: Clock, span_s: float | None) -> float | None:
    return None if span_s is None else clock.now_s() + span_s


def _same(row: GoalRow, request: GoalRequest, world: WorldFile) -> GoalRow:
    """The goal that an idempotency key was used for, if the request is the same."""
    terms = GoalTerms.from_json(row.terms)
    goal = [fact.model_dump(mode="json") for fact in request.goal or ()]
    stated = row.goal[: len(row.goal) - len(terms.emptying)]
    same_wish = row.text == request.text if request.text is not None else stated == goal
    deadline_s = None if terms.due is not None else row.deadline_s
    same_terms = (
        terms.requested,
        terms.requested_holds,
        terms.not_before_s,
        row.priority,
        deadline_s,
        row.auto_approve,
        row.recovery,
        row.allocation,
        row.limits,
    ) == (
        request.constraints,
        tuple(request.holds),
        request.not_before_s,
        request.priority,
        request.deadline_s,
        request.auto_approve,
        _policy(request),
        request.allocation,
        request.planning.to_json(),
    )
    if row.world != world.name or not same_wish or not same_terms:
        raise Conflict("this idempotency key was used for another goal", code="idempotency-key-reused")
    return row


def _policy(request: GoalRequest) -> str:
    return policy_for(request.recovery, auto_approve=request.auto_approve).value


def _refuse(issues: Sequence[GoalIssue], text: str) -> None:
    if not issues:
        return
    detail = "; ".join(issue.detail for issue in issues)
    error = Conflict if all(issue.kind == "conflict" for issue in issues) else Invalid
    first = issues[0]
    raise error(
        detail,
        code=first.code,
        choices=first.choices,
        constraints=first.constraints,
        thing=first.thing,
        span=span_of(text, first.thing),
    )
