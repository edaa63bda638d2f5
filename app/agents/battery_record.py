"""Robots' batteries as numeric facts: recorded from telemetry when they have moved far enough to matter."""

from collections.abc import Callable, Collection, Container, Mapping

from sqlalchemy.orm import Session

from app.agents.robot_board import RobotBoard
from app.core import Core
from app.domain.world_model.numbers import BATTERY
from app.store.facts import source_of
from robots.clock import Clock
from robots.wire import Telemetry

STEP = 0.05
"""How far a battery moves before it is recorded again (our choice)."""
LEAST_STEP = 0.005
"""Likewise if it has passed a number that it is compared with, so that a reading that trembles is written once."""


class BatteryRecord:
    """Records the batteries of one world's robots, all that are due in one transaction.

    What an operator has stated stands until the robot tells of its battery again.
    """

    def __init__(
        self,
        core: Core,
        *,
        world: str,
        board: RobotBoard,
        clock: Clock,
        low_battery: float,
        release: Callable[[Session, str], None],
        robots: Callable[[], Container[str]],
        bounds: Collection[float] = (),
    ) -> None:
        """
        :param clock: the world's.
        :param low_battery: a robot whose battery holds less is not recruited.
        :param release: has the world's waiting goals planned again, in the transaction.
        :param robots: the world's robots; doors, hatches and lifts have no battery.
        :param bounds: what else batteries are compared with; one that has passed such a level is recorded.
        """
        self._database = core.database
        self._numbers = core.facts.numbers
        self._is_known = BATTERY in core.knowledge_base.quantities
        self._world = world
        self._board = board
        self._clock = clock
        self._low_battery = low_battery
        self._release = release
        self._robots = robots
        compared = (one.number for one in core.knowledge_base.comparisons.values() if one.quantity == BATTERY)
        self._bounds = frozenset({low_battery, *bounds, *compared})
        self._seen: dict[str, Telemetry] = {}
        """By robot, the telemetry that was last compared with the record."""

    def record(self) -> None:
        """Record the batteries that robots have told of since the last call and that have moved."""
        views = self._board.views(self._world) if self._is_known else {}
        robots = self._robots()
        told = {
            name: view.telemetry
            for name, view in views.items()
            if view.telemetry is not None and name in robots
        }
        new = {name: said for name, said in told.items() if said is not self._seen.get(name)}
        if not new:
            return
        with self._database.read() as session:
            known = self._numbers.numbers(session, self._world)
        levels = {name: round(said.battery, 3) for name, said in new.items()}
        before = {name: known.get((BATTERY, (name,))) for name in levels}
        due = {name: level for name, level in levels.items() if self._is_due(before[name], level)}
        if due:
            self._write(due, {name: level or 0.0 for name, level in before.items()})
        self._seen = told

    def _write(self, due: Mapping[str, float], before: Mapping[str, float]) -> None:
        with self._database.write() as session:
            at_s = self._clock.now_s()
            for name, level in sorted(due.items()):
                source = source_of(name)
                self._numbers.set(session, self._world, {(BATTERY, (name,)): level}, source=source, at_s=at_s)
            if any(before[name] < self._low_battery <= level for name, level in due.items()):
                self._release(session, self._world)

    def _is_due(self, before: float | None, level: float) -> bool:
        if before is None:
            return True
        moved = round(abs(level - before), 3)
        passed = any((before < bound) != (level < bound) for bound in self._bounds)
        return moved >= STEP or (moved >= LEAST_STEP and passed)
