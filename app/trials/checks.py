"""Where the record and the world disagree, in words; nothing where they agree."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from app.trials.observer import ENDED
from app.trials.recorded_reports import Record
from robots.wire import SymbolicFact

IsTrue = Callable[[SymbolicFact], bool]
Goal = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What the service believes: facts as (predicate, arguments), and of what no place is known."""

    facts: Collection[tuple[str, tuple[str, ...]]]
    unknown: Collection[str] = field(default=())


def open_for_ever(goals: Iterable[Goal]) -> list[str]:
    """Goals that did not come to an end, and such as ended without an outcome."""
    known = list(goals)
    still = [goal for goal in known if goal["state"] not in ENDED]
    unsaid = [goal for goal in known if goal["state"] in ENDED and not goal["outcome"]]
    return [
        *(f"{goal['id']} did not come to an end: {goal['state']}, {goal['reason']}" for goal in still),
        *(f"{goal['id']} is {goal['state']} without an outcome" for goal in unsaid),
    ]


def goals_that_did_not_come_true(goals: Iterable[Goal], is_true: IsTrue) -> list[str]:
    """Goals that were completed, and are not true in the world."""
    completed = [goal for goal in goals if goal["outcome"] == "completed"]
    return [
        f"{goal['id']} ({goal['text']}) was completed, but {fact} is not true"
        for goal in completed
        for fact in map(SymbolicFact.model_validate, goal["goal"])
        if not is_true(fact)
    ]


def disagreements(found: Found, lies: Mapping[str, str | None], known_as: Mapping[str, str]) -> list[str]:
    """Samples that are believed elsewhere than they are.

    :param lies: by sample, the place or gripper that it is in, in the world; None on the bare floor.
    :param known_as: by berth, the location it is of; a sample may be known to be in either.
    """
    wrong = []
    for sample, ref in lies.items():
        believed = [args[1] for name, args in found.facts if name == "in" and args[0] == sample]
        if sample in found.unknown and not believed:
            continue
        allowed = {ref, known_as.get(ref or "", ref)}
        if len(believed) != 1 or believed[0] not in allowed:
            wrong.append(f"{sample} is in {ref or 'no place'}, and believed in {believed or 'no place'}")
    return wrong


def executed_twice(record: Record) -> list[str]:
    """What robots did more than once, or two things at once."""
    twice = [
        f"{packet} of {script} was {state} {count} times"
        for (script, packet, state), count in record.executed().items()
        if count > 1
    ]
    return [*twice, *(f"{one} and {other} ran on one robot at once" for one, other in record.clashes())]


def lost_events(seen: Sequence[int], kept: Sequence[int]) -> list[str]:
    """What a stream that is resumed again and again must be: every event once, in order.

    :param seen: the numbers in the order they came.
    :param kept: those of the record, in order.
    """
    if list(seen) == list(kept):
        return []
    missing, doubled = sorted(set(kept) - set(seen)), len(seen) - len(set(seen))
    return [
        f"the stream of events told {len(seen)} of {len(kept)}: not {missing[:5]}, {doubled} twice, "
        f"{'in' if list(seen) == sorted(seen) else 'out of'} order"
    ]
