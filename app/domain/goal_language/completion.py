"""Completion of a sentence that is being typed: the grammar's choices, inserted where they belong."""

from collections.abc import Sequence

from app.domain.goal_language.check import GoalIssue
from app.domain.goal_language.grammar import ORIGINS, TARGETS, VERBS, Clarification, parse_goal
from app.domain.goal_language.words import natural_key
from app.domain.world_model import Facts
from robots.world import WorldFile

MAX_COMPLETIONS = 20
PREPOSITIONS = TARGETS | ORIGINS


def completions(text: str, asked: Clarification, world: WorldFile, facts: Facts) -> tuple[str, ...]:
    """Whole sentences that complete the text, the likeliest first.

    :param asked: what `parse_goal` found missing in the text.
    """
    said, _, last = text.rstrip().rpartition(" ")
    if (
        said
        and last.lower() not in PREPOSITIONS
        and any(word.startswith(last.lower()) for word in PREPOSITIONS)
    ):
        # "move sample_1 t": half a preposition is not the end of a name.
        without = parse_goal(said, world, facts)
        if isinstance(without, Clarification) and without.code == "place-needed":
            return completions(said, without, world, facts)
    return _filled_in(text.rstrip(), asked)[:MAX_COMPLETIONS]


def replacements(text: str, issue: GoalIssue) -> tuple[str, ...]:
    """Whole sentences in which one of an issue's choices replaces the name that it is about."""
    return _in_place(text.rstrip(), issue.thing, issue.choices)[:MAX_COMPLETIONS]


def _filled_in(said: str, asked: Clarification) -> tuple[str, ...]:
    match asked.code:
        case "place-needed":
            link = " " if said.rsplit(maxsplit=1)[-1].lower() in TARGETS else " to "
            return tuple(f"{said}{link}{choice}" for choice in asked.choices)
        case "sample-needed":
            return tuple(f"{said} {choice}" for choice in asked.choices)
        case "goal-not-understood" if not said:
            return tuple(f"move {choice}" for choice in asked.choices)
        case "unknown-verb" if set(asked.choices) == VERBS and not _begun(asked):
            return (f"move {said}",)
    return _in_place(said, asked.thing, _begun(asked) or asked.choices)


def _begun(asked: Clarification) -> Sequence[str]:
    """The choices that start with the word in question."""
    letters = _letters(asked.thing)
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
