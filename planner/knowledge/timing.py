"""Times within an action, as the literals of its slots state them: `clear(ref2, area) from end - 2`.

A condition holds throughout the action, or `from` or `until` a time, or `at` its start or end; a delete happens at its
start and an effect at its end, or `at` a time. A time is the start, so many seconds after it, the end, or so many
seconds before it. (Unified-planning's timings; Fox & Long 2003, PDDL 2.1, knows only start and end.)
"""

import re
from dataclasses import dataclass
from math import isfinite

from planner.errors import KnowledgeBaseError

UNDER_WAY = "under_way_"
"""What the predicates begin with that chain an action's phases (`planner.knowledge.phases`)."""

_SPLIT = re.compile(r"^(.*\))\s+((?:from|until|at)\b.*)$", re.DOTALL)
_CLAUSE = re.compile(r"\s*(from|until|at)\s+(?:(start)(?:\s*\+\s*(\S+))?|(end)(?:\s*-\s*(\S+))?)\s*$")
_FORM = "a time is start, start + seconds, end or end - seconds"


@dataclass(frozen=True, slots=True, order=True)
class Moment:
    """A time within an action: `seconds` after its start, or before its end."""

    before_end: bool
    seconds: float

    @property
    def place(self) -> tuple[bool, float]:
        """Orders the times of an action: all that are told from its start come before those told from its end."""
        return self.before_end, -self.seconds if self.before_end else self.seconds

    def __str__(self) -> str:
        if not self.seconds:
            return "end" if self.before_end else "start"
        return f"end - {self.seconds:g}" if self.before_end else f"start + {self.seconds:g}"


START = Moment(False, 0.0)
END = Moment(True, 0.0)


@dataclass(frozen=True, slots=True)
class Span:
    """From when until when a literal concerns the action; for deletes and effects the same time twice."""

    begin: Moment
    end: Moment

    @property
    def moments(self) -> tuple[Moment, Moment]:
        return self.begin, self.end


THROUGHOUT = Span(START, END)
AT_START = Span(START, START)
AT_END = Span(END, END)


def split_span(text: str, default: Span, *, is_condition: bool) -> tuple[str, Span]:
    """The literal's text without its times, and these.

    :raises KnowledgeBaseError: if the times are not of the form that the slot allows.
    """
    match = _SPLIT.match(text.strip())
    if match is None:
        return text, default
    found = dict[str, Moment]()
    for clause in re.split(r"\s+(?=(?:from|until|at)\b)", match[2]):
        word, moment = _clause(clause, text)
        if word in found:
            raise KnowledgeBaseError(f"{text!r} says {word!r} twice")
        found[word] = moment
    if is_condition:
        return match[1], _condition_span(found, text)
    if found.keys() != {"at"}:
        raise KnowledgeBaseError(f"{text!r}: what an action changes, it changes `at` a time; {_FORM}")
    return match[1], Span(found["at"], found["at"])


def _clause(clause: str, text: str) -> tuple[str, Moment]:
    match = _CLAUSE.match(clause)
    if match is None:
        raise KnowledgeBaseError(f"{text!r}: {clause.strip()!r} is no time; {_FORM}")
    word, _, after, end, before = match.groups()
    try:
        seconds = float(after or before or 0.0)
    except ValueError:
        seconds = float("nan")
    if not isfinite(seconds) or seconds < 0.0:
        raise KnowledgeBaseError(f"{text!r}: {after or before!r} is no number of seconds")
    return word, Moment(end is not None, seconds)


def _condition_span(found: dict[str, Moment], text: str) -> Span:
    if "at" in found:
        if len(found) > 1 or found["at"].seconds:
            raise KnowledgeBaseError(
                f"{text!r}: a condition holds `at` start or end, or `from` and `until` a time"
            )
        return Span(found["at"], found["at"])
    span = Span(found.get("from", START), found.get("until", END))
    if span.end.place <= span.begin.place:
        raise KnowledgeBaseError(f"{text!r}: it ends before it begins")
    return span
