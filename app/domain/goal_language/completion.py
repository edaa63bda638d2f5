"""Completion of a sentence that is being typed: what the grammar, the verbs and the world allow, where it belongs."""

from collections.abc import Iterable, Sequence

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.grammar import understand
from app.domain.goal_language.issues import TOO_TIGHT, GoalIssue
from app.domain.goal_language.syntax import Progress, grammar, parse
from app.domain.goal_language.verbs import NO_VERBS, Verbs, shipped_verbs
from app.domain.goal_language.words import natural_key
from app.domain.world_model import Facts
from robots.world import WorldFile

MAX_COMPLETIONS = 20
TARGET_KINDS = ("TO", "IN")
"""The grammar's prepositions of targets."""


def completions(
    text: str, asked: Clarification, world: WorldFile, facts: Facts, verbs: Verbs | None = None
) -> tuple[str, ...]:
    """Whole sentences that complete the text, the likeliest first.

    :param asked: what `understand` found missing in the text.
    """
    known = shipped_verbs() if verbs is None else verbs
    said = text.rstrip()
    found = [*_keywords(said, world, facts, known), *_filled_in(said, asked, known)]
    return tuple(dict.fromkeys(found))[:MAX_COMPLETIONS]


def replacements(text: str, issue: GoalIssue) -> tuple[str, ...]:
    """Whole sentences in which one of an issue's choices replaces the name that it is about."""
    if issue.code == TOO_TIGHT:  # its choices are what the constraints withhold
        return ()
    return _in_place(text.rstrip(), issue.thing, issue.choices)[:MAX_COMPLETIONS]


def span_of(text: str, thing: str) -> tuple[int, int] | None:
    """Start and end of the last words of a sentence that spell the name; None if it does not have them."""
    return _span(text, _letters(thing))


def _keywords(text: str, world: WorldFile, facts: Facts, verbs: Verbs) -> Iterable[str]:
    """The text with its last letters completed to a word that the grammar allows there.

    Half a preposition is not the end of a name: "move sample_1 t" goes on with "to" and the places.
    """
    said, _, last = text.rpartition(" ")
    progress = parse(said, verbs) if said else None
    if not isinstance(progress, Progress) or not last.isalpha():
        return
    # A verb begins a clause: the letters after a name are not the start of one.
    words = grammar().words_for(progress.next_kinds - {"VERB"}, verbs)
    begun = [word for word in words if word.startswith(last.lower()) and word != last.lower()]
    if any(word in _words(TARGET_KINDS) for word in begun):
        asked = understand(said, world, facts, verbs=verbs)
        if isinstance(asked, Clarification) and asked.code == "place-needed":
            yield from _filled_in(said.rstrip(), asked, verbs)
    yield from (f"{said} {word}" for word in begun)


def _filled_in(said: str, asked: Clarification, verbs: Verbs) -> Sequence[str]:
    """The text with the choices where they belong."""
    first = next(iter(verbs.by_word))
    if not said:
        return [f"{first} {choice}" for choice in asked.choices]
    begun = _begun(asked)
    if asked.code == "unknown-verb" and set(asked.choices) == set(verbs.words) and not begun:
        return [f"{first} {said}"]
    if asked.span is None:
        return _in_place(said, asked.thing, begun or asked.choices)
    start, end = (min(place, len(said)) for place in asked.span)
    before = said[:start].rstrip() if start == end else said[:start]
    link = " " if start == end and before else ""
    if start == end and asked.link:
        link = f" {asked.link} "
    return [f"{before}{link}{choice}{said[end:]}" for choice in begun or asked.choices]


def _words(kinds: Iterable[str]) -> tuple[str, ...]:
    return grammar().words_for(kinds, NO_VERBS)


def _begun(asked: Clarification) -> Sequence[str]:
    """The choices that start with the word in question."""
    letters = _letters(asked.thing)
    if not letters:
        return ()
    return sorted((one for one in asked.choices if _letters(one).startswith(letters)), key=natural_key)


def _in_place(said: str, thing: str, choices: Sequence[str]) -> tuple[str, ...]:
    found = _span(said, _letters(thing))
    return tuple(f"{said[: found[0]]}{choice}{said[found[1] :]}" for choice in choices) if found else ()


def _span(said: str, letters: str) -> tuple[int, int] | None:
    """Start and end of the last words that spell these letters, ignoring case and separators (`Bay 7` is `bay_7`)."""
    ends = [at for at in range(1, len(said) + 1) if at == len(said) or not said[at].isalnum()]
    starts = [at for at in range(len(said)) if at == 0 or said[at - 1].isspace()]
    spans = [(one, other) for other in reversed(ends) for one in reversed(starts) if one < other]
    return next((span for span in spans if letters and _letters(said[slice(*span)]) == letters), None)


def _letters(word: str) -> str:
    return "".join(letter for letter in word.lower() if letter.isalnum())
