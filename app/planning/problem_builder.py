"""Builds a goal's current planning problem: beliefs, reservations, holds, learned durations, priority and deadline."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any

from sqlalchemy import or_, select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.durations import PRIOR_SAMPLES, Durations, Kind
from app.domain.errors import Conflict
from app.domain.goal_language.berth_choice import assign_berths
from app.domain.goal_language.check import blocking, check_request
from app.domain.goal_language.conflict_set import ConstraintConflict
from app.domain.goal_language.constraints import (
    NOTHING_WITHHELD,
    UNCONSTRAINED,
    AppliedConstraints,
    Constraints,
    withheld_by,
)
from app.domain.goal_language.issues import conflict_in
from app.domain.goal_language.terms import GoalTerms
from app.domain.goal_language.words import joined
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.recovery import goals_beside
from app.domain.plan_document import PlanBody
from app.domain.plan_edits import Pins, PlanEdit, applied, pins_of
from app.domain.world_model import (
    Facts,
    Reservation,
    broken_support,
    initial_spots,
    objects_of,
    planning_problem,
    spot_of,
    union_of,
)
from app.domain.world_model.beliefs import CAN
from app.domain.world_model.numbers import BATTERY
from app.domain.world_model.senses import Perceives
from app.domain.world_model.vocabulary import planner_fact
from app.planning.pool.withheld import Withheld, is_ability
from app.store import GoalRow, MissionRow, PlanRow
from app.store.durations import learned_durations
from app.store.editions import WorldDirectory
from app.store.records import withdrawn_robot_reasons
from app.store.reservations import all_reserved
from app.store.roles import with_roles_in_force, withheld_tags
from app.store.standing_holds import standing_holds
from app.store.world_summary import summary_of
from planner import Fact, Numbers, PlanNet, PlanningProblem, Spread, Spreads, scale_term
from planner.explanation.conflict import Restriction
from planner.problem.choices import as_chosen_by, with_goals_of, without_each_preference
from robots.clock import Clock
from robots.wire import SymbolicFact
from robots.world import RoleSpec, WorldFile

Points = Callable[[str], Mapping[str, tuple[float, float]]]
"""By world, the last reported position of each robot, (x, y) in metres; default: the start in the world's file."""
UnavailableRobots = Callable[[str], Mapping[str, str]]
"""By world, the robots that are not recruited now, each with the reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalProblem:
    """A goal's planning problem, and what it was built from.

    :param withheld: what it leaves out.
    :param refusal: why the goal is impossible in the present world; empty if it is possible.
    :param conflict: the constraints that make it so, which the refusal names; None if none do.
    :param factors: factors on durations, by action and team size.
    :param constraints: on its plans, with what holds keep.
    :param releases: the world's count of releases when the problem was built.
    :param roles: what robots can but are not recruited for by their roles, with why not, in words.
    :param joined: those of its goals that the goal's mission carries out, or is to carry out, for other goals.
    :param built_at_s: when, by the world's clock; deadlines count from then.
    """

    problem: PlanningProblem
    withheld: Withheld
    refusal: str
    factors: Mapping[Kind, float]
    world_version: int
    releases: int
    constraints: AppliedConstraints = NOTHING_WITHHELD
    conflict: ConstraintConflict | None = None
    roles: Mapping[Fact, str] = field(default_factory=dict)
    joined: Collection[Fact] = ()
    built_at_s: float = 0.0

    def without(self, robots: Collection[str]) -> "GoalProblem":
        """The same problem without these robots, which are not waited for either."""
        return replace(self, withheld=self.withheld.without(robots))


@dataclass(frozen=True, slots=True, kw_only=True)
class CurrentProblem:
    """A plan-net and its goal's current problem.

    :param is_current: the plan is open to decision and its conditions hold. The problem then leaves out what other
        missions have reserved; otherwise reservations are ignored.
    :param roles: what robots can but are not recruited for by their roles, with why not, in words.
    """

    goal: GoalRow
    plan_net: PlanNet
    problem: PlanningProblem
    is_current: bool
    world_version: int
    roles: Mapping[Fact, str] = field(default_factory=dict)


class ProblemBuilder:
    """Builds planning problems from the record."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        clocks: Mapping[str, Clock],
        points: Points,
        unavailable: UnavailableRobots,
        low_battery: float = 0.0,
        find: Callable[[str], None] = lambda world: None,
        perceives: Perceives | None = None,
    ) -> None:
        """
        :param clocks: the worlds' clocks by the world's name.
        :param low_battery: a robot whose battery is known to hold less, 0 to 1, is not recruited.
        :param perceives: what robots sense by their sensors that do not say what they sense; None: all.
        :param find: looks again for a world of that name, which another process may just have added.
        """
        self._find = find
        self._facts = core.facts
        self._numbers = core.facts.numbers
        self._reservations = core.reservations
        self._knowledge_base = core.knowledge_base
        self._worlds = worlds
        self._clocks = clocks
        self._points = points
        self._unavailable = unavailable
        self._low_battery = low_battery
        self._perceives = perceives

    def build(
        self,
        session: Session,
        goal: GoalRow,
        *,
        constraints: Constraints | None = None,
        joining: Sequence[str] = (),
    ) -> GoalProblem:
        """The goal's current problem; its plan may use what the goal's own mission has reserved.

        It is for the goals, too, that this mission carries out beside its own, or is asked to.

        :param constraints: in place of the goal's.
        :param joining: further goals that the mission may be asked to carry out, by id.
        :raises Conflict: if its world does not run.
        """
        self._find(goal.world)
        if goal.world not in self._worlds:
            raise Conflict(
                f"world {goal.world} is not running in this service; start it with --world",
                code="world-not-running",
            )
        summary = summary_of(session, goal.world)
        if summary.edition > self._worlds.edition(goal.world).number:
            self._worlds.read(session)
        world = self._worlds[goal.world]
        facts = self._facts.facts(session, goal.world)
        held = [
            one
            for one in self._reservations.of_world(session, goal.world)
            if one.mission_id != goal.mission_id
        ]
        reserved = all_reserved(held)
        holds = standing_holds(session, goal.world)
        if constraints is None:
            constraints = GoalTerms.from_json(goal.terms).constraints
        numbers = self._numbers.for_planner(session, goal.world)
        played = with_roles_in_force(session, world)
        own, constraints = constraints.of_goals(_facts_of(goal), played)
        stated = (*own, *(fact for fact in _facts_beside(session, goal, played, joining) if fact not in own))
        unachieved = constraints.without_achieved(stated, played)
        applied = unachieved.in_world(played, numbers)
        required = {str(hold): hold.required_of(stated, played) for hold in holds}
        within = applied.within(required.values())
        has_begun = goal.mission_id is not None
        forbidden = [hold.forbidden_to(stated, played, facts, has_begun=has_begun) for hold in holds]
        places = unachieved.kept_off(played) | within.closed
        kept_off = union_of([reserved, Reservation(locations=places)])
        wanted = _with_chosen_berths(session, goal, stated, world, facts, kept_off)
        objects = objects_of(world)
        is_known = all(name in objects for fact in wanted for name in fact.args)
        goals = tuple(planner_fact(fact, self._knowledge_base, objects) for fact in wanted if is_known)
        facts = self._facts.counting_for(session, goal.world, goals, since_s=_begun_s(session, goal))
        joined_facts = goals[len(own) :]
        stages = constraints.stages_of(goals) if is_known else {}
        values = constraints.values_of(goals) if is_known else {}
        if values and goal.mission_id is not None:  # what its plan has left out is not taken up again
            goals = self._planned_goals(session, goal, goals)
            values = {}
        facts |= self._knowledge_base.compared(numbers)
        unavailable = self._unavailable_robots(session, goal.world, numbers)
        limited = withheld_tags(session, world)
        roles = {
            Fact(CAN, (robot, tag)): f"{robot} plays {role.name}, which is not recruited for {tag}"
            for robot, (role, tags) in limited.items()
            for tag in tags
        }
        learned = learned_durations(session, goal.world)
        factors = factors_of(learned)
        permitted = within.applied_to(facts)
        able = frozenset(
            fact for fact in permitted if not is_ability(fact, of=unavailable) and fact not in roles
        )
        problem = planning_problem(
            world,
            able,
            goals,
            spots=self._spots(world),
            reserved=reserved,
            knowledge_base=self._knowledge_base,
            perceives=self._perceives,
            is_held=has_begun,
        )
        problem = replace(
            problem,
            stages=stages,
            numbers=numbers,
            spreads=spreads_of(learned),
            values=values,
            preferences=constraints.preferences_in(played, permitted, numbers),
        )
        built_at_s = self._clocks[goal.world].now_s()
        issues = blocking(check_request(stated, constraints, played, facts, self._knowledge_base))
        return GoalProblem(
            problem=_urgent(_scaled(problem, factors), goal, built_at_s, others=joined_facts),
            withheld=Withheld(
                whole=replace(problem, facts=_with_releases(applied, reserved).applied_to(facts)),
                missions={str(one): one.reservation for one in held if is_known},
                robots={**_as_roles(limited), **unavailable} if is_known else {},
                tags={robot: tags for robot, (_, tags) in limited.items() if robot not in unavailable},
                holds={hold: one for hold, one in required.items() if one} if is_known else {},
            ),
            refusal="; ".join(issue.detail for issue in issues),
            factors=factors,
            world_version=self._facts.version(session, goal.world),
            releases=summary.releases,
            constraints=applied.within(forbidden),
            conflict=conflict_in(issues),
            roles=roles,
            joined=joined_facts,
            built_at_s=built_at_s,
        )

    def current(self, session: Session, plan: PlanRow, *, with_preferences: bool = False) -> CurrentProblem:
        """The plan's plan-net and its goal's current problem.

        :param with_preferences: the problem has the goal's preferences; else what the plan keeps of them is required.
        :raises Conflict: if its world does not run.
        """
        goal = session.get_one(GoalRow, plan.goal_id)
        built = self.build(session, goal)
        body = PlanBody.model_validate(plan.body)
        net = body.to_plan_net(self._knowledge_base)
        is_current = plan.state == PlanState.PROPOSED and not broken_support(
            net, self._facts.supporting(session, plan.world)
        )
        chosen = with_goals_of if with_preferences else as_chosen_by
        problem = built.problem if is_current else built.withheld.whole
        # The mission may have been asked to carry out other goals, too, since the plan was made.
        goals = tuple(fact for fact in problem.goals if fact not in built.joined or fact in net.goals)
        return CurrentProblem(
            goal=goal,
            plan_net=net,
            problem=applied(
                body.edits,
                chosen(net, replace(problem, goals=goals)),
                self._knowledge_base,
                now_s=built.built_at_s,
            ),
            is_current=is_current,
            world_version=built.world_version,
            roles=built.roles if is_current else {},
        )

    def pins(
        self, edits: Sequence[PlanEdit], plan_net: PlanNet, problem: PlanningProblem, *, world: str
    ) -> Pins:
        """What operators' edits of a plan pin, now.

        :param problem: the one that the plan-net solves, with what is pinned already.
        :raises Invalid: if an edit cannot be meant of this plan.
        """
        return pins_of(
            edits,
            plan_net,
            problem,
            self._knowledge_base,
            world=self._worlds[world],
            now_s=self._clocks[world].now_s(),
        )

    def pinned(self, built: GoalProblem, edits: Pins) -> GoalProblem:
        """The problem whose plans keep to operators' edits."""
        now_s = built.built_at_s
        return replace(built, problem=applied(edits, built.problem, self._knowledge_base, now_s=now_s))

    def restrictions(
        self, session: Session, goal: GoalRow, built: GoalProblem
    ) -> tuple[PlanningProblem, tuple[Restriction, ...]] | None:
        """The goal's problem without its constraints on robots and places, and each of these as the facts that it
        withholds; None if there are none. The berths that were chosen for the goal stay.

        :param built: the goal's problem.
        """
        constraints = GoalTerms.from_json(goal.terms).constraints
        if not constraints.parts:
            return None
        world = with_roles_in_force(session, self._worlds[goal.world])
        parts = constraints.without_achieved(_facts_of(goal), world).parts
        free = self.build(session, goal, constraints=constraints.beside_parts).problem
        stated = built.problem
        problem = replace(
            free,
            goals=stated.goals,
            stages=stated.stages,
            values=stated.values,
            deadlines_s=stated.deadlines_s,
            not_before_s=stated.not_before_s,
            priorities=stated.priorities,
            preferences=(),
        )
        numbers = self._numbers.for_planner(session, goal.world)
        return problem, tuple(
            Restriction(words=part.words[0], withheld=withheld_by(part, world, free.facts, numbers))
            for part in parts
        )

    def without_each_constraint(
        self, session: Session, goal: GoalRow, net: PlanNet, *, at_most: int
    ) -> Mapping[str, PlanningProblem]:
        """For each of the goal's constraints, and each preference that its plan keeps, the problem without it.

        By the constraint in words.

        :param at_most: so many of them, the first ones.
        """
        constraints = GoalTerms.from_json(goal.terms).constraints
        required = {
            words: as_chosen_by(net, self.build(session, goal, constraints=others).problem)
            for words, others in islice(constraints.without_each().items(), at_most)
        }
        left = at_most - len(required)
        if not constraints.preferences or not left:
            return required
        return {
            **required,
            **dict(islice(without_each_preference(net, self.build(session, goal).problem), left)),
        }

    def _planned_goals(self, session: Session, goal: GoalRow, goals: tuple[Fact, ...]) -> tuple[Fact, ...]:
        """Those of the goals that the plan of the goal's mission achieves."""
        plan = session.get_one(PlanRow, session.get_one(MissionRow, goal.mission_id).plan_id)
        net = PlanBody.model_validate(plan.body).to_plan_net(self._knowledge_base)
        return tuple(one for one in goals if one in net.goals)

    def _unavailable_robots(self, session: Session, world: str, numbers: Numbers) -> Mapping[str, str]:
        """The robots that are not recruited now, each with the reason."""
        return {
            **self._resting(numbers),
            **self._unavailable(world),
            **withdrawn_robot_reasons(session, world),
        }

    def _spots(self, world: WorldFile) -> Mapping[str, tuple[float, float]]:
        """Where things are: the robots where they have last reported to be."""
        reported = {spot_of(robot): point for robot, point in self._points(world.name).items()}
        return {**initial_spots(world), **reported}

    def _resting(self, numbers: Numbers) -> Mapping[str, str]:
        """The robots whose battery is known to be too low, though they may be silent now."""
        return {
            args[0]: f"which rests, its battery at {level:.0%}"
            for (quantity, args), level in numbers.items()
            if quantity == BATTERY and level < self._low_battery
        }


def _urgent(
    problem: PlanningProblem, goal: GoalRow, now_s: float, *, others: Collection[Fact]
) -> PlanningProblem:
    """The problem with the goal's priority and the times left until it may be true and until its deadline.

    :param others: facts of other goals, which have no such times.
    """
    own = [fact for fact in problem.goals if fact not in others]
    not_before_at_s = GoalTerms.from_json(goal.terms).not_before_at_s
    if not_before_at_s is not None and not_before_at_s > now_s:
        later_s = dict.fromkeys(own, not_before_at_s - now_s)
        problem = replace(problem, not_before_s=later_s)
    priorities: dict[Fact, int] = dict.fromkeys(problem.goals, goal.priority)
    if goal.deadline_at_s is None:
        return replace(problem, priorities=priorities)
    left_s = goal.deadline_at_s - now_s
    return replace(problem, priorities=priorities, deadlines_s=dict.fromkeys(own, left_s))


def _facts_of(goal: GoalRow) -> list[SymbolicFact]:
    return [SymbolicFact.model_validate(fact) for fact in goal.goal]


def _facts_beside(
    session: Session, goal: GoalRow, world: WorldFile, joining: Sequence[str]
) -> Sequence[SymbolicFact]:
    """What the goal's mission carries out, or is asked to, for other goals, and for those that are joining."""
    mission = None if goal.mission_id is None else session.get_one(MissionRow, goal.mission_id)
    ids = (*(() if mission is None else goals_beside(mission)), *joining)
    rows = {row.id: row for row in session.scalars(select(GoalRow).where(GoalRow.id.in_(ids)))} if ids else {}
    stated, _ = UNCONSTRAINED.of_goals(
        [fact for one in ids if one in rows for fact in _facts_of(rows[one])], world
    )
    return stated


def _as_roles(limited: Mapping[str, tuple[RoleSpec, frozenset[str]]]) -> Mapping[str, str]:
    """The robots that are not recruited for all that they can, each with why, in words."""
    return {
        robot: f"which plays {role.name} and is not recruited for {joined(sorted(tags), last='and')}"
        for robot, (role, tags) in limited.items()
    }


def _begun_s(session: Session, goal: GoalRow) -> float | None:
    """When the goal's mission began work; None if it has none or has not begun."""
    mission = None if goal.mission_id is None else session.get_one(MissionRow, goal.mission_id)
    return None if mission is None else mission.started_at_s


def factors_of(learned: Durations) -> Mapping[Kind, float]:
    """The factors on the durations of each action and team size."""
    return {kind: round(known.factor, 3) for kind, known in learned.items()}


def spreads_of(learned: Durations) -> Spreads:
    """How far the durations of each action and team size vary."""
    return {
        kind: Spread(relative=round(known.relative_spread, 4), observations=known.samples + PRIOR_SAMPLES)
        for kind, known in learned.items()
    }


def _scaled(problem: PlanningProblem, factors: Mapping[Kind, float]) -> PlanningProblem:
    scales = {scale_term(*kind): factor for kind, factor in factors.items()}
    return replace(problem, functions={**problem.functions, **scales})


def _with_releases(applied: AppliedConstraints, reserved: Reservation) -> AppliedConstraints:
    """The constraints while missions run: robots that must not act are moved off by the missions that use them."""
    return applied.model_copy(update={"excluded": applied.excluded - reserved.robots, "words": ()})


def _with_chosen_berths(
    session: Session,
    goal: GoalRow,
    wanted: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    reserved: Reservation,
) -> Sequence[SymbolicFact]:
    """The goal with a berth for each location that has several.

    The berths of its last plan are kept unless a mission has reserved them; otherwise berths that are neither reserved
    nor used by another open plan are preferred.
    """
    if all(len(row) == 1 for row in world.places_by_location.values()):
        return wanted
    own, others = _target_locations(session, goal)
    return assign_berths(
        wanted, world, facts, preferred=own - reserved.locations, avoid=others | reserved.locations
    )


def _target_locations(session: Session, goal: GoalRow) -> tuple[frozenset[str], frozenset[str]]:
    """The locations that the goal's last plan brings things to, and those of other goals' open plans."""
    query = select(PlanRow.id, PlanRow.goal_id, PlanRow.body["goals"]).where(
        PlanRow.world == goal.world, or_(PlanRow.id == goal.plan_id, PlanRow.state == PlanState.PROPOSED)
    )
    plans = [(plan, of, _locations(facts)) for plan, of, facts in session.execute(query)]
    own = frozenset[str]().union(*(locations for plan, _, locations in plans if plan == goal.plan_id))
    others = frozenset[str]().union(*(locations for _, of, locations in plans if of != goal.id))
    return own, others


def _locations(facts: Iterable[Mapping[str, Any]]) -> frozenset[str]:
    return frozenset(fact["args"][-1] for fact in facts if fact["args"])
