"""Sentences drawn from the grammar, half of them damaged: each must be goals or a question, never an exception.

    uv run python -m benchmarks.sentence_fuzz [SENTENCES] [SEED]

In the sample store, with and without known facts. Prints how many were understood, the questions by code, and the
longest processor time of one sentence.
"""

import random
import string
import sys
import time
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime

from app.domain.goal_language.check import check_request
from app.domain.goal_language.completion import completions
from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.goal_language.hold_checks import check_holds, goals_of_holds
from app.domain.goal_language.stated_holds import kept_by
from app.domain.goal_language.syntax import END, grammar
from app.domain.goal_language.verbs import Kind, Verb, Verbs, shipped_verbs
from app.domain.world_model import Facts, initial_facts
from planner import KnowledgeBase, load_knowledge_base
from robots.world import WorldFile, load_world

NOW = datetime(2026, 3, 1, 14, 0, tzinfo=UTC)
LONGEST = 24
"""The most words of a drawn sentence."""
NOUNS = (
    "sample",
    "samples",
    "robot",
    "robots",
    "bay",
    "bays",
    "door",
    "places",
    "one",
    "ones",
    "it",
    "the",
    "long",
)
NUMBERS = ("0", "1", "2", "two", "ten", "half", "999999")
TIMES = ("00:00", "9:05", "14:30", "23:59")


def drawn_sentence(chance: random.Random, world: WorldFile, verbs: Verbs) -> str:
    """A sentence that the grammar allows, about names of the world; most words fit those before them."""
    from lark import Token

    known = grammar()
    words = {"VERB": verbs.words, "NUMBER": NUMBERS, "TIME": TIMES, "AND": ("and", ",", ";")}
    state = known.parser.parse_interactive()
    said: list[str] = []
    last = ""
    names: Sequence[str] = [sample.name for sample in world.samples]
    while True:
        kinds = sorted(state.accepts())
        is_whole = END in kinds and last in ("WORD", "TIME", "UNIT", "EMPTY", "ENDED")
        if END in kinds and (len(said) >= LONGEST or chance.random() < (0.25 if is_whole else 0.02)):
            return " ".join(said)
        weights = [_weight(kind, last) for kind in kinds]
        kind = chance.choices(kinds, weights)[0]
        if kind == END:
            continue
        names = _fitting(kind, verbs.by_word.get(said[-1]) if said else None, world) or names
        choices = names if kind == "WORD" else words.get(kind) or known.words[kind]
        last = kind
        said.append(chance.choice(NOUNS if kind == "WORD" and chance.random() < 0.1 else choices))
        state.feed_token(Token(kind, said[-1]))


def _weight(kind: str, last: str) -> float:
    """How likely a kind of word is: a verb where there may be one, seldom a second word of a name."""
    if kind == "VERB":
        return 400.0
    if kind == "WORD":
        return 0.1 if last == "WORD" else 60.0
    if kind == "TO":
        return 20.0 if last == "WORD" else 0.1
    if kind == "KEEP":
        return 40.0
    if kind in ("UNTIL", "FOR", "IS", "ENDED"):
        return 4.0
    return 3.0 if kind in ("AND", "THEN", "TIME", "ALL", "WITH") else 0.3


def _fitting(kind: str, verb: Verb | None, world: WorldFile) -> Sequence[str]:
    """The names that fit after the word before; empty if those that fitted it still do."""
    things = {
        Kind.SAMPLE: [sample.name for sample in world.samples],
        Kind.ROBOT: [robot.name for robot in world.robots],
        Kind.PLACE: [*world.places_by_location],
    }
    if verb is not None:
        return things[verb.object_kind]
    if kind in ("WITH", "WITHOUT"):
        return things[Kind.ROBOT]
    if kind == "UNTIL":
        return (*things[Kind.SAMPLE], *things[Kind.ROBOT], "mission-1", "goal-1")
    if kind in ("FROM", "OF"):
        areas = [area.name for one in world.compartments for area in (one, *one.aisles)]
        return (*things[Kind.PLACE], *areas)
    if kind == "KEEP":
        return (*things[Kind.PLACE], *things[Kind.SAMPLE], *things[Kind.ROBOT])
    return things[Kind.PLACE] if kind in ("TO", "IN", "AVOIDING", "THROUGH") else ()


def damaged(chance: random.Random, text: str) -> str:
    """The text with a word or a letter lost, doubled or replaced."""
    parts: list[str] = list(text) if chance.random() < 0.5 else text.split(" ")
    joint = "" if len(parts) == len(text) else " "
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(parts) + 1)
        letter = chance.choice(string.printable + "İ²０\u20e3а")
        parts[at : at + chance.randint(0, 2)] = chance.choice([[], [letter], parts[at : at + 1] * 2])
    return joint.join(parts)[:1000]


def outcome(
    text: str, world: WorldFile, facts: Facts, knowledge_base: KnowledgeBase, verbs: Verbs
) -> Understood | Clarification:
    """What the service makes of the sentence: understood and checked, or asked about and completed."""
    understood = understand(
        text,
        world,
        facts,
        verbs=verbs,
        now=NOW,
        missions=lambda: {"mission-1": 30.0},
        goals=lambda: ("goal-1",),
    )
    if isinstance(understood, Clarification):
        assert understood.code
        assert understood.detail
        if understood.span is not None:
            start, end = understood.span
            assert 0 <= start <= end <= len(text), understood
        completions(text, understood, world, facts, verbs)
    else:
        assert understood.goals or understood.holds
        constraints = understood.constraints.and_also(kept_by(understood.holds))
        emptying = goals_of_holds(understood.holds, understood.goals, world, facts, within=constraints)
        more = () if isinstance(emptying, Clarification) else emptying[0]
        check_holds(understood.holds, world, facts, knowledge_base, NOW)
        check_request((*understood.goals, *more), constraints, world, facts, knowledge_base)
    return understood


def main(sentences: int = 10_000, seed: int = 0) -> None:
    chance = random.Random(seed)
    world = load_world("sample_store")
    knowledge_base = load_knowledge_base()
    verbs = shipped_verbs()
    beliefs: Sequence[Facts] = (initial_facts(world, knowledge_base), frozenset())
    counts: Counter[str] = Counter()
    longest_s = 0.0
    for number in range(sentences):
        text = drawn_sentence(chance, world, verbs)
        if number % 2:
            text = damaged(chance, text)
        begun_s = time.process_time()
        found = outcome(text, world, beliefs[number % 10 == 0], knowledge_base, verbs)
        longest_s = max(longest_s, time.process_time() - begun_s)
        counts["understood" if isinstance(found, Understood) else found.code] += 1
    told = ", ".join(f"{name}: {count}" for name, count in counts.most_common())
    print(f"{sentences} sentences, no exception; the longest took {longest_s * 1000:.0f} ms ({told})")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
