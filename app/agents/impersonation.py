"""Notices who publishes in a robot's name: messages without its signature, and telemetry of two places at once.

Robots that were enrolled with a key sign; what is not signed by them is dropped. Without a key nothing is computed, and
only what contradicts itself is noticed: telemetry that goes to and fro between places that are too far apart. Who says
nothing but reports, or copies the robot's position, is not noticed.
"""

import json
import logging
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import dist
from pathlib import Path

from pydantic import ValidationError

from app.agents.robot_board import RobotBoard
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Invalid
from app.domain.events import RobotImpersonated
from app.domain.plausibility import SPEED_FACTOR
from app.store import Database
from app.store.event_log import EventLog
from app.store.tables import utc_now
from robots.link.mqtt.session import Publication
from robots.link.mqtt.signature import Accepted, SignatureCheck
from robots.link.mqtt.topics import Channel, ConnectionState
from robots.wire import Message, MindOrderReport, MindTransferReport, Telemetry
from robots.world import WorldFile

EVENT_INTERVAL_S = 60.0
"""Wall-clock seconds between two events of a robot."""
JUMP_M = 1.0
"""How far telemetry may be from where the robot can have driven: a robot corrects its estimate (our choice)."""
JUMPS = 4
"""To and fro, so often within `FORGOTTEN_S`: a robot that only corrects its estimate does not return (our choice)."""
FORGOTTEN_S = 30.0
KEYS_READ_S = 1.0
"""Wall-clock seconds between two looks whether the file of keys has changed."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Impersonation:
    """What was noticed of one robot: how often, why the last time, and when (UTC, ISO 8601)."""

    count: int
    reason: str
    at: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Course:
    """A robot's last telemetry, and its jumps.

    :param left: where it was before the last jump. :param jumps: to and fro. :param jumped_s: the last, monotonic.
    """

    said: Telemetry
    left: Telemetry | None = None
    jumps: int = 0
    jumped_s: float = 0.0


class KeyFile:
    """The file of robots' keys, which changes while the service runs."""

    def __init__(self, path: Path | None, *, wall: WallClock = SYSTEM_CLOCK) -> None:
        """:raises Invalid: if it cannot be read. :param path: None: no robot signs."""
        self._path = path
        self._wall = wall
        self._keys: Mapping[str, str] = {}
        self._version: tuple[int, int] | None = None
        self._looked_s = 0.0
        if path is not None:
            self._load(path)

    def read(self) -> Mapping[str, str]:
        """The keys by robot. A file that has become unreadable changes nothing: robots with a key keep it."""
        now_s = self._wall.monotonic_s()
        if self._path is not None and now_s - self._looked_s >= KEYS_READ_S:
            try:
                self._load(self._path)
            except Invalid as error:
                logger.error("%s; the keys read before stay in force", error.detail)
        return self._keys

    def _load(self, path: Path) -> None:
        self._looked_s = self._wall.monotonic_s()
        try:
            status = path.stat()
            version = (status.st_mtime_ns, status.st_ino)
            if version == self._version:
                return
            keys = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise Invalid(f"MACTA_ROBOT_KEYS: {path} cannot be read: {error}", code="robot-keys") from error
        if not isinstance(keys, dict) or not all(isinstance(key, str) and key for key in keys.values()):
            raise Invalid(f"MACTA_ROBOT_KEYS: {path} does not give each robot a key", code="robot-keys")
        self._keys = keys
        self._version = version


class Impersonations:
    """What was noticed of all worlds' robots. Thread-safe."""

    def __init__(
        self,
        events: EventLog,
        *,
        worlds: Mapping[str, WorldFile],
        keys: Callable[[], Mapping[str, str]],
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        self._events = events
        self._worlds = worlds
        self._keys = keys
        self._wall = wall
        self._lock = threading.Lock()
        self._noticed: dict[str, Impersonation] = {}
        self._unrecorded: dict[tuple[str, str], int] = {}
        """By world and robot, how many since the last event."""
        self._recorded_s: dict[str, float] = {}

    def of(self, robot: str) -> Impersonation | None:
        with self._lock:
            return self._noticed.get(robot)

    def watch(
        self, world: str, board: RobotBoard, accepted: Mapping[str, Accepted] | None = None
    ) -> "RobotWatch":
        """Judges the messages of one world's link, and passes contact and telemetry on to the board.

        :param accepted: by topic, the counters of signed messages before a restart.
        """
        return RobotWatch(
            world,
            board,
            self,
            worlds=self._worlds,
            keys=self._keys,
            signatures=SignatureCheck(accepted),
            wall=self._wall,
        )

    def note(self, world: str, robot: str, reason: str) -> None:
        """Somebody else has published in the robot's name."""
        with self._lock:
            before = self._noticed.get(robot)
            count = 1 if before is None else before.count + 1
            self._noticed[robot] = Impersonation(count=count, reason=reason, at=utc_now())
            self._unrecorded[world, robot] = self._unrecorded.get((world, robot), 0) + 1
        if before is None:
            logger.warning("somebody publishes as %s in %s: %s", robot, world, reason)

    def has_news(self, world: str) -> bool:
        """Whether an event of one of the world's robots is due."""
        return bool(self._unrecorded) and bool(self._due(world))

    def record(self, database: Database, world: str) -> None:
        """Record the events that are due."""
        with database.write() as session:
            for robot, count, reason in self._due(world, taken=True):
                self._events.append(
                    session, RobotImpersonated(subject=robot, world=world, count=count, reason=reason)
                )

    def _due(self, world: str, *, taken: bool = False) -> list[tuple[str, int, str]]:
        now_s = self._wall.monotonic_s()
        with self._lock:
            due = [
                (robot, count, self._noticed[robot].reason)
                for (of, robot), count in self._unrecorded.items()
                if of == world and now_s - self._recorded_s.get(robot, -EVENT_INTERVAL_S) >= EVENT_INTERVAL_S
            ]
            if taken:
                for robot, _, _ in due:
                    del self._unrecorded[world, robot]
                    self._recorded_s[robot] = now_s
        return due


class RobotWatch:
    """Implements `Guard` and `Listener` of a link over a broker. To be called from one thread."""

    def __init__(
        self,
        world: str,
        board: RobotBoard,
        impersonations: Impersonations,
        *,
        worlds: Mapping[str, WorldFile],
        keys: Callable[[], Mapping[str, str]],
        signatures: SignatureCheck,
        wall: WallClock,
    ) -> None:
        self._world = world
        self._board = board
        self._impersonations = impersonations
        self._worlds = worlds
        self._keys = keys
        self._wall = wall
        self._signatures = signatures
        self._courses: dict[str, _Course] = {}

    @property
    def accepted(self) -> Mapping[str, Accepted]:
        """By topic, the counters of signed messages; may be asked for from any thread."""
        return self._signatures.accepted

    def admits(self, robot: str, publication: Publication) -> bool:
        """False for a message that a robot with a key has not signed, or has signed while its twin is simulated, unless
        it is an answer of its own software, which stands by to take the robot's mind.
        """
        key = self._keys().get(robot)
        if key is None:
            return True
        if self._is_simulated(robot) and not publication.signature:
            return True
        if self._is_simulated(robot) and not _moves_minds(publication):
            return False
        reason = self._signatures.doubt(publication, key)
        if reason:
            self._impersonations.note(self._world, robot, reason)
        return not reason

    def heard(self, robot: str, telemetry: Telemetry) -> None:
        self._compare(robot, telemetry)
        self._board.heard(robot, telemetry)

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        self._board.connected(robot, state, now=now)

    def _is_simulated(self, robot: str) -> bool:
        """Whether the world's fleet speaks for it, which has no key."""
        spec = self._worlds[self._world].agents_by_name.get(robot) if self._world in self._worlds else None
        return spec is not None and not spec.external

    def _compare(self, robot: str, said: Telemetry) -> None:
        """Note telemetry that goes to and fro between two places."""
        world = self._worlds.get(self._world)
        spec = None if world is None else world.robots_by_name.get(robot)
        if spec is None:
            return
        course = self._courses.get(robot) or _Course(said=said)
        now_s = self._wall.monotonic_s()
        if now_s - course.jumped_s > FORGOTTEN_S:
            course = replace(course, left=None, jumps=0)
        passed_s = max(0.0, said.at_s - course.said.at_s)  # two clocks go to and fro, too
        if not _is_near(said, course.said, spec.speed_m_s * passed_s):
            # It returns to where it came from, or has jumped from there before.
            returns = course.left is not None and (
                _is_near(said, course.left, spec.speed_m_s * passed_s)
                or _is_near(course.said, course.left, 0.0)
            )
            jumps = course.jumps + 1 if returns or course.left is None else 1
            course = replace(course, left=course.said, jumps=jumps, jumped_s=now_s)
            if jumps >= JUMPS:
                places = " and ".join(f"({one.x_m:.1f}, {one.y_m:.1f})" for one in (course.said, said))
                self._impersonations.note(
                    self._world, robot, f"its telemetry goes to and fro between {places}"
                )
        self._courses[robot] = replace(course, said=said)


def _moves_minds(publication: Publication) -> bool:
    """Whether it is an answer to what moves a mind."""
    if not publication.topic.endswith(f"/{Channel.STATE}"):
        return False
    try:
        body = Message.model_validate_json(publication.payload).body
    except ValidationError:
        return False
    return isinstance(body, MindOrderReport | MindTransferReport)


def _is_near(one: Telemetry, other: Telemetry, driven_m: float) -> bool:
    """Whether the robot may have driven so far from one place to the other, or corrected its estimate."""
    return dist((one.x_m, one.y_m), (other.x_m, other.y_m)) <= JUMP_M + SPEED_FACTOR * driven_m
