"""Tells a world of its newest edition until it has taken that up, or refused it."""

from collections.abc import Callable, Mapping

from sqlalchemy import select

from app.core import Core
from app.domain.events import WorldChangeRefused, WorldChangeTakenUp
from app.store import EditionRow
from app.store.editions import WorldDirectory
from robots.clock import Clock
from robots.wire import Message, Performative, WorldChange, WorldEdition

REQUEST = "edition:"
"""The ids of requests: this and the edition."""


class EditionDelivery:
    """Delivers one world's editions. To be called from one thread."""

    def __init__(
        self,
        core: Core,
        worlds: WorldDirectory,
        world: str,
        run: Callable[[], str | None] = lambda: None,
        *,
        is_simulated: Callable[[], bool] = lambda: True,
        clock: Clock | None = None,
        minds: Callable[[], Mapping[str, str]] = dict,
    ) -> None:
        """
        :param run: the world's present run; another one begins without the changes.
        :param is_simulated: False while nobody has to take changes up: there is no simulation.
        :param clock: the world's.
        :param minds: by robot, the documents of minds with which the world is to take the place of robots' own
            software.
        """
        self._minds = minds
        self._is_simulated = is_simulated
        self._clock = clock
        self._database = core.database
        self._events = core.events
        self._worlds = worlds
        self._world = world
        self._run = run
        self._told_run: str | None = None
        self._told = 0
        self._seen = 0

    def has_news(self) -> bool:
        """True the first time that there is an edition to deliver."""
        newest = self._newest_due()
        is_new = newest > max(self._told, self._seen)
        self._seen = max(newest, self._seen)
        return is_new

    def due(self) -> tuple[str, WorldChange] | None:
        """The request that the world has not answered, with its id."""
        number = self._newest_due()
        if number <= self._told:
            return None
        if not self._is_simulated():
            self._record(number, at_s=0.0 if self._clock is None else self._clock.now_s())
            return None
        edition = self._worlds.edition(self._world)
        change = WorldChange(
            edition=edition.number,
            world=edition.world.model_dump(mode="json"),
            minds=dict(self._minds()),
        )
        return f"{REQUEST}{edition.number}", change

    def answered(self, message: Message, answer: WorldEdition) -> None:
        """Record the world's answer."""
        refused = message.performative is Performative.REFUSE
        asked = (message.in_reply_to or "").removeprefix(REQUEST)
        number = (int(asked) if asked.isdecimal() else 0) if refused else answer.edition
        if number > self._worlds.edition(self._world).number:
            return  # one that there is not
        taken_up = min(answer.edition, number - 1) if refused else number
        self._record(number, at_s=message.sent_at_s, taken_up=taken_up, reason=answer.reason)

    def _record(self, number: int, *, at_s: float, taken_up: int | None = None, reason: str = "") -> None:
        """Record that the world has taken up all editions up to this one.

        :param taken_up: the last one of them that it has; it refuses what came after. None: all.
        """
        self._told = max(self._told, number)
        pending = (EditionRow.world == self._world, EditionRow.delivery == "pending")
        with self._database.write() as session:
            query = (
                select(EditionRow).where(*pending, EditionRow.edition <= number).order_by(EditionRow.edition)
            )
            for row in session.scalars(query.with_for_update()).all():
                is_refused = taken_up is not None and row.edition > taken_up
                row.delivery = "refused" if is_refused else "taken_up"
                row.detail = reason if is_refused else ""
                told = (
                    WorldChangeRefused(subject=self._world, edition=row.edition, reason=reason)
                    if is_refused
                    else WorldChangeTakenUp(subject=self._world, edition=row.edition, at_s=at_s)
                )
                self._events.append(session, told)

    def _newest_due(self) -> int:
        run = self._run()
        if run != self._told_run:
            self._told_run = run
            self._told = self._seen = 0
        return self._worlds.edition(self._world).number
