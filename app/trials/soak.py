"""The trial itself: a while of goals and faults, quiet until everything is over, judgement; again and again."""

import random
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

import httpx2

from app.trials.checks import (
    Found,
    IsTrue,
    disagreements,
    executed_twice,
    goals_that_did_not_come_true,
    lost_events,
    open_for_ever,
)
from app.trials.observer import Follower, Watch
from app.trials.random_operator import RandomOperator
from app.trials.recorded_reports import Record
from app.trials.service_faults import Faults
from app.trials.service_process import Installation, NotReady
from robots.world import WorldFile

ACT_S = (0.05, 1.2)
"""Between two acts of the operator."""
LOOK_S = 0.5
QUIET_S, STUCK_S = 1800.0, 1800.0
"""Within so long, of the world's time, everything is to come to its end once there are no more faults; a world that
does not get that far within so long of the wall clock stands still.
"""
CAUGHT_UP_S = 20.0
SETTLE_S = 2.5
"""A world that rests is kept once a second: after so long its snapshot is of the rest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Real:
    """The world as it is: `is_true` of facts, and by sample where it `lies`."""

    is_true: IsTrue
    lies: Mapping[str, str | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Quiet:
    """A quiet point: how much has been done by then, and what the service's process holds."""

    at_s: float
    life: int
    goals: int
    memory_mb: float
    wrong: tuple[str, ...]


@dataclass(slots=True, kw_only=True)
class Trial:
    """Runs the trial.

    :param real: reads the world as it is; never the service's to know.
    """

    installation: Installation
    world: WorldFile
    seed: int
    real: Callable[[], Real]
    faults: Faults
    watch: Watch = field(init=False)
    operator: RandomOperator = field(init=False)
    quiets: list[Quiet] = field(default_factory=list)
    _follower: Follower = field(init=False)
    _begun_at: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.watch = Watch(self.world.name)
        self.operator = RandomOperator(world=self.world, seed=self.seed, watch=self.watch)
        self._follower = Follower(self.faults.api)

    @property
    def elapsed_s(self) -> float:
        return time.monotonic() - self._begun_at

    @property
    def wrong(self) -> list[str]:
        """All that did not hold."""
        judged = [words for quiet in self.quiets for words in quiet.wrong]
        return [*self.faults.complaints, *self.operator.complaints, *self.watch.complaints, *judged]

    @contextmanager
    def under_way(self) -> Iterator[None]:
        """The service lives, and the stream of its events is followed, for the length of the block."""
        with self._follower.following():
            try:
                yield
                self.faults.end()
            finally:
                self.faults.kill()

    def round(self, storm_s: float) -> Quiet:
        """Goals and faults for so long, then quiet; judged."""
        self.faults.pause()  # until it is up, for the first time too
        self.faults.start()
        give_up = time.monotonic() + storm_s
        rng = random.Random(f"{self.seed} {len(self.quiets)}")
        while time.monotonic() < give_up:
            self._with_the_service(self._act)
            time.sleep(rng.uniform(*ACT_S))
        self.faults.pause()
        over = self._let_all_end()
        quiet = self._judged(over)
        self.quiets.append(quiet)
        return quiet

    def _act(self, api: httpx2.Client) -> None:
        self.operator.act(api)
        self.watch.look(api, self.operator.open)

    def _let_all_end(self) -> bool:
        give_up, began_s = time.monotonic() + STUCK_S, self.watch.time_s
        while time.monotonic() < give_up and self.watch.time_s < began_s + QUIET_S:
            if self._with_the_service(self._settle) and not self.operator.open:
                return True
            time.sleep(LOOK_S)
        return False

    def _settle(self, api: httpx2.Client) -> None:
        self.operator.settle(api)
        self.watch.look(api, self.operator.open)

    def _with_the_service(self, act: Callable[[httpx2.Client], None]) -> bool:
        """False if the service went meanwhile."""
        with suppress(httpx2.TransportError, httpx2.HTTPStatusError, NotReady), self.faults.api() as api:
            act(api)
            return True
        return False

    def _judged(self, over: bool) -> Quiet:
        """Truth is compared only where nothing is under way any more."""
        wrong = open_for_ever(self.watch.goals.values())
        wrong += executed_twice(self._record())
        if over:
            time.sleep(SETTLE_S)
            real, found = self.real(), self._found()
            wrong += disagreements(found, real.lies, self.world.owners)
            wrong += goals_that_did_not_come_true(self._latest(), real.is_true)
        wrong += self._lost_events()
        return Quiet(
            at_s=self.elapsed_s,
            life=self.faults.life.number,
            goals=len(self.operator.stated),
            memory_mb=self.faults.life.memory_mb,
            wrong=tuple(wrong),
        )

    def _record(self) -> Record:
        return Record.read(self.installation.database_url)

    def _latest(self) -> list[Mapping[str, object]]:
        """Of the goals that were carried out those that no later one has undone."""
        latest: dict[str, str] = {}
        carried_out = [goal for goal in self.watch.goals.values() if goal["mission_id"] is not None]
        by_end = sorted(carried_out, key=lambda goal: goal["updated_at"])
        for goal in by_end:
            latest |= {fact["args"][0]: goal["id"] for fact in goal["goal"]}
        return [
            goal for goal in by_end if all(latest[fact["args"][0]] == goal["id"] for fact in goal["goal"])
        ]

    def _found(self) -> Found:
        with self.faults.api() as api:
            facts = api.get(f"/v1/worlds/{self.world.name}/facts").raise_for_status().json()["items"]
            unknown = api.get(f"/v1/worlds/{self.world.name}/unknown").raise_for_status().json()["items"]
        return Found(
            facts=[(fact["predicate"], tuple(fact["args"])) for fact in facts],
            unknown=[one["name"] for one in unknown],
        )

    def _lost_events(self) -> list[str]:
        give_up = time.monotonic() + CAUGHT_UP_S
        while lost := lost_events(self._follower.seen, self._record().events):
            if time.monotonic() > give_up:
                break
            time.sleep(LOOK_S)
        return lost
