"""Times in sentences: times of day, spans, and the expected ends of missions."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from pydantic import BaseModel, ConfigDict

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.sentence import Part, Phrase, Tail
from app.domain.goal_language.words import joined

MISSION = "mission"
GOAL = "goal"
Missions = Callable[[], Mapping[str, float]]
"""The open missions of the world, each with the seconds until its expected end by the world's clock."""


Goals = Callable[[], Sequence[str]]
"""The goals of the world that are not over."""


def no_missions() -> Mapping[str, float]:
    return {}


def no_goals() -> Sequence[str]:
    return ()


class Due(BaseModel):
    """When a sentence wants its goals achieved.

    :param at: a time of day by the service's clock and time zone, ISO 8601; None for a span of the world's clock.
    :param in_s: seconds from now, by the wall clock with `at`, else by the world's clock.
    :param mission: the mission before whose expected end.
    """

    model_config = ConfigDict(frozen=True)

    in_s: float
    at: str | None = None
    mission: str | None = None


@dataclass(frozen=True, slots=True)
class Times:
    """Resolves the times of a sentence.

    :param now: the service's time in its time zone; None: times of day are not understood.
    :param missions: called if the sentence names a mission; `goals`: if it names a goal.
    """

    now: datetime | None
    missions: Missions
    goals: Goals = no_goals

    def due(self, tail: Tail, text: str) -> tuple[Due, str] | Clarification:
        """The deadline of a phrase, and what it was resolved to in words.

        :param text: the sentence.
        """
        if tail.part is Part.WITHIN:
            return _within(tail, text)
        if tail.is_before and tail.phrase.words and tail.phrase.words[0].startswith(MISSION):
            return self._before_mission(tail, text)
        if not tail.time or self.now is None:
            return Clarification(
                code="time-not-understood",
                detail="by when? Say a time of day, such as 14:30, or a span, such as in ten minutes",
                thing=tail.phrase.said,
                choices=next_full_hours(self.now) if self.now else (),
                span=tail.phrase.span if tail.phrase.words else (tail.span[1], tail.span[1]),
            )
        moment = next_time_of_day(tail.time, self.now)
        seconds = (moment - self.now).total_seconds()
        shown = f"{moment:%Y-%m-%d %H:%M} {moment.tzname()}, in {in_words(seconds)}"
        return Due(in_s=seconds, at=moment.isoformat(timespec="minutes")), shown

    def _before_mission(self, tail: Tail, text: str) -> tuple[Due, str] | Clarification:
        """The deadline "before mission …": when that mission is expected to end."""
        mission = self.mission(tail.phrase, text)
        if isinstance(mission, Clarification):
            return mission
        due = Due(in_s=max(1.0, self.missions()[mission]), mission=mission)
        return due, f"in {in_words(due.in_s)} of the world's clock, when it is expected to end"

    def mission(self, phrase: Phrase, text: str) -> str | Clarification:
        """The id of the open mission that a phrase names.

        :param text: the sentence.
        """
        return _open(MISSION, tuple(self.missions()), phrase, text)

    def goal(self, phrase: Phrase, text: str) -> str | Clarification:
        """The id of the goal that a phrase names, one that is not over.

        :param text: the sentence.
        """
        return _open(GOAL, tuple(self.goals()), phrase, text)


def _open(kind: str, names: Sequence[str], phrase: Phrase, text: str) -> str | Clarification:
    """The open mission or goal that a phrase names."""
    named = _named_in(phrase.words, names, kind)
    if named is not None:
        return named
    said = text[slice(*phrase.span)]
    no_such = f"no {kind} {said!r} is open" if said else f"which {kind}?"
    are_open = f"open {kind}s: {joined(names, last='and')}" if names else "none is open"
    return Clarification(
        code=f"unknown-{kind}",
        detail=f"{no_such}; {are_open}",
        thing=phrase.said,
        choices=tuple(names),
        span=phrase.span,
    )


def _within(tail: Tail, text: str) -> tuple[Due, str] | Clarification:
    if tail.seconds <= 0:
        said = text[slice(*tail.span)]
        detail = f"{said!r} leaves no time"
        return Clarification(code="time-not-understood", detail=detail, thing=said, span=tail.span)
    return Due(in_s=tail.seconds), f"in {tail.seconds:.0f} s of the world's clock"


def next_time_of_day(said: str, now: datetime) -> datetime:
    """The next moment, today or tomorrow, at which a clock shows `HH:MM` in the time zone of `now`."""
    hour, _, minute = said.partition(":")
    moment = now.replace(hour=int(hour), minute=int(minute), second=0, microsecond=0)
    return moment if moment > now else moment + timedelta(days=1)


def _named_in(words: Sequence[str], names: Iterable[str], kind: str) -> str | None:
    """The mission or goal whose id the words spell, with or without its kind before it."""
    said = _letters("".join(words)).removeprefix(kind)
    return next(
        (
            one
            for one in names
            if _letters(one.replace("-", "_")).removeprefix(kind) in {said, said.removeprefix(kind)}
        ),
        None,
    )


def next_full_hours(now: datetime) -> tuple[str, ...]:
    """The next full hours as times of day."""
    return tuple(f"{now + timedelta(hours=hours):%H}:00" for hours in range(1, 4))


def in_words(seconds: float) -> str:
    """A span in words: `1 h 5 min`, `25 min 3 s`."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = ((hours, "h"), (minutes, "min"), (rest if not hours else 0, "s"))
    return " ".join(f"{value} {unit}" for value, unit in parts if value)


def _letters(name: str) -> str:
    return name.replace("_", "")
