"""Operators without their deletes, as rules: the head comes about once the whole body holds."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from planner.knowledge import KnowledgeBase, Operator
from planner.knowledge.literal import Literal

FUNCTION = "function:"
TYPE = "type:"
GOAL = "goal:"
"""Prefixes of predicates that are not the knowledge base's: a function has a value for these arguments, an
object is of a type, a fact was brought about on purpose or held from the start."""
FROM = "from:"
BETWEEN = "between:"
TO = "to:"
"""Prefixes that together say that a function of two objects has a value: the first is of a class of objects from which
there is one to the class of the second. Where there are many pairs there are few classes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """Terms of head and body are the variables that `types` names, or constants."""

    head: Literal
    body: tuple[Literal, ...]
    types: Mapping[str, str]
    distinct: tuple[tuple[str, str], ...]

    @property
    def literals(self) -> tuple[Literal, ...]:
        """The body, with the types of the head's variables that nothing else binds."""
        bound = {term for literal in self.body for term in literal.terms}
        loose = dict.fromkeys(t for t in self.head.terms if t in self.types and t not in bound)
        return (*self.body, *(Literal(TYPE + self.types[term], (term,)) for term in loose))


def rules_of(
    knowledge_base: KnowledgeBase,
    goal_predicates: Collection[str],
    phased: Collection[str],
    *,
    with_functions: bool = True,
    by_class: bool = False,
    is_chained: bool = False,
) -> list[Rule]:
    """A rule for each operator and effect, and for each intended effect that is a goal's predicate.

    An effect within an action takes only what the action needs up to then.

    :param phased: the operators of which phases count.
    :param by_class: values of functions of two objects of a type are stated by `FROM`, `BETWEEN` and `TO`.
    :param is_chained: True: also what some phase of an action brings about where one before it has ended already.
    """
    rules = []
    steps = knowledge_base.steps if is_chained else _unchained(knowledge_base, phased)
    for op in steps:
        defined = tuple(_defined(op)) if with_functions else ()
        types = dict(op.parameters)
        if by_class:
            defined, classes = _by_class(defined, knowledge_base)
            types |= classes
        body = (*defined, *op.preconditions)
        heads = [*op.intended_effects, *op.other_effects]
        heads += [
            Literal(GOAL + effect.predicate, effect.terms)
            for effect in op.intended_effects
            if effect.predicate in goal_predicates
        ]
        distinct = tuple(op.distinct)
        rules += [Rule(head=head, body=body, types=types, distinct=distinct) for head in dict.fromkeys(heads)]
    return rules


def _unchained(knowledge_base: KnowledgeBase, phased: Collection[str]) -> Iterator[Operator]:
    """The operators; phases with what those before them need, instead of what shows that these have ended."""
    chaining = knowledge_base.under_way
    for op in knowledge_base.operators:
        needs: dict[Literal, None] = {}
        for step in knowledge_base.steps_of(op) if op.name in phased else (op,):
            if step is op:
                yield op
                continue
            needs |= dict.fromkeys(one for one in step.preconditions if one.predicate not in chaining)
            intended = tuple(one for one in step.intended_effects if one.predicate not in chaining)
            yield replace(step, preconditions=tuple(needs), intended_effects=intended)


def _defined(op: Operator) -> Iterator[Literal]:
    """The functions that the operator's duration needs."""
    calls = {
        Literal(FUNCTION + name, tuple(member.get(term, term) for term in terms))
        for name, terms in op.duration.calls
        for member in op.members
    }
    return iter(sorted(calls, key=str))


def _by_class(
    defined: Sequence[Literal], knowledge_base: KnowledgeBase
) -> tuple[tuple[Literal, ...], dict[str, str]]:
    """What functions have values for, by classes where these are of two objects of a type; the classes' variables, with
    that type: there are no more classes than objects."""
    body: list[Literal] = []
    variables: dict[str, str] = {}
    for literal in defined:
        name = literal.predicate.removeprefix(FUNCTION)
        if not is_between_alike(name, knowledge_base):
            body.append(literal)
            continue
        first, second = literal.terms
        here, there = f"{literal} from", f"{literal} to"
        variables |= dict.fromkeys((here, there), knowledge_base.file.functions[name][0])
        body += [
            Literal(FROM + name, (first, here)),
            Literal(BETWEEN + name, (here, there)),
            Literal(TO + name, (second, there)),
        ]
    return tuple(body), variables


def is_between_alike(function: str, knowledge_base: KnowledgeBase) -> bool:
    """Whether the function is of two objects of a type; what scales durations is none of the knowledge base's."""
    kinds = knowledge_base.file.functions.get(function, ())
    return len(kinds) == 2 and kinds[0] == kinds[1]


def positions_needed(
    rules: Sequence[Rule], knowledge_base: KnowledgeBase, whole: Collection[str]
) -> dict[str, tuple[int, ...]]:
    """For each predicate the positions of its arguments that make a difference to what is reached.

    A position makes none if every rule leaves its variable free: then one reached value is as good as any.
    Keeping only the others keeps the relations small.

    :param whole: predicates of which every argument matters. Predicates that nothing needs are left out.
    """
    needed = {name: set(range(len(argument_types(name, knowledge_base)))) for name in whole}
    while True:
        before = {predicate: len(positions) for predicate, positions in needed.items()}
        for rule in rules:
            if rule.head.predicate in needed:
                _need(rule, knowledge_base, needed)
        if before == {predicate: len(positions) for predicate, positions in needed.items()}:
            return {predicate: tuple(sorted(positions)) for predicate, positions in needed.items()}


def _need(rule: Rule, knowledge_base: KnowledgeBase, needed: dict[str, set[int]]) -> None:
    """Add what the rule's body needs, given what is needed of its head."""
    terms = [term for literal in rule.literals for term in literal.terms]
    head = {term for i, term in enumerate(rule.head.terms) if i in needed[rule.head.predicate]}
    for literal in rule.literals:
        positions = needed.setdefault(literal.predicate, set())
        kinds = argument_types(literal.predicate, knowledge_base)
        for index, term in enumerate(literal.terms):
            is_free = term in rule.types and term not in head and terms.count(term) == 1
            if not is_free or rule.types[term] != kinds[index]:
                positions.add(index)


def argument_types(predicate: str, knowledge_base: KnowledgeBase) -> tuple[str, ...]:
    """The types of a predicate's arguments, also of those with a prefix."""
    if predicate.startswith(TYPE):
        return (predicate.removeprefix(TYPE),)
    if predicate.startswith((FUNCTION, FROM, BETWEEN, TO)):
        return knowledge_base.file.functions[predicate.partition(":")[2]]
    return tuple(knowledge_base.predicates[predicate.removeprefix(GOAL)].arguments.values())
