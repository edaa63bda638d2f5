"""The schema of a knowledge base file: what each slot of table 3 may hold (MACTA §5)."""

from collections.abc import Iterable, Mapping, Sequence
from string import Formatter
from typing import Self

from pydantic import Field, model_validator

from planner.errors import KnowledgeBaseError
from planner.knowledge.action import (
    LITERAL_SLOTS,
    PRECONDITIONS,
    USUAL_SPANS,
    ActionSpec,
    Formula,
    ParameterSpec,
    Slot,
    Tag,
    VariantSpec,
    Word,
    span_in,
)
from planner.knowledge.change import DISTANCE, DURATION, ENERGY, OWN_TERMS, WAITING, NumberChange
from planner.knowledge.comparison import Comparison, number_words, read_comparison, value_words
from planner.knowledge.expression import DURATION_SCALE, Expression
from planner.knowledge.literal import Literal
from planner.knowledge.timing import UNDER_WAY

TIME = "time"
RELATION = "relation"
VALUE = "value"
"""The number in a quantity's phrase."""
ANY = "any"
"""Whatever stands there, in what a quantity counts."""


class TypeSpec(Slot):
    """A type; its constants are `values` and, with `action_names`, the actions' names."""

    parent: Word | None = None
    values: tuple[Word | Tag, ...] = ()
    action_names: bool = False


class PredicateSpec(Slot):
    """A predicate's typed arguments and how the world relates to it.

    relational: argument 1 is a relation, so the fact is also written rel(args without it).
    sensed: robots can perceive it (if `sensed_when` names arguments: only where one of those has that type).
    make_way: an action may be planned to bring this about though it is only among its other effects.
    held_by: of a zone: nobody's position, a fact of that predicate, is in it; actions whose agents enter the zone
     need and end that, and those that leave bring it about, without stating so (`planner.problem.zones`).
    asked_by: of a state of a door, hatch or lift: predicates of positions, each with the place as its last argument.
     Whatever changes one of these asks for the state where its way or its place does, without stating so
     (`planner.problem.access`).
    on_ways: of places that lie between others; the small worlds that are searched first hold them (our choice).
    each_time: it tells of something done, such as a picture taken: as a goal it is to be achieved although it is true.
    phrase: what an operator reads where it holds, e.g. `{robot} reaches {location}`; `denial`: where not.
    """

    arguments: dict[Word, Word]
    relational: bool = False
    sensed: bool = False
    sensed_when: dict[Word, Word] = Field(default_factory=dict)
    make_way: bool = False
    each_time: bool = False
    held_by: Word | None = None
    asked_by: tuple[Word, ...] = ()
    on_ways: bool = False
    phrase: str = ""
    denial: str = ""


class QuantitySpec(Slot):
    """What numeric facts tell of their arguments, such as the battery of a robot.

    unit: of the value, as an operator reads it; `share` is 0 to 1 and read as a percentage.
    range: the least and the greatest value; null: unlimited.
    counts: facts whose number it is, e.g. `object_position(any, in, robot)`; it cannot be set then.
    kept: the least and the greatest value that plans let it have; null: any (`planner.problem.number_courses`).
    used: by how much it falls by each action of an agent that is its one argument, e.g. `energy() / capacity_j(robot)`.
    drain: by how much it falls a second while no action changes it, e.g. `(5 + waiting()) / capacity_j(robot)`; there,
     `waiting()` is of the action that is to change it next.
    phrase: what an operator reads, e.g. `{robot}'s battery is at {value}`.
    """

    arguments: dict[Word, Word] = Field(min_length=1)
    unit: str = Field(default="", max_length=40)
    range: tuple[float | None, float | None] = (None, None)
    counts: str = ""
    kept: tuple[float | None, float | None] = (None, None)
    used: Formula = "0"
    drain: Formula = "0"
    phrase: str = ""

    @property
    def is_kept(self) -> bool:
        """True if plans keep it within limits."""
        return self.kept != (None, None)

    @property
    def span(self) -> float:
        """How far its values lie apart; 1 if its range is not limited at both ends."""
        least, most = self.range
        return 1.0 if least is None or most is None else most - least

    def admits(self, value: float) -> bool:
        """True if the value lies within the range."""
        least, most = self.range
        return (least is None or value >= least) and (most is None or value <= most)

    def words(self, name: str, args: Iterable[str], value: float) -> str:
        """The number as an operator reads it: `rover_1's battery is at 80 %`.

        :param name: of the quantity.
        """
        fields = dict(zip(self.arguments, args, strict=True))
        if not self.phrase:
            return f"{name}({', '.join(fields.values())}) is {value_words(value, self.unit)}"
        return self.phrase.format(**fields, **{VALUE: value_words(value, self.unit)})

    @property
    def range_words(self) -> str:
        """`0 to 1`, `at least 0`; empty without limits."""
        least, most = (None if limit is None else number_words(limit) for limit in self.range)
        if least is not None and most is not None:
            return f"{least} to {most}"
        return f"at least {least}" if least is not None else f"at most {most}" if most is not None else ""


class KnowledgeBaseFile(Slot):
    """A whole knowledge base."""

    types: dict[Word, TypeSpec]
    functions: dict[Word, tuple[Word, ...]] = Field(default_factory=dict)
    predicates: dict[Word, PredicateSpec]
    quantities: dict[Word, QuantitySpec] = Field(default_factory=dict)
    actions: tuple[ActionSpec, ...] = Field(min_length=1)

    def comparisons(self) -> tuple[Comparison, ...]:
        """The comparisons that pre-conditions of actions make, each once."""
        owners: list[ActionSpec | VariantSpec] = []
        for action in self.actions:
            owners += [action, *action.variants]
        texts = (span_in(PRECONDITIONS, text)[0] for owner in owners for text in owner.preconditions)
        read = map(read_comparison, texts)
        return tuple(dict.fromkeys(one[0] for one in read if one is not None))

    def constants(self, type_name: str) -> tuple[str, ...]:
        spec = self.types[type_name]
        names = (action.name for action in self.actions if spec.action_names)
        return tuple(dict.fromkeys((*names, *spec.values)))

    def is_a(self, type_name: str, ancestor: str) -> bool:
        step: str | None = type_name
        while step is not None and step != ancestor:
            step = self.types[step].parent if step in self.types else None
        return step == ancestor

    @model_validator(mode="after")
    def _check(self) -> Self:
        self._check_vocabulary()
        for slot in ("identifier", "name"):
            _all_differ([getattr(action, slot) for action in self.actions], f"actions.{{}}.{slot}")
        owners: dict[str, str] = {}
        for kind in self.types:
            for value in self.constants(kind):
                if value in owners:
                    raise _at(f"types.{kind}.values", f"{value} is a constant of {owners[value]} already")
                owners[value] = kind
        for index, action in enumerate(self.actions):
            _check_action(self, action, f"actions.{index}")
        return self

    def _check_vocabulary(self) -> None:
        for name, spec in self.types.items():
            if spec.parent is not None:
                _known("type", spec.parent, self.types, f"types.{name}.parent")
        for name in self.types:
            self._check_ancestry(name)
        for name, arguments in self.functions.items():
            if name in (DURATION_SCALE, DURATION[0], DISTANCE[0], ENERGY[0]):
                raise _at(f"functions.{name}", "every knowledge base has it already; choose another name")
            for argument in arguments:
                _known("type", argument, self.types, f"functions.{name}")
        for name, predicate in self.predicates.items():
            self._check_predicate(name, predicate)
        for name, quantity in self.quantities.items():
            self._check_quantity(name, quantity)

    def _check_ancestry(self, name: str) -> None:
        line = [name]
        while (parent := self.types[line[-1]].parent) is not None:
            if parent in line:
                raise _at(
                    f"types.{name}.parent", f"a type is its own ancestor: {' < '.join([*line, parent])}"
                )
            line.append(parent)

    def _check_predicate(self, name: str, predicate: PredicateSpec) -> None:
        where = f"predicates.{name}"
        for argument, type_name in predicate.arguments.items():
            _known("type", type_name, self.types, f"{where}.arguments.{argument}")
        kinds = list(predicate.arguments.values())
        if predicate.relational and kinds[1:2] != [RELATION]:
            raise _at(
                f"{where}.relational",
                f"argument 1 of a relational predicate is a {RELATION}, not {kinds[1:2]}",
            )
        if predicate.held_by is not None:
            _known("predicate", predicate.held_by, self.predicates, f"{where}.held_by")
            if len(predicate.arguments) != 1:
                raise _at(f"{where}.held_by", f"{name} takes one argument, the zone")
        for position in predicate.asked_by:
            _known("predicate", position, self.predicates, f"{where}.asked_by")
        for argument, type_name in predicate.sensed_when.items():
            _known("argument", argument, predicate.arguments, f"{where}.sensed_when")
            _known("type", type_name, self.types, f"{where}.sensed_when.{argument}")
        for slot in ("phrase", "denial"):
            _check_fields(getattr(predicate, slot), "argument", predicate.arguments, f"{where}.{slot}")

    def _check_quantity(self, name: str, quantity: QuantitySpec) -> None:
        where = f"quantities.{name}"
        for other, taken in (("predicate", self.predicates), ("function", self.functions)):
            if name in taken:
                raise _at(where, f"{name} is a {other} already; choose another name")
        for argument, type_name in quantity.arguments.items():
            _known("type", type_name, self.types, f"{where}.arguments.{argument}")
        least, most = quantity.range
        if least is not None and most is not None and least > most:
            raise _at(f"{where}.range", f"{number_words(least)} is more than {number_words(most)}")
        if VALUE in quantity.arguments:
            raise _at(f"{where}.arguments.{VALUE}", f"{VALUE} is the number itself; choose another name")
        _check_fields(quantity.phrase, "argument", (*quantity.arguments, VALUE), f"{where}.phrase")
        for bound in quantity.kept:
            if bound is not None and not quantity.admits(bound):
                raise _at(f"{where}.kept", f"{name} is {quantity.range_words}, not {number_words(bound)}")
        _check_expression(self, quantity.arguments, quantity.drain, f"{where}.drain", own=(WAITING,))
        _check_expression(self, quantity.arguments, quantity.used, f"{where}.used", own=OWN_TERMS)
        if quantity.used != "0" and len(quantity.arguments) != 1:
            raise _at(f"{where}.used", f"{name} takes one argument, the agent")
        if quantity.counts:
            if quantity.is_kept or (quantity.drain, quantity.used) != ("0", "0"):
                raise _at(f"{where}.counts", f"{name} is counted from facts, so that plans cannot keep it")
            types = {ANY: "", **quantity.arguments}
            _check_literal(self, types, quantity.counts, f"{where}.counts")


def _check_action(base: KnowledgeBaseFile, action: ActionSpec, where: str) -> None:
    names = [parameter.name for parameter in action.parameters]
    _all_differ(names, f"{where}.parameters.{{}}.name")
    for position, parameter in enumerate(action.parameters):
        _check_parameter(base, parameter, names, f"{where}.parameters.{position}")
    for agent in action.agents:
        _known("parameter", agent, names, f"{where}.agents")
    bound = [parameter.name for parameter in action.parameters if parameter.type != TIME]
    for position, pair in enumerate(action.distinct or ()):
        for name in pair:
            _known("parameter", name, bound, f"{where}.distinct.{position}")
    types = {parameter.name: parameter.type for parameter in action.parameters}
    _check_literals(base, action, types, where)
    for position, text in enumerate(action.phases_when):
        _check_static(base, types, text, f"{where}.phases_when.{position}")
    for position, variant in enumerate(action.variants):
        _check_variant(base, action, variant, f"{where}.variants.{position}")
        _check_times(base, action, variant, where)
    _check_expression(base, types, action.duration, f"{where}.duration")
    _check_expression(base, types, action.distance, f"{where}.distance")
    _check_expression(base, types, action.energy, f"{where}.energy", own=(DURATION, DISTANCE))
    _check_changes(base, action, types, where)
    _check_fields(action.description, "parameter", names, f"{where}.description")


def _check_changes(base: KnowledgeBaseFile, action: ActionSpec, types: Mapping[str, str], where: str) -> None:
    """Check the numbers that an action changes, and the one that its duration depends on."""
    for position, text in enumerate(action.changes):
        place = f"{where}.changes.{position}"
        try:
            change = NumberChange.parse(text)
        except KnowledgeBaseError as error:
            raise _at(place, str(error)) from error
        _known("quantity", change.quantity, base.quantities, place)
        quantity = base.quantities[change.quantity]
        if quantity.counts:
            raise _at(place, f"{change.quantity} is counted from facts; change these")
        _check_terms(base, types, Literal(change.quantity, change.terms), quantity.arguments, place)
        _check_expression(base, types, change.amount.text, place, own=OWN_TERMS)
    if action.until:
        place = f"{where}.until"
        if not _check_comparison(base, types, action.until, place):
            raise _at(place, f"{action.until!r} is not of the form quantity(term, …) <= number, or with >=")
        read = read_comparison(action.until)
        changed = [NumberChange.parse(text) for text in action.changes]
        if read is None or (read[0].quantity, read[1]) not in [(one.quantity, one.terms) for one in changed]:
            raise _at(place, f"{action.name} does not change that number: state it in `changes`")


def _check_parameter(base: KnowledgeBaseFile, parameter: ParameterSpec, names: list[str], where: str) -> None:
    _known("type", parameter.type, base.types, f"{where}.type")
    _all_differ(parameter.teams, f"{where}.teams.{{}}")
    for value in parameter.values:
        _known(parameter.type, value, base.constants(parameter.type), f"{where}.values")
    if parameter.type == RELATION:
        if not parameter.values:
            raise _at(
                f"{where}.values", f"a relation names its choices among {', '.join(base.constants(RELATION))}"
            )
        reference = parameter.name.replace("rel", "ref", 1)
        if reference not in names:
            raise _at(where, f"a relation has its reference: parameter {reference} is missing")


def _check_variant(base: KnowledgeBaseFile, action: ActionSpec, variant: VariantSpec, where: str) -> None:
    types = {parameter.name: parameter.type for parameter in action.parameters}
    for name, kind in variant.types.items():
        _known("parameter", name, types, f"{where}.types")
        narrower = [one for one in base.types if base.is_a(one, types[name])]
        _known(types[name], kind, narrower, f"{where}.types.{name}")
    for name, size in variant.teams.items():
        lists = {parameter.name: parameter.teams for parameter in action.parameters if parameter.teams}
        _known("list of robots", name, lists, f"{where}.teams")
        _known("size", str(size), [str(choice) for choice in lists[name]], f"{where}.teams.{name}")
    _check_literals(base, variant, {**types, **variant.types}, where)
    if variant.duration is not None:
        _check_expression(base, types, variant.duration, f"{where}.duration")


def _check_times(base: KnowledgeBaseFile, action: ActionSpec, variant: VariantSpec, where: str) -> None:
    """Refuse what no order of whole actions could tell: a literal that the action holds only meanwhile."""
    chained = f"{UNDER_WAY}{action.name.lower()}_"
    taken = [name for name in base.predicates if name.startswith(chained)]
    timed = ((slot, span) for slot in LITERAL_SLOTS for _, span in action.timed(slot, variant))
    if taken and any(span != USUAL_SPANS[slot] for slot, span in timed):
        raise _at(
            where, f"it has times within it, so that predicates with {chained} are kept for it: {taken[0]}"
        )
    spans = {slot: dict(action.timed(slot, variant)) for slot in LITERAL_SLOTS}
    for slot in LITERAL_SLOTS:
        for literal, span in action.timed(slot, variant):
            if spans[slot][literal] != span:
                raise _at(f"{where}.{slot}", f"{literal} is there twice, at different times")
    for literal, deleted in spans["delete"].items():
        needed = spans[PRECONDITIONS].get(literal)
        if needed is not None and needed.begin.place > deleted.begin.place:
            raise _at(
                f"{where}.delete", f"{literal} is deleted at {deleted.begin}, but needed from {needed.begin}"
            )
        for slot in ("intended_effects", "other_effects"):
            made = spans[slot].get(literal)
            if made is not None and made.begin.place < deleted.begin.place:
                raise _at(
                    f"{where}.{slot}",
                    f"{literal} would hold only from {made.begin} to {deleted.begin}; let a further action end it",
                )


def _check_literals(
    base: KnowledgeBaseFile, owner: ActionSpec | VariantSpec, types: Mapping[str, str], where: str
) -> None:
    """:param types: of the action's parameters."""
    for slot in LITERAL_SLOTS:
        for position, text in enumerate(getattr(owner, slot)):
            place = f"{where}.{slot}.{position}"
            try:
                plain, _ = span_in(slot, text)
            except KnowledgeBaseError as error:
                raise _at(place, str(error)) from error
            if slot != PRECONDITIONS or not _check_comparison(base, types, plain, place):
                _check_literal(base, types, plain, place)


def _check_static(base: KnowledgeBaseFile, types: Mapping[str, str], text: str, where: str) -> None:
    _check_literal(base, types, text, where)
    predicate = Literal.parse(text).predicate
    changes = ("delete", "intended_effects", "other_effects")
    for action in base.actions:
        for variant in action.variants:
            if any(one.predicate == predicate for slot in changes for one in action.literals(slot, variant)):
                raise _at(where, f"{action.name} changes {predicate}; only what no action changes decides it")


def _check_comparison(base: KnowledgeBaseFile, types: Mapping[str, str], text: str, where: str) -> bool:
    """False if the text compares nothing."""
    try:
        read = read_comparison(text)
    except KnowledgeBaseError as error:
        raise _at(where, str(error)) from error
    if read is None:
        return False
    comparison, terms = read
    _known("quantity", comparison.quantity, base.quantities, where)
    quantity = base.quantities[comparison.quantity]
    _check_terms(base, types, Literal(comparison.quantity, terms), quantity.arguments, where)
    if not quantity.admits(comparison.number):
        number = number_words(comparison.number)
        raise _at(where, f"{comparison.quantity} is {quantity.range_words}, it cannot be {number}")
    _refuse_taken(comparison.predicate, base.predicates, where)
    return True


def _refuse_taken(predicate: str, predicates: Iterable[str], where: str) -> None:
    if predicate in predicates:
        raise _at(where, f"the predicate {predicate} would be the same; choose another name for it")


def _check_literal(base: KnowledgeBaseFile, types: Mapping[str, str], text: str, where: str) -> None:
    try:
        literal = Literal.parse(text)
    except KnowledgeBaseError as error:
        raise _at(where, str(error)) from error
    _known("predicate", literal.predicate, base.predicates, where)
    _check_terms(base, types, literal, base.predicates[literal.predicate].arguments, where)


def _check_terms(
    base: KnowledgeBaseFile,
    types: Mapping[str, str],
    literal: Literal,
    wanted: Mapping[str, str],
    where: str,
) -> None:
    """:param wanted: the arguments of the predicate or quantity, with their types."""
    if len(literal.terms) != len(wanted):
        raise _at(where, f"{literal.predicate} takes ({', '.join(wanted)}), not ({', '.join(literal.terms)})")
    parameters = {name: kind for name, kind in types.items() if kind != TIME}
    for term, (argument, type_name) in zip(literal.terms, wanted.items(), strict=True):
        if term == ANY and ANY in types:
            continue
        if term in parameters:
            if not base.is_a(parameters[term], type_name):
                raise _at(
                    where,
                    f"{term} is a {parameters[term]}, {argument} of {literal.predicate} a {type_name}",
                )
            continue
        choices = [
            *(c for kind in base.types if base.is_a(kind, type_name) for c in base.constants(kind)),
            *(name for name, kind in parameters.items() if base.is_a(kind, type_name)),
        ]
        _known(f"{type_name}", term, choices, where)


def _check_expression(
    base: KnowledgeBaseFile,
    types: Mapping[str, str],
    text: str,
    where: str,
    own: tuple[tuple[str, tuple[str, ...]], ...] = (),
) -> None:
    """:param types: of the parameters. :param own: terms the expression may have beside the functions."""
    try:
        calls = [call for call in Expression.parse(text).calls if call not in own]
    except KnowledgeBaseError as error:
        raise _at(where, str(error)) from error
    for name, terms in calls:
        _known("function", name, [*base.functions, *(f"{term}()" for term, _ in own)], where)
        for term in terms:
            _known("parameter", term, types, where)
        fits = len(terms) == len(base.functions[name]) and all(
            base.is_a(types[term], kind) for term, kind in zip(terms, base.functions[name], strict=True)
        )
        if not fits:
            raise _at(where, f"{name} takes ({', '.join(base.functions[name])}), not ({', '.join(terms)})")


def _check_fields(text: str, what: str, names: Iterable[str], where: str) -> None:
    try:
        fields = [field for _, field, _, _ in Formatter().parse(text) if field is not None]
    except ValueError as error:
        raise _at(where, f"{text!r} is no text with {{{what}}} in it: {error}") from error
    for field in fields:
        _known(what, field, names, where)


def _at(where: str, what: str) -> ValueError:
    return ValueError(f"{where}: {what}")


def _known(what: str, name: str, choices: Iterable[str], where: str) -> None:
    if name not in choices:
        raise _at(where, f"unknown {what} {name!r}; choices: {', '.join(sorted(choices))}")


def _all_differ(values: Sequence[object], where: str) -> None:
    """:param where: with {} for the position."""
    for position, value in enumerate(values):
        if value in values[:position]:
            raise _at(where.format(position), f"must be unique; used twice: {value}")
