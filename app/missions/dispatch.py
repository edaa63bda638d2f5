"""Dispatch: records the scripts of a mission's plan; the agent models deliver them from there."""

from collections.abc import Collection, Mapping, Sequence

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import MissionDispatching
from app.domain.goal_language.terms import GoalTerms
from app.domain.lifecycles import mission as mission_lifecycle
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.script import Delivery, script_id
from app.domain.mission_organiser import Library, OrganiserFailure, organise
from app.store import GoalRow, MissionRow, ScriptRow
from planner import Senses
from robots.wire import BehaviourScript


class ScriptDispatcher:
    """Turns the plan that a mission is to carry out now into scripts."""

    def __init__(
        self,
        core: Core,
        *,
        library: Library,
        repertoires: Mapping[str, Mapping[str, Sequence[str]]],
        senses: Mapping[str, Senses] | None = None,
        clearing: Mapping[str, Collection[str]] | None = None,
        delegating: Mapping[str, Collection[str]] | None = None,
    ) -> None:
        """:param repertoires: by world and robot, the packet tags the robot can carry out.
        :param senses: by world, what robots sense, of those that do not sense all; None: all do.
        :param clearing: by world, the robots that clear each other; None: none do.
        :param delegating: by world, the robots that put legs to each other if that is granted; None: none do.
        """
        self._core = core
        self._library = library
        self._repertoires = repertoires
        self._senses = senses
        self._clearing = clearing
        self._delegating = delegating

    def dispatch(self, session: Session, mission: MissionRow, now_s: float, *, answer_s: float) -> str:
        """Record the scripts for delivery; returns why they cannot be made, empty if they can.

        :param now_s: the world's clock.
        :param answer_s: world seconds that an answer from a robot may take by its radio.
        """
        net = self._core.plan_nets.of(session, mission.plan_id)
        organised = organise(
            net,
            self._library,
            self._repertoires[mission.world],
            mission.id,
            self._core.knowledge_base,
            facts=self._core.facts.facts(session, mission.world),
            answer_s=answer_s,
            script_ids=lambda robot: script_id(mission.id, robot, mission.revision),
            senses=None if self._senses is None else self._senses[mission.world],
            clearing=() if self._clearing is None else self._clearing[mission.world],
            not_before_at_s=_not_before_at_s(session, mission),
            delegating=self._delegating[mission.world] if mission.delegate and self._delegating else (),
        )
        if isinstance(organised, OrganiserFailure):
            return organised.reason
        for script in organised.scripts:
            newest = script.model_copy(update={"revision": mission.revision})
            session.add(_script_row(newest, mission.plan_id, now_s))
        mission_lifecycle.dispatch(mission)
        if mission.revision > 1:
            mission.revised_at_s = now_s
            begun_s = now_s if mission.started_at_s is None else mission.started_at_s
            mission.estimate_s = max(now_s - begun_s + net.makespan_s, mission.original_estimate_s)
        mission.asked_at = None
        mission.enquire_at_s = now_s + net.makespan_s + mission.margin_s
        self._core.events.append(
            session,
            MissionDispatching(
                subject=mission.id,
                plan=mission.plan_id,
                revision=mission.revision,
                robots=tuple(script.robot for script in organised.scripts),
                state=MissionState(mission.state),
            ),
        )
        return ""


def _not_before_at_s(session: Session, mission: MissionRow) -> float | None:
    """When the mission's goal may become true at the earliest, by the world's clock."""
    return GoalTerms.from_json(session.get_one(GoalRow, mission.goal_id).terms).not_before_at_s


def _script_row(script: BehaviourScript, plan_id: str, now_s: float) -> ScriptRow:
    return ScriptRow(
        id=script.id,
        mission_id=script.mission_id,
        plan_id=plan_id,
        robot=script.robot,
        body=script.model_dump(mode="json"),
        delivery=Delivery.PENDING,
        packets={},
        perceived=[],
        given_at_s=now_s,
    )
