"""Tells a world's simulation of the robots that it does not simulate: where they are, and what they have moved.

Without it a simulated robot would drive through a foreign one, and never sense what that has brought.
"""

from collections.abc import Mapping
from math import dist

from sqlalchemy import select

from app.agents.robot_board import RobotBoard
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.world_model.beliefs import OBJECT_POSITION
from app.store import FactRow, WorldRow
from app.store.facts import source_of
from robots.wire import ForeignState, MovedSample
from robots.world import WorldFile

MIN_INTERVAL_S = 0.1
"""Wall-clock seconds between two messages."""
READ_INTERVAL_S = 0.5
"""Wall-clock seconds between two looks at the facts."""
MAX_INTERVAL_S = 2.0
"""After which the state is sent again, unchanged: a message may be lost."""
MOVED_M = 0.01
TURNED_RAD = 0.02

PoseTuple = tuple[float, float, float]


class ForeignStates:
    """What one world is told, and when. To be called from one thread."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        board: RobotBoard,
        world: str,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        self._core = core
        self._worlds = worlds
        self._board = board
        self._world = world
        self._wall = wall
        self._sent: ForeignState | None = None
        self._sent_s = float("-inf")
        self._read_s = float("-inf")
        self._version = 0
        self._samples: tuple[MovedSample, ...] = ()

    def due(self) -> ForeignState | None:
        """The state, if the world has both kinds of robots and it is to be sent now; it then counts as sent."""
        file = self._worlds.get(self._world)
        now_s = self._wall.monotonic_s()
        if (
            file is None
            or len(file.simulated) in (0, len(file.robots))
            or now_s - self._sent_s < MIN_INTERVAL_S
        ):
            return None
        foreign = {one.name for one in file.robots if one.external}
        if now_s - self._read_s >= READ_INTERVAL_S:
            self._version, self._samples = self._moved_by(foreign)
            self._read_s = now_s
        state = ForeignState(version=self._version, robots=self._poses(foreign), samples=self._samples)
        if now_s - self._sent_s < MAX_INTERVAL_S and self._is_told(state):
            return None
        self._sent = state
        self._sent_s = now_s
        return state

    def _poses(self, foreign: set[str]) -> dict[str, PoseTuple]:
        views = self._board.views(self._world)
        told = {name: views[name].telemetry for name in sorted(foreign) if name in views}
        return {name: (one.x_m, one.y_m, one.heading_rad) for name, one in told.items() if one is not None}

    def _moved_by(self, foreign: set[str]) -> tuple[int, tuple[MovedSample, ...]]:
        """The world's version, and the samples that these robots were the last to move."""
        with self._core.database.read() as session:
            row = session.get(WorldRow, self._world)
            query = select(FactRow).where(
                FactRow.world == self._world,
                FactRow.predicate == OBJECT_POSITION,
                FactRow.source.in_({source_of(name) for name in foreign}),
            )
            moved = tuple(
                MovedSample(sample=fact.args[0], place=fact.args[2], at_s=fact.at_s)
                for fact in session.scalars(query.order_by(FactRow.atom))
            )
            return (0 if row is None else row.version), moved

    def _is_told(self, state: ForeignState) -> bool:
        sent = self._sent
        if sent is None or (sent.samples, sent.robots.keys()) != (state.samples, state.robots.keys()):
            return False
        return all(_is_there(pose, sent.robots[name]) for name, pose in state.robots.items())


def _is_there(pose: PoseTuple, told: PoseTuple) -> bool:
    return dist(pose[:2], told[:2]) < MOVED_M and abs(pose[2] - told[2]) < TURNED_RAD
