"""How robots' reports change the facts: effects of actions that ended, percepts of robots that stopped or moved.

A reported fact is not believed if newer facts about the same thing are known.
"""

from collections.abc import Iterable, Sequence

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import (
    FactsReconciled,
    LateReport,
    TeleoperationBegan,
    TeleoperationEnded,
    UpkeepReported,
)
from app.domain.world_model import Change, apply_action, belief_change, reconcile_report, told_by_events
from app.domain.world_model.beliefs import IN, OBJECT_POSITION, REACHES, ROBOT_POSITION
from app.domain.world_model.timeliness import Subject, newer_subjects, without_outdated
from app.domain.world_model.vocabulary import symbolic
from app.missions.clearance import action_has_ended
from app.missions.contradictions import disputed
from app.missions.delegation import as_done, done_by
from app.store import MissionRow, ScriptRow
from app.store.facts import WorldFacts, source_of
from app.workflows.mission_wakeups import wake_missions
from planner import Fact, PlanNet, PlanNetAction
from robots.wire import PacketState, ScriptReport, ScriptState, SymbolicFact, UpkeepReport

STOPPED = (ScriptState.FAILED, ScriptState.CANCELLED)
"""The states of a script whose robot has stopped before its end."""


class BeliefUpdates:
    """Changes the facts inside the caller's transaction, and wakes the missions that may depend on them."""

    def __init__(self, core: Core) -> None:
        self._facts = core.facts
        self._events = core.events
        self._workflows = core.workflows
        self._plan_nets = core.plan_nets
        self._knowledge_base = core.knowledge_base

    def apply_effects(
        self,
        session: Session,
        actions: Iterable[str],
        *,
        at_s: float,
        script: ScriptRow,
        mission: MissionRow,
        scripts: Sequence[ScriptRow],
    ) -> None:
        """Apply the effects of actions that have ended. Effects of later actions are kept: reports may overtake each
        other.

        :param at_s: when they were reported to have ended (world's clock).
        :param script: the reporting robot's.
        :param scripts: all of the same plan.
        """
        net = self._plan_nets.of(session, script.plan_id)
        world = self._facts.read_locked(session, mission.world)
        # The percepts of a stopped robot are newer; later actions of the other robots are applied again below.
        going_on = [source_of(one.robot) for one in scripts if one.state not in STOPPED]
        by = done_by(scripts)
        for action_id in actions:
            action = as_done(net.action(action_id), by)
            before = world.facts - self._knowledge_base.achieved_each_time(action.effects)
            after = apply_action(before, action)
            touched = after ^ before
            for later in _done_since(net, action_id, scripts):
                after = apply_action(after, as_done(later, by))
            add = _undisputed((after - before) & touched, mission, script)
            change = Change(add=add, remove=(before - after) & touched)
            self._believe(
                session,
                world,
                change,
                newer=newer_subjects(world.dated, at_s, but=going_on),
                mission=mission,
                robot=script.robot,
                at_s=at_s,
                corrects=script.plan_id != mission.plan_id or script.abandoned,
            )

    def reconcile(
        self, session: Session, report: ScriptReport, script: ScriptRow, mission: MissionRow
    ) -> None:
        """Apply the percepts of a robot whose script ended early; actions that it had begun have no effects."""
        world = self._facts.read_locked(session, mission.world)
        things = disputed(mission, script.plan_id)
        perceived = [one for one in report.perceived if one.predicate != IN or one.args[0] not in things]
        change = reconcile_report(world.facts, script.robot, perceived, self._knowledge_base)
        self._believe(
            session,
            world,
            change,
            newer=newer_subjects(world.dated, report.at_s),
            mission=mission,
            robot=script.robot,
            at_s=report.at_s,
            corrects=True,
        )
        if change.notes:
            self._events.append(
                session, FactsReconciled(subject=mission.world, robot=script.robot, notes=change.notes)
            )

    def note_events(
        self,
        session: Session,
        told: Sequence[SymbolicFact],
        *,
        at_s: float,
        script: ScriptRow,
        mission: MissionRow,
    ) -> None:
        """Apply the facts that the events of a robot's packet stand for."""
        world = self._facts.read_locked(session, mission.world)
        self._believe(
            session,
            world,
            told_by_events(world.facts, told, self._knowledge_base),
            newer=newer_subjects(world.dated, at_s),
            mission=mission,
            robot=script.robot,
            at_s=at_s,
            corrects=True,
        )

    def note_positions(
        self, session: Session, positions: Sequence[Fact], *, at_s: float, mission: MissionRow
    ) -> None:
        """Where robots of which another one reports stand; places that they do not reach are not believed."""
        world = self._facts.read_locked(session, mission.world)
        for fact in positions:
            robot, _, place = fact.args
            if Fact(REACHES, (robot, place)) in world.facts:
                self._believe(
                    session,
                    world,
                    belief_change(world.facts, [fact]),
                    newer=newer_subjects(world.dated, at_s),
                    mission=mission,
                    robot=robot,
                    at_s=at_s,
                    corrects=False,
                )

    def note_upkeep(self, session: Session, report: UpkeepReport, *, world: str, robot: str) -> None:
        """Record a robot's upkeep and apply its percepts, unless newer facts are known."""
        facts = self._facts.read_locked(session, world)
        last_placed_s = max(
            (
                one.at_s
                for one in facts.believed
                if one.fact.predicate == ROBOT_POSITION and one.fact.args[0] == robot
            ),
            default=0.0,
        )
        if report.at_s >= last_placed_s:
            before = facts.facts
            seen = reconcile_report(before, robot, report.perceived, self._knowledge_base)
            change = without_outdated(before, seen, newer_subjects(facts.dated, report.at_s))
            if facts.change(
                add=change.add, remove=change.remove, source=source_of(robot), at_s=report.at_s, corrects=True
            ):
                wake_missions(session, self._workflows, world)
        if (event := _upkeep_event(report, world=world, robot=robot)) is not None:
            self._events.append(session, event)

    def _believe(
        self,
        session: Session,
        world: WorldFacts,
        change: Change,
        *,
        newer: frozenset[Subject],
        mission: MissionRow,
        robot: str,
        at_s: float,
        corrects: bool,
    ) -> None:
        kept = without_outdated(world.facts, change, newer)
        changed = world.change(
            add=kept.add, remove=kept.remove, source=source_of(robot), at_s=at_s, corrects=corrects
        )
        passed_over = tuple(
            sorted(str(symbolic(fact, self._knowledge_base)) for fact in change.add - kept.add)
        )
        if passed_over:
            late = LateReport(subject=mission.world, robot=robot, at_s=at_s, passed_over=passed_over)
            self._events.append(session, late)
        if changed and (corrects or passed_over):
            wake_missions(session, self._workflows, mission.world, but=mission.id)


def _undisputed(facts: frozenset[Fact], mission: MissionRow, script: ScriptRow) -> frozenset[Fact]:
    """The facts without those that say where something is of which the plan's robots report contradictorily."""
    things = disputed(mission, script.plan_id)
    return frozenset(one for one in facts if one.predicate != OBJECT_POSITION or one.args[0] not in things)


def _upkeep_event(
    report: UpkeepReport, *, world: str, robot: str
) -> UpkeepReported | TeleoperationBegan | TeleoperationEnded | None:
    """The event of the report; None for progress reports of a robot that an operator drives."""
    if report.driver is None:
        return UpkeepReported(
            subject=robot,
            world=world,
            packet=report.tag,
            state=report.state,
            at_s=report.at_s,
            detail=report.detail,
        )
    if report.state is PacketState.RUNNING and report.detail:
        return None
    drive = TeleoperationBegan if report.state is PacketState.RUNNING else TeleoperationEnded
    return drive(
        subject=robot,
        world=world,
        driver=report.driver,
        packet=report.tag,
        at_s=report.at_s,
        detail=report.detail,
    )


def _done_since(net: PlanNet, action_id: str, scripts: Sequence[ScriptRow]) -> tuple[PlanNetAction, ...]:
    """The actions that started later and are known to have ended, in order."""
    begun_s = net.action(action_id).earliest_start_s
    later = [
        one for one in net.actions if one.earliest_start_s > begun_s and action_has_ended(scripts, one.id)
    ]
    return tuple(sorted(later, key=lambda one: one.earliest_start_s))
