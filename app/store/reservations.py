"""Reservations of running missions: the robots, places and samples that new plans must not use."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from sqlalchemy import select
from sqlalchemy.orm import Session, load_only

from app.domain.lifecycles.mission import OPEN
from app.domain.world_model import Reservation, filled_by, named_in, needed_by, union_of
from app.store import MissionRow, ScriptRow
from app.store.plan_nets import PlanNets
from robots.wire import PacketState, ScriptState

CACHE_SIZE = 200
"""Plans whose needs are cached."""
_PROGRESS = load_only(ScriptRow.robot, ScriptRow.state, ScriptRow.packets)


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionReservation:
    """A running mission and what it still needs.

    :param filled: where it still puts a sample.
    """

    mission_id: str
    reservation: Reservation
    filled: frozenset[str] = frozenset()

    def __str__(self) -> str:
        return f"mission {self.mission_id}, which uses {', '.join(sorted(self.reservation.names))}"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Progress:
    """How far a plan is carried out.

    :param idle: the robots whose scripts have finished.
    :param done: action and robot, where the robot has done its part of the action.
    """

    idle: Collection[str]
    done: Collection[tuple[str, str]]

    @classmethod
    def of(cls, scripts: Iterable[ScriptRow]) -> Self:
        idle = set[str]()
        done = set[tuple[str, str]]()
        for script in scripts:
            if script.state == ScriptState.FINISHED:
                idle.add(script.robot)
            for packet, known in script.packets.items():
                if known["state"] == PacketState.FINISHED:
                    done.add((packet, script.robot))
        return cls(idle=idle, done=done)


@dataclass(frozen=True, slots=True, kw_only=True)
class _ActionNeeds:
    """What an action of a plan needs.

    :param filled: where it puts a sample.
    """

    robots: tuple[str, ...]
    needs: Reservation
    filled: frozenset[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Needs:
    """What a plan needs: names in its goals until the mission's end, those of an action until its robots are done."""

    goals: Reservation
    actions: Mapping[str, _ActionNeeds]

    def left(self, progress: _Progress) -> Reservation:
        """What is still needed."""
        return union_of([self.goals, *(action.needs for action in self._open(progress))])

    def filled(self, progress: _Progress) -> frozenset[str]:
        """Where a sample is still put."""
        return frozenset[str]().union(*(action.filled for action in self._open(progress)))

    def _open(self, progress: _Progress) -> Iterator[_ActionNeeds]:
        for name, action in self.actions.items():
            if any(r not in progress.idle and (name, r) not in progress.done for r in action.robots):
                yield action


class Reservations:
    """Reads from the database what missions still need, which shrinks as robots report progress.

    What a failed or stopped robot still needed stays reserved until the mission is recovered or ends.
    """

    def __init__(self, plan_nets: PlanNets) -> None:
        self._plan_nets = plan_nets
        self._needs: dict[str, _Needs] = {}

    def of_world(self, session: Session, world: str) -> Sequence[MissionReservation]:
        """The running missions of a world with what each still needs, oldest first."""
        query = (
            select(MissionRow)
            .where(MissionRow.world == world, MissionRow.state.in_(OPEN))
            .order_by(MissionRow.created_at, MissionRow.id)
        )
        missions = session.scalars(query).all()
        return [self._of_mission(session, mission) for mission in missions]

    def _of_mission(self, session: Session, mission: MissionRow) -> MissionReservation:
        # Without what the robots were given: it is long, and the plan's needs are known.
        query = (
            select(ScriptRow)
            .options(_PROGRESS)
            .where(ScriptRow.mission_id == mission.id, ScriptRow.plan_id == mission.plan_id)
        )
        needs = self._of_plan(session, mission.plan_id)
        progress = _Progress.of(session.scalars(query))
        return MissionReservation(
            mission_id=mission.id, reservation=needs.left(progress), filled=needs.filled(progress)
        )

    def of_scripts(self, session: Session, plan_id: str, scripts: Iterable[ScriptRow]) -> Reservation:
        """What a running mission still needs.

        :param scripts: all of the plan that it carries out now.
        """
        return self._of_plan(session, plan_id).left(_Progress.of(scripts))

    def _of_plan(self, session: Session, plan_id: str) -> _Needs:
        if plan_id not in self._needs:
            if len(self._needs) >= CACHE_SIZE:
                self._needs.clear()
            net = self._plan_nets.of(session, plan_id)
            self._needs[plan_id] = _Needs(
                goals=named_in(net.goals),
                actions={
                    action.id: _ActionNeeds(
                        robots=action.agents, needs=needed_by(action), filled=filled_by([action])
                    )
                    for action in net.actions
                },
            )
        return self._needs[plan_id]


def all_reserved(held: Iterable[MissionReservation]) -> Reservation:
    """Everything that some running mission still needs."""
    return union_of(one.reservation for one in held)
