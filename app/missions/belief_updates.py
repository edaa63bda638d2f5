"""What robots' reports make of the facts: effects of actions that ended, percepts of robots that stopped before.

What a report says of something that newer is known of is late, and not believed any more.
"""

from collections.abc import Sequence

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import FactsReconciled, LateReport
from app.domain.world_model import Change, Facts, apply_action, reconcile_report
from app.domain.world_model.timeliness import Subject, newer_subjects, without_outdated
from app.domain.world_model.vocabulary import symbolic
from app.missions.clearance import has_ended, scripts_of
from app.store import MissionRow, ScriptRow
from app.store.facts import source_of
from app.workflows.mission_wakeups import wake_missions
from planner import Fact, PlanNet, PlanNetAction
from robots.wire import ScriptReport, ScriptState, SymbolicFact

BROKEN_OFF = (ScriptState.FAILED, ScriptState.CANCELLED)


class BeliefUpdates:
    """Changes the facts inside the caller's transaction; other missions look again at what they count on."""

    def __init__(self, core: Core) -> None:
        self._core, self._facts, self._events = core, core.facts, core.events

    def came_true(
        self, session: Session, action_id: str, at_s: float, script: ScriptRow, mission: MissionRow
    ) -> None:
        """An action has ended. What is known to have been done after it stands, for reports overtake each other."""
        net = self._core.plan_nets.of(session, script.plan_id)
        scripts = scripts_of(session, mission, script.plan_id)
        self._facts.lock(session, mission.world)
        before = self._facts.facts(session, mission.world)
        after = apply_action(before, net.action(action_id))
        touched = after ^ before
        for one in _done_since(net, action_id, scripts):
            after = apply_action(after, one)
        change = Change(add=(after - before) & touched, remove=(before - after) & touched)
        # NOTE: a robot that was stopped has looked round since; what the others reported later is counted in already.
        going_on = [source_of(one.robot) for one in scripts if one.state not in BROKEN_OFF]
        newer = newer_subjects(self._facts.dated(session, mission.world), at_s, but=going_on)
        late = script.plan_id != mission.plan_id or script.abandoned
        self._change(session, mission, at_s, script.robot, before, change, newer, corrects=late)

    def reconcile(
        self, session: Session, report: ScriptReport, script: ScriptRow, mission: MissionRow
    ) -> None:
        """A script ended before its time: what the robot perceives stands, what it had begun does not count."""
        self._facts.lock(session, mission.world)
        facts = self._facts.facts(session, mission.world)
        change = reconcile_report(facts, script.robot, report.perceived, self._core.knowledge_base)
        newer = newer_subjects(self._facts.dated(session, mission.world), report.at_s)
        self._change(session, mission, report.at_s, script.robot, facts, change, newer, corrects=True)
        if change.notes:
            self._events.append(
                session, FactsReconciled(subject=mission.world, robot=script.robot, notes=change.notes)
            )

    def _change(
        self,
        session: Session,
        mission: MissionRow,
        at_s: float,
        robot: str,
        facts: Facts,
        change: Change,
        newer: frozenset[Subject],
        *,
        corrects: bool,
    ) -> None:
        kept = without_outdated(facts, change, newer)
        before = self._facts.version(session, mission.world)
        version = self._facts.change(
            session,
            mission.world,
            add=kept.add,
            remove=kept.remove,
            source=source_of(robot),
            at_s=at_s,
            corrects=corrects,
        )
        if passed_over := tuple(sorted(str(self._said(fact)) for fact in change.add - kept.add)):
            late = LateReport(subject=mission.world, robot=robot, at_s=at_s, passed_over=passed_over)
            self._events.append(session, late)
        if version != before and (corrects or passed_over):
            key = f"facts:{version}"
            wake_missions(session, self._core.workflows, mission.world, key, but=mission.id)

    def _said(self, fact: Fact) -> SymbolicFact:
        return symbolic(fact, self._core.knowledge_base)


def _done_since(net: PlanNet, action_id: str, scripts: Sequence[ScriptRow]) -> tuple[PlanNetAction, ...]:
    """What is known to have been done after the action, in order.

    Its report may come late: others went on with what it brought about, and theirs came before it.
    """
    begun_s = net.action(action_id).earliest_start_s
    later = [one for one in net.actions if one.earliest_start_s > begun_s and has_ended(scripts, one.id)]
    return tuple(sorted(later, key=lambda one: one.earliest_start_s))
