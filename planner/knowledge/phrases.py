"""Facts as text, from the phrases that the knowledge base gives its predicates."""

import re
from collections.abc import Iterable, Sequence

from planner.fact import Fact
from planner.knowledge import KnowledgeBase


def phrase(knowledge_base: KnowledgeBase, fact: Fact) -> str:
    """`store_2 reaches bay_7`; without a phrase in the knowledge base: `reaches(store_2, bay_7)`."""
    spec = knowledge_base.predicates.get(fact.predicate)
    if spec is None or not spec.phrase:
        return str(fact)
    return spec.phrase.format(**dict(zip(spec.arguments, fact.args, strict=True)))


def denial(knowledge_base: KnowledgeBase, fact: Fact) -> str:
    """`store_2 does not reach bay_7`; without words for it: `reaches(store_2, bay_7) does not hold`."""
    spec = knowledge_base.predicates.get(fact.predicate)
    if spec is None or not spec.denial:
        return f"{fact} does not hold"
    return spec.denial.format(**dict(zip(spec.arguments, fact.args, strict=True)))


def nothing(knowledge_base: KnowledgeBase, fact: Fact, position: int, kind: str) -> str:
    """`no robot reaches bay_7`: the fact holds of nothing of this kind in place of its argument there."""
    spec = knowledge_base.predicates.get(fact.predicate)
    if spec is None or not spec.phrase:
        return f"there is no {kind} x with {_marked(fact, position, 'x')}"
    return phrase(knowledge_base, _marked(fact, position, f"no {kind}"))


def clause(knowledge_base: KnowledgeBase, fact: Fact, position: int) -> str:
    """`that can DOCK`: the fact as a clause on its argument at the position; empty if it makes none."""
    words = phrase(knowledge_base, _marked(fact, position, "\0"))
    return f"that {words[2:]}" if words.startswith("\0 ") else ""


def _marked(fact: Fact, position: int, mark: str) -> Fact:
    return Fact(fact.predicate, (*fact.args[:position], mark, *fact.args[position + 1 :]))


def enumeration(names: Sequence[str], word: str = "and", *, most: int = 8) -> str:
    """`a, b and c`; no more than `most` of them are named."""
    shown = list(names[:most])
    if len(names) > most:
        return f"{', '.join(shown)} {word} {len(names) - most} more"
    return f" {word} ".join(part for part in (", ".join(shown[:-1]), *shown[-1:]) if part)


def naturally_sorted(names: Iterable[str]) -> list[str]:
    """In the order a reader expects: bay_2 before bay_10."""
    return sorted(
        names, key=lambda name: [(part.isdigit() and int(part), part) for part in re.split(r"(\d+)", name)]
    )
