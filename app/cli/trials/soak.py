"""The soak trial: rounds of random goals and faults, then settling without faults, then checks."""

import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

import httpx2

from app.cli.trials.checks import (
    Beliefs,
    IsTrue,
    RecordedReports,
    disagreements,
    executed_twice,
    lost_events,
    unfinished_goals,
    untrue_goals,
)
from app.cli.trials.observer import EventFollower, Observer
from app.cli.trials.random_operator import RandomOperator
from app.cli.trials.service_faults import ServiceFaults
from app.cli.trials.service_process import Installation, NotReady
from app.domain.clock import WallClock, pause
from app.domain.goal_language.verbs import Verbs
from robots.world import WorldFile

ACT_S = (0.05, 1.2)
"""Interval between two acts of the operator."""
LOOK_S = 0.5
SETTLE_WORLD_S = 1800.0
"""World time within which every goal must end once there are no more faults."""
SETTLE_WALL_S = 1800.0
"""Wall-clock limit of the same."""
CAUGHT_UP_S = 20.0
SNAPSHOT_S = 2.5
"""Wait before the snapshot is read: a world at rest takes one every second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrueState:
    """The true state of the world: `is_true` of facts, and by sample the place it `lies` in."""

    is_true: IsTrue
    lies: Mapping[str, str | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundResult:
    """The result of a round: counts so far, the service's memory, and what is `wrong`."""

    at_s: float
    process: int
    goals: int
    memory_mb: float
    wrong: tuple[str, ...]


@dataclass(slots=True, kw_only=True)
class SoakTrial:
    """Runs the trial.

    :param true_state: reads the true state of the world, which the service never sees.
    :param verbs: those of the operator's sentences; None: samples are moved.
    """

    installation: Installation
    world: WorldFile
    seed: int
    true_state: Callable[[], TrueState]
    faults: ServiceFaults
    verbs: Verbs | None = None
    observer: Observer = field(init=False)
    operator: RandomOperator = field(init=False)
    rounds: list[RoundResult] = field(default_factory=list)
    _follower: EventFollower = field(init=False)
    _clock: WallClock = field(init=False)
    _begun_s: float = field(init=False)

    def __post_init__(self) -> None:
        self._clock = self.installation.clock
        self._begun_s = self._clock.monotonic_s()
        self.observer = Observer(self.world.name)
        self.operator = RandomOperator(
            world=self.world, seed=self.seed, observer=self.observer, verbs=self.verbs
        )
        self._follower = EventFollower(self.faults.api)

    @property
    def elapsed_s(self) -> float:
        return self._clock.monotonic_s() - self._begun_s

    @property
    def wrong(self) -> list[str]:
        """All complaints and failed checks."""
        judged = [words for result in self.rounds for words in result.wrong]
        return [*self.faults.complaints, *self.operator.complaints, *self.observer.complaints, *judged]

    @contextmanager
    def under_way(self) -> Iterator[None]:
        """Run the service and follow its event stream for the length of the block."""
        with self._follower.following():
            try:
                yield
                self.faults.end()
            finally:
                self.faults.kill()

    def round(self, storm_s: float) -> RoundResult:
        """Submit goals and inject faults for `storm_s` (wall clock), let all goals end, and check."""
        self.faults.pause()  # waits until the service is up
        self.faults.start()
        give_up_s = self._clock.monotonic_s() + storm_s
        rng = random.Random(f"{self.seed} {len(self.rounds)}")
        while self._clock.monotonic_s() < give_up_s:
            self._with_api(self._act)
            pause(self._clock, rng.uniform(*ACT_S))
        self.faults.pause()
        over = self._settle_all()
        result = self._judged(over)
        self.rounds.append(result)
        return result

    def _act(self, api: httpx2.Client) -> None:
        self.operator.act(api)
        self.observer.read(api, self.operator.open)

    def _settle_all(self) -> bool:
        give_up_s = self._clock.monotonic_s() + SETTLE_WALL_S
        began_s = self.observer.time_s
        while self._clock.monotonic_s() < give_up_s and self.observer.time_s < began_s + SETTLE_WORLD_S:
            if self._with_api(self._settle) and not self.operator.open:
                return True
            pause(self._clock, LOOK_S)
        return False

    def _settle(self, api: httpx2.Client) -> None:
        self.operator.settle(api)
        self.observer.read(api, self.operator.open)

    def _with_api(self, act: Callable[[httpx2.Client], None]) -> bool:
        """False if the service ended meanwhile."""
        with suppress(httpx2.TransportError, httpx2.HTTPStatusError, NotReady), self.faults.api() as api:
            act(api)
            return True
        return False

    def _judged(self, over: bool) -> RoundResult:
        """Run the checks; the true state is compared only if all goals have ended."""
        wrong = unfinished_goals(self.observer.goals.values())
        wrong += executed_twice(self._record())
        if over:
            pause(self._clock, SNAPSHOT_S)
            true_state = self.true_state()
            found = self._found()
            wrong += disagreements(found, true_state.lies, self.world.location_of)
            wrong += untrue_goals(self._latest(), true_state.is_true)
        wrong += self._lost_events()
        return RoundResult(
            at_s=self.elapsed_s,
            process=self.faults.service.number,
            goals=len(self.operator.submitted),
            memory_mb=self.faults.service.memory_mb,
            wrong=tuple(wrong),
        )

    def _record(self) -> RecordedReports:
        return RecordedReports.read(self.installation.database_url)

    def _latest(self) -> list[Mapping[str, object]]:
        """The goals that were carried out and not undone by a later one."""
        latest: dict[str, str] = {}
        carried_out = [goal for goal in self.observer.goals.values() if goal["mission_id"] is not None]
        by_end = sorted(carried_out, key=lambda goal: goal["updated_at"])
        for goal in by_end:
            latest |= {fact["args"][0]: goal["id"] for fact in goal["goal"]}
        return [
            goal for goal in by_end if all(latest[fact["args"][0]] == goal["id"] for fact in goal["goal"])
        ]

    def _found(self) -> Beliefs:
        with self.faults.api() as api:
            facts = api.get(f"/v1/worlds/{self.world.name}/facts").raise_for_status().json()["items"]
            unknown = api.get(f"/v1/worlds/{self.world.name}/unknown").raise_for_status().json()["items"]
        return Beliefs(
            facts=[(fact["predicate"], tuple(fact["args"])) for fact in facts],
            unknown=[one["name"] for one in unknown],
        )

    def _lost_events(self) -> list[str]:
        give_up_s = self._clock.monotonic_s() + CAUGHT_UP_S
        while lost := lost_events(self._follower.seen, self._record().events):
            if self._clock.monotonic_s() > give_up_s:
                break
            pause(self._clock, LOOK_S)
        return lost
