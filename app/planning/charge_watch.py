"""Watches the batteries of idle robots that do not charge by themselves, and submits goals that charge them.

A robot with a home drives there by itself. Which robot goes first to a charger that several share is not known on
board: the service states "charge yard_1", a goal as any other.
"""

import logging
from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock, iso_utc
from app.domain.errors import Busy, Conflict, Invalid, NotFound
from app.domain.world_model.numbers import BATTERY
from app.planning.goal_service import GoalRequest, GoalService
from app.planning.hold_service import open_aims
from app.store import GoalRow, NumberRow
from app.store.editions import WorldDirectory
from app.store.known_empty import KnownEmpty
from app.store.records import withdrawn_robot_reasons
from app.store.reservations import all_reserved
from planner import KnowledgeBase
from robots.world import WorldFile

CHARGED = "charged"
"""The predicate of goals that charge a robot, which is their first argument."""
STATED_BY = "low_battery"
"""Who submits the goals of this module."""
MARGIN = 0.1
"""How far above the level that plans keep a battery its robot is to be charged: for the way to the charger, and for the
time that others charge there before it. Of 120 Wh it is two hours of waiting (our choice).
"""
AGAIN_AFTER_S = 600.0
"""Wall-clock seconds between the end or refusal of such a goal and the next one for the same robot, whether there was
no plan, it was withdrawn, or it ended and the battery is still low. Idle, a robot uses less than 1 % of 120 Wh
meanwhile (our choice).
"""

logger = logging.getLogger(__name__)


def charging_range(knowledge_base: KnowledgeBase, low_battery: float) -> tuple[float, float]:
    """Between which batteries, 0 to 1, a robot is to be charged: with less it takes on no script, with as much as the
    second or more there is time. (0, 0) if the knowledge base charges no robots.

    :param low_battery: a robot whose battery holds less is not recruited.
    """
    spec = knowledge_base.quantities.get(BATTERY)
    if spec is None or CHARGED not in knowledge_base.predicates:
        return 0.0, 0.0
    least = max(spec.kept[0] or 0.0, low_battery)
    return least, least + MARGIN


class ChargeWatch:
    """Submits a goal for each robot without a home that is idle, low on battery, and for which no such goal is open.

    All of that is read from the record, so that a process that starts, or takes the world over, goes on with it.
    """

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        goals: GoalService,
        low_battery: float,
        wall_clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param low_battery: a robot whose battery holds less, 0 to 1, is not recruited."""
        self._database = core.database
        self._numbers = core.facts.numbers
        self._reservations = core.reservations
        self._goals = goals
        self._least, self._enough = charging_range(core.knowledge_base, low_battery)
        self._wall_clock = wall_clock
        self._robots = worlds.each(_without_home)
        self._refused_s: dict[tuple[str, str], float] = {}
        """By world and robot, when a goal was refused, of which the record has nothing; by the monotonic clock."""
        self._none_due = KnownEmpty(core.database, NumberRow, clock=wall_clock)

    def follow(self, world: str) -> None:
        """Submit the goals that are due. Called often; reads after a change of numbers, else every few seconds."""
        if self._robots[world]:
            for robot in self._none_due.read(world, lambda: self._due(world)):
                self._submit(world, robot)

    def forget(self, world: str) -> None:
        """The world no longer runs."""
        self._none_due.forget(world)
        self._refused_s = {key: at_s for key, at_s in self._refused_s.items() if key[0] != world}

    def _due(self, world: str) -> Sequence[str]:
        """The robots for which a goal is to be submitted now."""
        with self._database.read() as session:
            numbers = self._numbers.numbers(session, world)
            levels = {name: numbers.get((BATTERY, (name,)), 1.0) for name in self._robots[world]}
            low = [name for name, level in levels.items() if self._least <= level < self._enough]
            if not low:
                return ()
            passed_over = {
                *all_reserved(self._reservations.of_world(session, world)).robots,
                *withdrawn_robot_reasons(session, world),
                *(fact.args[0] for fact in open_aims(session, world) if fact.predicate == CHARGED),
            }
            return [name for name in low if name not in passed_over and self._is_time(session, world, name)]

    def _is_time(self, session: Session, world: str, robot: str) -> bool:
        """Whether the last goal for the robot ended, or was refused, long enough ago; true without one."""
        refused_s = self._refused_s.get((world, robot))
        if refused_s is not None and self._wall_clock.monotonic_s() < refused_s + AGAIN_AFTER_S:
            return False
        submitted = select(GoalRow.updated_at).where(
            GoalRow.world == world, GoalRow.created_by == STATED_BY, GoalRow.text == _sentence(robot)
        )
        ended_at = session.scalar(submitted.order_by(GoalRow.created_at.desc(), GoalRow.id.desc()).limit(1))
        return ended_at is None or ended_at <= iso_utc(self._wall_clock.epoch_s() - AGAIN_AFTER_S)

    def _submit(self, world: str, robot: str) -> None:
        """Submit a goal that charges the robot. No operator decides on its plan: it moves none that a mission uses."""
        request = GoalRequest(world=world, text=_sentence(robot), auto_approve=True)
        try:
            self._goals.submit(request, actor=STATED_BY)
        except (Busy, Conflict, Invalid, NotFound) as refusal:
            logger.warning("no goal charges %s for now: %s", robot, refusal)
            self._refused_s[world, robot] = self._wall_clock.monotonic_s()


def _sentence(robot: str) -> str:
    return f"charge {robot}"


def _without_home(world: WorldFile) -> Sequence[str]:
    """The robots that are charged at shared chargers only, and that software of their own does not charge."""
    return [robot.name for robot in world.simulated if robot.home is None and world.chargers_of(robot)]
