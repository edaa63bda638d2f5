"""What the names of a command stand for, or which of several things to ask about."""

from collections.abc import Mapping, Sequence
from enum import StrEnum

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.words import choices_for, joined, name_in, natural_key, suggestions
from app.domain.robot_language.sentence import Phrase
from app.domain.robot_language.surroundings import Surroundings
from app.domain.robot_language.syntax import tokens_of

WHICH_ONE = "which-one"
"""The code of a clarification that is answered by one of its choices."""
PRONOUNS = frozenset({"it", "that", "this"})
ANY_SAMPLE = frozenset({"sample", "samples", "object", "objects", "thing"})
ANY_PLACE = frozenset({"place", "location"})
ANY_ROBOT = frozenset({"robot", "robots", "fellow"})
ORDINALS = ("first", "second", "third", "fourth", "fifth")


class Kind(StrEnum):
    """What an argument names."""

    THING = "thing"
    """A sample, a robot or a place: what a robot can face or go to."""
    SAMPLE = "sample"
    """A sample."""
    PLACE = "place"
    """A location of the robot's reach."""
    ROBOT = "robot"
    """Another robot."""


def candidates(kind: Kind, around: Surroundings) -> tuple[str, ...]:
    """The names that may stand there, in their natural order."""
    others = [name for name in around.robots if name != around.robot]
    found: Mapping[Kind, Sequence[str]] = {
        Kind.SAMPLE: tuple(around.samples),
        Kind.PLACE: tuple(around.places),
        Kind.ROBOT: others,
        Kind.THING: (*around.samples, *around.places, *others),
    }
    return tuple(sorted(found[kind], key=natural_key))


def resolve(
    phrase: Phrase, kind: Kind, around: Surroundings, *, it: str | None = None, at: str | None = None
) -> str | Clarification:
    """The name that a phrase stands for, or what to ask.

    :param it: what "it" stands for. :param at: the place at which the thing is said to be.
    """
    names = candidates(kind, around)
    name = name_in(phrase.words, names)
    if name in names:
        return name
    if phrase.words[0] in PRONOUNS and len(phrase.words) == 1 and it in names:
        return it
    kept, select = _selector(phrase.words)
    is_bare = not kept and "one" not in phrase.words  # "turn left" names nothing
    meant = None if is_bare else _of_a_kind(kept, names, around)
    if meant is None:
        return unknown(phrase, kind, names)
    if at is not None:
        meant = [one for one in meant if around.lies_at.get(one) == at]
    if not meant:
        where = f" at {at}" if at is not None else ""
        return Clarification(
            code=f"unknown-{kind}",
            detail=f"{around.robot} knows of no {phrase.said}{where}",
            thing=phrase.said,
            choices=names,
            span=phrase.span,
        )
    if len(meant) == 1:
        return meant[0]
    return picked(select, meant, around) or which_one(phrase, meant)


def which_one(phrase: Phrase, meant: Sequence[str]) -> Clarification:
    """The question which of several things is meant."""
    return Clarification(
        code=WHICH_ONE,
        detail=f"which one? {joined(meant)}",
        thing=phrase.said,
        choices=tuple(meant),
        span=phrase.span,
    )


def chosen(text: str, choices: Sequence[str], around: Surroundings) -> str | None:
    """The choice that a person's next word means ("sample_2", "the left one"); None if it is no answer."""
    words = tuple(one.text for one in tokens_of(text))
    if not words:
        return None
    name = name_in(words, choices)
    if name in choices:
        return name
    kept, select = _selector(words)
    return picked(select, choices, around) if set(kept) <= ANY_SAMPLE | ANY_PLACE | ANY_ROBOT else None


def picked(select: str, names: Sequence[str], around: Surroundings) -> str | None:
    """The one of several that is the left, right, nearest or farthest for the robot, or the first, second …"""
    if select in ORDINALS:
        index = ORDINALS.index(select)
        return names[index] if index < len(names) else None
    if select == "last":
        return names[-1]
    known = [one for one in names if around.pose is not None and around.point(one) is not None]
    if not select or not known:
        return None
    if select in ("left", "right"):
        return (max if select == "left" else min)(known, key=around.bearing_rad)
    return (min if select == "near" else max)(known, key=around.range_m)


def unknown(phrase: Phrase, kind: Kind, names: Sequence[str]) -> Clarification:
    """Nothing has that name."""
    near = suggestions("_".join(phrase.words), names)
    hint = f"; did you mean {joined(near)}?" if near else ""
    return Clarification(
        code=f"unknown-{kind}",
        detail=f"there is no {kind} {phrase.said!r} that the robot knows{hint}",
        thing=phrase.said,
        choices=choices_for("_".join(phrase.words), names),
        span=phrase.span,
    )


_SELECTORS: Mapping[str, str] = {
    "left": "left",
    "leftmost": "left",
    "right": "right",
    "rightmost": "right",
    "nearest": "near",
    "closest": "near",
    "near": "near",
    "farthest": "far",
    "furthest": "far",
    "far": "far",
    "last": "last",
    **{word: word for word in ORDINALS},
}


def _selector(words: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """The words without "one" and the one that chooses, and what it chooses by; empty if none does."""
    kept = tuple(one for one in words if one not in _SELECTORS and one not in ("one", "1"))
    return kept, next((_SELECTORS[one] for one in words if one in _SELECTORS), "")


def _of_a_kind(words: Sequence[str], names: Sequence[str], around: Surroundings) -> list[str] | None:
    """The things that a word such as "sample" or "bay" may mean; None for another word.

    Samples are those in view, else those in the robot's reach, else all.
    """
    if len(words) > 1:
        return None
    word = words[0] if words else ""
    if not word or word in ANY_SAMPLE:
        samples = [one for one in names if one in around.samples and one != around.holding]
        seen = [one for one in samples if one in around.seen]
        return seen or [one for one in samples if around.lies_at.get(one) in around.places] or samples
    if word in ANY_ROBOT:
        return [one for one in names if one in around.robots]
    found = [
        one
        for one in names
        if around.kinds.get(one) == word.removesuffix("s") or around.kinds.get(one) == word
    ]
    if word in ANY_PLACE:
        found = [one for one in names if one in around.places]
    return found or None
