"""Sentences to clauses by the grammar in `goals.lark`; what may stand next is read from the same grammar."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.sentence import Clause, Part, Phrase, Quantity, Tail
from app.domain.goal_language.tokens import Token, number_of, tokens_of
from app.domain.goal_language.verbs import Verbs
from app.domain.goal_language.words import joined

GRAMMAR = "goals.lark"
JOINTS = ("AND", "THEN")
AFTER_NAME = (
    *JOINTS,
    "TO",
    "IN",
    "FROM",
    "OF",
    "WITH",
    "WITHOUT",
    "NOT",
    "AVOIDING",
    "THROUGH",
    "BY",
    "BEFORE",
    "AFTER",
    "WITHIN",
    "PREFERABLY",
)
"""The kinds of words that may follow a name."""
OPEN = ("VERB", "NUMBER", "WORD")
"""The kinds of words that the grammar does not list."""
SECONDS = {"s": 1.0, "m": 60.0, "h": 3600.0}
"""By the first letter of a unit of time."""
END = "$END"


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How far a text is a sentence.

    :param clauses: what is said so far; empty if the text is no sentence.
    :param next_kinds: the kinds of words that may follow.
    """

    clauses: tuple[Clause, ...]
    next_kinds: frozenset[str]


@dataclass(frozen=True)
class Grammar:
    """The grammar's parser, and the words of its terminals.

    :param patterns: terminal → pattern of its words.
    :param words: terminal → its words, for those that list them.
    """

    parser: Any
    patterns: Mapping[str, re.Pattern[str]]
    words: Mapping[str, tuple[str, ...]]

    def kinds(self, word: str, verbs: Verbs) -> list[str]:
        """The kinds of the word, keywords before names."""
        found = ["VERB"] if word in verbs.by_word else []
        found += [name for name, pattern in self.patterns.items() if pattern.fullmatch(word)]
        if number_of(word) is not None:
            found.append("NUMBER")
        if word not in (",", ";"):
            found.append("WORD")
        return found

    def words_for(self, kinds: Iterable[str], verbs: Verbs) -> tuple[str, ...]:
        """The words of these kinds, as far as they are listed."""
        every = [*(word for kind in kinds for word in self.words.get(kind, ()) if len(word) > 1)]
        if "VERB" in kinds:
            every.extend(verbs.words)
        return tuple(sorted(every))


@cache
def grammar() -> Grammar:
    """The grammar, read once."""
    # NOTE: imported here: commands that read no sentence do not load the parser's library.
    from lark import Lark

    text = (resources.files("app.domain.goal_language") / GRAMMAR).read_text()
    parser = Lark(text, start="sentence", parser="lalr")
    patterns = {one.name: re.compile(one.pattern.to_regexp()) for one in parser.terminals}
    listed = {one.name: re.sub(r"^\(\?:|\)$", "", one.pattern.value).split("|") for one in parser.terminals}
    words = {name: tuple(sorted(w for w in some if w.isalpha())) for name, some in listed.items()}
    return Grammar(parser, patterns, {name: some for name, some in words.items() if some})


def parse(text: str, verbs: Verbs) -> Progress | Clarification:
    """The clauses of a sentence, or the first word that cannot stand where it does."""
    from lark import Token as LarkToken

    known = grammar()
    tokens = _with_single_joints(tokens_of(text), known)
    state = known.parser.parse_interactive()
    if not tokens:
        return Progress(clauses=(), next_kinds=frozenset(state.accepts()))
    for token in tokens:
        possible = state.accepts()
        kind = next((kind for kind in known.kinds(token.word, verbs) if kind in possible), None)
        if kind is None:
            return _misplaced(token, possible - {END}, known, verbs)
        state.feed_token(LarkToken(kind, token.word, start_pos=token.start, end_pos=token.end))
    possible = state.accepts()
    if END not in possible:
        return _unfinished(tokens[-1], possible, known, verbs)
    tree = state.feed_eof(LarkToken(END, "", start_pos=len(text), end_pos=len(text)))
    return Progress(clauses=tuple(_clauses(tree)), next_kinds=frozenset(possible))


def _with_single_joints(tokens: Sequence[Token], known: Grammar) -> list[Token]:
    """The tokens with one joint where several follow each other (", and then"), and none at the ends."""
    joints = {joint: known.patterns[joint] for joint in JOINTS}
    found: list[Token] = []
    pending: Token | None = None
    for token in tokens:
        if any(pattern.fullmatch(token.word) for pattern in joints.values()):
            if pending is None or joints["THEN"].fullmatch(token.word):
                pending = token
            continue
        if pending is not None and found:
            found.append(pending)
        pending = None
        found.append(token)
    return found


def _misplaced(token: Token, possible: Collection[str], known: Grammar, verbs: Verbs) -> Clarification:
    words = known.words_for(possible, verbs)
    hint = f"; it could go on with {joined(words)}" if words else ""
    return Clarification(
        code="goal-not-understood",
        detail=f"{token.word!r} cannot stand here{hint}",
        thing=token.word,
        choices=words,
        span=(token.start, token.end),
    )


def _unfinished(last: Token, possible: Collection[str], known: Grammar, verbs: Verbs) -> Clarification:
    words = known.words_for(possible, verbs)
    return Clarification(
        code="goal-not-understood",
        detail=f"something is missing after {last.word!r}" + (f": {joined(words)}" if words else ""),
        choices=words,
        span=(last.end, last.end),
    )


def _clauses(tree: Any) -> Iterable[Clause]:
    stage = 0
    for child in tree.children:
        if _is_token(child):
            stage += child.type == "THEN"
        else:
            yield _clause(child, stage)


def _clause(tree: Any, stage: int) -> Clause:
    leaves = _leaves(tree)
    clause = Clause(
        first=str(leaves[0]),
        first_span=(leaves[0].start_pos, leaves[0].end_pos),
        object_at=leaves[0].start_pos,
        span=(leaves[0].start_pos, leaves[-1].end_pos),
        is_keep=tree.data in ("keep", "preferred_keep"),
        is_preferred=tree.data == "preferred_keep",
        is_keep_on=tree.data == "keep_on",
        says_empty=any(_is_token(child) and child.type == "EMPTY" for child in tree.children),
        stage=stage,
    )
    for child in tree.children:
        if _is_token(child):
            if child.type == "VERB":
                clause.verb = str(child)
            if child.type in ("VERB", "KEEP"):
                clause.object_at = child.end_pos
        elif child.data == "phrase" and tree.data == "delegated" and not clause.verb:
            clause.agent = _phrase(child)
        elif child.data == "phrase":
            clause.objects.append(_phrase(child))
        else:
            clause.tails.append(_tail(child))
    return clause


def _phrase(tree: Any) -> Phrase:
    parts = {child.data: child for child in tree.children}
    said = {name: tuple(map(str, _leaves(part))) for name, part in parts.items()}
    whole = tuple(_leaves(parts["whole"]))[1:] if "whole" in parts else ()  # without "of"
    phrase = Phrase(
        words=said.get("name", ()),
        word_spans=_spans_of(_leaves(parts["name"])) if "name" in parts else (),
        span=_span_of(_leaves(tree)),
        whole=tuple(map(str, whole)),
        whole_word_spans=_spans_of(whole),
        whole_span=_span_of(whole) if whole else (0, 0),
    )
    if "quantity" not in parts:
        return phrase
    amount = {leaf.type: str(leaf) for leaf in _leaves(parts["quantity"])}
    if amount.keys() == {"NUMBER"} and not phrase.words and not whole:
        return replace(phrase, words=(amount["NUMBER"],))  # a number alone is a name
    count = int(number_of(amount["NUMBER"]) or 0) if "NUMBER" in amount else 0
    kinds = {"OTHER": Quantity.OTHER, "NUMBER": Quantity.COUNT, "ALL": Quantity.ALL, "ANY": Quantity.ANY}
    quantity = next(quantity for kind, quantity in kinds.items() if kind in amount)
    return replace(phrase, quantity=quantity, count=count)


def _leaves(tree: Any) -> list[Any]:
    return list(tree.scan_values(_is_token))


def _spans_of(leaves: Sequence[Any]) -> tuple[tuple[int, int], ...]:
    return tuple((leaf.start_pos, leaf.end_pos) for leaf in leaves)


def _span_of(leaves: Sequence[Any]) -> tuple[int, int]:
    return leaves[0].start_pos, leaves[-1].end_pos


def _tail(tree: Any) -> Tail:
    leaves = _leaves(tree)
    if tree.data == "preferred":
        return replace(_tail(tree.children[-1]), is_preferred=True, span=_span_of(leaves))
    said = {leaf.type: str(leaf) for leaf in leaves}
    parts = [child for child in tree.children if not _is_token(child)]
    phrases = [part for part in parts if part.data == "phrase"]
    places = [
        child for part in parts if part.data == "state" for child in part.children if not _is_token(child)
    ]
    amount = number_of(said["NUMBER"]) if "NUMBER" in said else None
    seconds = 0.0
    if "UNIT" in said:
        seconds = (1.0 if amount is None else amount) * SECONDS[said["UNIT"][0]]
    elif tree.data == "cost" and amount is not None:
        seconds = amount
    end = leaves[-1].end_pos
    return Tail(
        part=Part(tree.data),
        phrase=_phrase(phrases[0]) if phrases else Phrase(span=(end, end)),
        place=_phrase(places[0]) if places else None,
        says_is="IS" in said,
        says_empty="EMPTY" in said,
        has_number="NUMBER" in said,
        has_unit="UNIT" in said,
        time=said.get("TIME", ""),
        is_before="BEFORE" in said,
        seconds=seconds,
        span=(leaves[0].start_pos, end),
    )


def _is_token(node: Any) -> bool:
    return hasattr(node, "type")
