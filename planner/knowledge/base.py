"""The knowledge base: plan-net actions and their vocabulary, as data (MACTA §4, fig. 4; §5, table 3)."""

import pickle
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, lru_cache

from planner.errors import KnowledgeBaseError
from planner.fact import Fact
from planner.knowledge.action import ActionSpec
from planner.knowledge.change import OWN_TERMS, WAITING
from planner.knowledge.comparison import Comparison, Numbers, Term
from planner.knowledge.expression import Expression, Functions
from planner.knowledge.literal import Literal
from planner.knowledge.operator import TEAM_SEPARATOR, GroundAction, Operator, operators_of
from planner.knowledge.phases import Phase, ground_phases, phases_of, under_way_predicate
from planner.knowledge.schema import RELATION, TIME, KnowledgeBaseFile, PredicateSpec, QuantitySpec


class KnowledgeBase:
    """Checked plan-net actions, predicates and types."""

    def __init__(self, file: KnowledgeBaseFile) -> None:
        self.file = file
        self.actions: Mapping[str, ActionSpec] = {action.name: action for action in file.actions}
        self.comparisons: Mapping[str, Comparison] = {one.predicate: one for one in file.comparisons()}
        """What actions compare with numbers, by the predicates that stand for it."""
        self.predicates: Mapping[str, PredicateSpec] = {
            **file.predicates,
            **{name: self._compared(one) for name, one in self.comparisons.items()},
            **dict(self._under_way(file)),
        }
        self.quantities: Mapping[str, QuantitySpec] = file.quantities
        self.operators: tuple[Operator, ...] = tuple(op for spec in file.actions for op in operators_of(spec))
        self.constants: Mapping[str, str] = {
            value: kind for kind in file.types for value in file.constants(kind)
        }
        """Each constant's type."""

    def _compared(self, comparison: Comparison) -> PredicateSpec:
        """The predicate that stands for a comparison."""
        arguments = self.file.quantities[comparison.quantity].arguments
        fields = [f"{{{name}}}" for name in arguments]
        return PredicateSpec(
            arguments=arguments,
            phrase=comparison.phrase(*fields),
            denial=comparison.opposite.phrase(*fields),
        )

    @staticmethod
    def _under_way(file: KnowledgeBaseFile) -> Iterator[tuple[str, PredicateSpec]]:
        """The predicates that chain the phases of actions."""
        for spec in file.actions:
            phases = max(len(phases_of(op)) for op in operators_of(spec))
            types = {one.name: one.type for one in spec.parameters if one.type != TIME}
            names = dict.fromkeys((*spec.agents, *types))
            said = f"{spec.name}({', '.join(f'{{{name}}}' for name in types)})"
            for number in range(1, phases):
                yield (
                    under_way_predicate(spec.name, number),
                    PredicateSpec(
                        arguments={name: types[name] for name in names},
                        phrase=f"phase {number} of {said} is done",
                        denial=f"phase {number} of {said} is not done",
                    ),
                )

    def compared(self, numbers: Numbers) -> frozenset[Fact]:
        """The facts that stand for the comparisons of actions which hold for these numbers."""
        return frozenset[Fact]().union(*(one.facts(numbers) for one in self.comparisons.values()))

    def __reduce__(self) -> tuple[Callable[[bytes], "KnowledgeBase"], tuple[bytes]]:
        """Pickle the file only; a process that receives the same one again has its knowledge base already."""
        return _received, (self._pickled_file,)

    @cached_property
    def _pickled_file(self) -> bytes:
        return pickle.dumps(self.file)

    @cached_property
    def fluents(self) -> frozenset[str]:
        """The predicates that some action changes; the others are static."""
        stated = frozenset(
            literal.predicate
            for op in self.operators
            for literal in (*op.deletes, *op.intended_effects, *op.other_effects)
        )
        return stated.union(self.held, self.under_way)

    @cached_property
    def phases(self) -> Mapping[str, tuple[Phase, ...]]:
        """By operator its phases, of those that have some."""
        return {op.name: phases for op in self.operators if (phases := phases_of(op))}

    @property
    def steps(self) -> tuple[Operator, ...]:
        """The operators, each that has phases replaced by these, or beside these if some agents lack them."""
        return tuple(step for op in self.operators for step in self.steps_of(op))

    def steps_of(self, op: Operator) -> tuple[Operator, ...]:
        """The operator or its phases; both if only some agents have these."""
        phases = self.phases.get(op.name, ())
        return (*(() if phases and not op.phases_when else (op,)), *phases)

    @cached_property
    def under_way(self) -> frozenset[str]:
        """The predicates that hold between an action's phases."""
        return frozenset(name for action in self.actions for name in self.between_phases_of(action))

    def between_phases_of(self, action: str) -> tuple[str, ...]:
        """The predicates that hold between the phases of an action, in order."""
        mine = [phases for phases in self.phases.values() if phases[0].spec.name == action]
        return tuple(
            under_way_predicate(action, phase.number) for phase in max(mine, key=len, default=())[:-1]
        )

    def phased_for(self, facts: Iterable[Fact]) -> frozenset[str]:
        """The operators of which some agent may have phases, by these facts."""
        asked = {one.predicate for op in self.operators for one in op.phases_when}
        known = {(fact.predicate, arg) for fact in facts if fact.predicate in asked for arg in fact.args}
        named = {
            op.name: {(one.predicate, term) for one in op.phases_when for term in one.terms}
            for op in self.operators
        }
        return frozenset(
            op.name
            for op in self.operators
            if op.name in self.phases
            and all(one in known for one in named[op.name] if one[1] not in op.parameters)
        )

    def phases_of(self, action: GroundAction, facts: Container[Fact]) -> tuple[GroundAction, ...]:
        """What stands for the action in a plan-net: its phases, or itself if it has none, is one, or is too short.

        :param facts: among them the static ones that say whose actions have phases.
        """
        if action.phase or action.under_way:
            return (action,)
        bound = ((op, binding_of(op, action.arguments)) for op in self._phased_by_tag.get(action.tag, ()))
        if not any(
            binding is not None and _hold(op.phases_when, binding, facts) for op, binding in bound
        ):  # most often, and quickly found out
            return (action,)
        found = self.operator_of(action)
        if found is None or found[0].name not in self.phases:
            return (action,)
        op, binding = found
        phases = self.phases[op.name]
        if not _hold(op.phases_when, binding, facts) or not phases[0].share.fits(action.duration_s):
            return (action,)
        return ground_phases(action, phases, binding)

    @cached_property
    def _phased_by_tag(self) -> Mapping[str, Sequence[Operator]]:
        """By plan-net action its operators that have phases."""
        return {
            tag: [op for op in operators if op.name in self.phases]
            for tag, operators in self.operators_by_tag.items()
        }

    def phase_of(self, action: GroundAction, number: int) -> GroundAction | None:
        """One of a whole action's phases, however short the action is now; None if it has none of this number."""
        found = self.operator_of(action)
        phases = () if found is None else self.phases.get(found[0].name, ())
        if found is None or not 0 < number <= len(phases):
            return None
        return ground_phases(action, phases[number - 1 : number], found[1])[0]

    def changes_of(self, action: GroundAction) -> tuple[Sequence[Fact], Sequence[Fact]]:
        """What the whole action deletes and brings about of which this is one, or a phase."""
        found = self.operator_of(action) if action.phase else None
        if found is None:
            return action.deletes, action.effects
        op, binding = found
        effects = (*op.intended_effects, *op.other_effects)
        return [one.ground(binding) for one in op.deletes], [one.ground(binding) for one in effects]

    def changed_numbers(self, action: GroundAction, functions: Functions) -> Mapping[Term, float]:
        """By how much the action, or a phase of it, changes numbers."""
        found = self.operator_of(action) if self.actions[action.tag].changes else None
        changed = {} if found is None else found[0].changed_numbers(found[1], functions, action)
        for quantity, (argument, amount) in self._used.items():
            for agent in action.agents:
                used = amount.value({argument: agent}, functions, action.own_terms) or 0.0
                if used:
                    changed[quantity, (agent,)] = changed.get((quantity, (agent,)), 0.0) - used
        return changed

    def aim_of(self, action: GroundAction) -> tuple[Comparison, Term] | None:
        """How far an action that is there for a number changes it at most, and that number; None for any other."""
        found = self.operator_of(action) if self.actions[action.tag].until else None
        if found is None or found[0].until is None:
            return None
        limit, terms = found[0].until
        return limit, (limit.quantity, tuple(found[1][term] for term in terms))

    def drain_of(self, term: Term, functions: Functions, action: GroundAction) -> float:
        """By how much a number falls a second while no action changes it, before this one does."""
        quantity, args = term
        binding = dict(zip(self.quantities[quantity].arguments, args, strict=True))
        known: Functions = {WAITING: self._waiting_for(action)}
        return self._drains[quantity].value(binding, functions, known) or 0.0

    def _waiting_for(self, action: GroundAction) -> float:
        """What a robot uses a second while it waits for the action, beyond rest; between phases it rests."""
        if action.phase > 1 or action.tag not in self._waited_for:
            return 0.0
        found = self.operator_of(action)
        return 0.0 if found is None else found[0].waiting

    @cached_property
    def _waited_for(self) -> frozenset[str]:
        """The actions that some robot uses more to wait for than at rest."""
        return frozenset(op.spec.name for op in self.operators if op.waiting)

    @cached_property
    def number_functions(self) -> frozenset[str]:
        """The functions that say by how much numbers change."""
        read = [amount for _, amount in self._used.values()]
        read += [*self._drains.values(), *(change.amount for op in self.operators for change in op.changes)]
        return frozenset(name for one in read for name, _ in one.calls) - {
            name for name, _ in (*OWN_TERMS, WAITING)
        }

    @cached_property
    def _drains(self) -> Mapping[str, Expression]:
        return {name: Expression.parse(spec.drain) for name, spec in self.quantities.items()}

    @cached_property
    def _used(self) -> Mapping[str, tuple[str, Expression]]:
        """By quantity that agents use up by acting its argument, and by how much."""
        return {
            name: (next(iter(spec.arguments)), Expression.parse(spec.used))
            for name, spec in self.quantities.items()
            if spec.used != "0"
        }

    @cached_property
    def operators_by_tag(self) -> Mapping[str, Sequence[Operator]]:
        """By plan-net action its operators."""
        found: dict[str, list[Operator]] = {}
        for op in self.operators:
            found.setdefault(op.spec.name, []).append(op)
        return found

    def operator_of(self, action: GroundAction) -> tuple[Operator, Mapping[str, str]] | None:
        """The operator and the binding that the action is of, or the action that it is a phase of."""
        found: list[tuple[int, Operator, Mapping[str, str]]] = []
        for op in self.operators_by_tag.get(action.tag, ()):
            binding = binding_of(op, action.arguments)
            phases = self.phases.get(op.name, ())
            if binding is None or action.phase > len(phases):
                continue
            own = phases[action.phase - 1] if action.phase else op
            stated = {one.ground(binding) for one in (*own.preconditions, *own.intended_effects)}
            if stated.issubset((*action.preconditions, *action.intended_effects)):
                found.append((len(stated), op, binding))
        best = max(found, key=lambda one: one[0], default=None)
        return None if best is None else best[1:]

    @cached_property
    def held(self) -> Mapping[str, str]:
        """The predicates of zones that are clear, and those of the positions by which they are held."""
        return {name: spec.held_by for name, spec in self.predicates.items() if spec.held_by is not None}

    @cached_property
    def accesses(self) -> Mapping[str, tuple[str, ...]]:
        """The predicates of how doors, hatches and lifts must stand for others, and the positions that ask for it."""
        return {name: spec.asked_by for name, spec in self.predicates.items() if spec.asked_by}

    @cached_property
    def operations(self) -> frozenset[str]:
        """The names of the actions of doors, hatches and lifts: those that change how one stands."""
        return frozenset(
            op.spec.name
            for op in self.operators
            if any(literal.predicate in self.accesses for literal in (*op.deletes, *op.intended_effects))
        )

    @cached_property
    def mentioned(self) -> frozenset[str]:
        """The predicates that some action mentions; facts of others mean nothing to a plan."""
        return self.fluents.union(literal.predicate for op in self.operators for literal in op.preconditions)

    def agents_among(self, objects: Mapping[str, str]) -> tuple[str, ...]:
        """Those of the objects, name → type, that can carry actions out."""
        kinds = self.agent_types
        return tuple(
            name
            for name, kind in sorted(objects.items())
            if any(self.file.is_a(kind, wanted) for wanted in kinds)
        )

    def operators_among(self, kinds: Collection[str]) -> tuple[Operator, ...]:
        """The operators that objects of these types, with the constants, can be bound to at all."""
        known = {*kinds, *self.constants.values()}
        return tuple(
            op
            for op in self.operators
            if all(any(self.file.is_a(kind, wanted) for kind in known) for wanted in op.parameters.values())
        )

    @property
    def agent_types(self) -> frozenset[str]:
        """The types of what carries actions out."""
        return frozenset(op.parameters[agent] for op in self.operators for agent in op.agents)

    @cached_property
    def sensed_words(self) -> frozenset[str]:
        """The predicates, in rel/ref form, of which some fact can be perceived."""
        sensed = {name: spec for name, spec in self.predicates.items() if spec.sensed}
        relations = self.file.constants(RELATION) if any(one.relational for one in sensed.values()) else ()
        return frozenset({name for name, one in sensed.items() if not one.relational}.union(relations))

    def is_sensed(self, fact: Fact, objects: Mapping[str, str], words: Container[str] | None = None) -> bool:
        """True if a robot can perceive this fact by itself.

        :param words: the predicates, in rel/ref form, that the robot perceives; None: all that are sensed at all.
        """
        predicate = self.predicates[fact.predicate]
        if words is not None and self.to_relation(fact)[0] not in words:
            return False
        bound = dict(zip(predicate.arguments, fact.args, strict=True))
        return predicate.sensed and (
            not predicate.sensed_when
            or any(
                self.file.is_a(objects.get(bound[argument], ""), kind)
                for argument, kind in predicate.sensed_when.items()
            )
        )

    def achieved_each_time(self, facts: Iterable[Fact]) -> frozenset[Fact]:
        """Those that, as goals, are to be achieved although they are true."""
        known = self.predicates
        return frozenset(
            fact for fact in facts if fact.predicate in known and known[fact.predicate].each_time
        )

    def to_relation(self, fact: Fact) -> tuple[str, tuple[str, ...]]:
        """The fact in rel/ref form: object_position(s, in, b) → ("in", ("s", "b")); others as they are."""
        predicate = self.predicates.get(fact.predicate)
        if predicate is None or not predicate.relational:
            return fact.predicate, fact.args
        return fact.args[1], (fact.args[0], *fact.args[2:])

    def from_relation(self, predicate: str, args: Iterable[str], objects: Mapping[str, str]) -> Fact:
        """The fact of a rel/ref form, by its arguments' types.

        :raises KnowledgeBaseError: if no predicate fits, naming the choices.
        """
        given = tuple(args)
        if predicate in self.predicates and not self.predicates[predicate].relational:
            fact = Fact(predicate, given)
            self.check(fact, objects)
            return fact
        if self.constants.get(predicate) != RELATION:
            raise KnowledgeBaseError(
                f"unknown predicate {predicate!r}; choices: {', '.join(self.relation_names())}"
            )
        for name, spec in self.predicates.items():
            if spec.relational and given:
                fact = Fact(name, (given[0], predicate, *given[1:]))
                if self._mismatch(fact, objects) is None and self._is_used(fact):
                    return fact
        raise KnowledgeBaseError(self._misfit(predicate, given, objects))

    def relation_names(self) -> tuple[str, ...]:
        """The predicates as the rel/ref form names them."""
        plain = [name for name, spec in self.file.predicates.items() if not spec.relational]
        return tuple(sorted({*plain, *self.file.constants(RELATION)}))

    def check(self, fact: Fact, objects: Mapping[str, str]) -> None:
        """:raises KnowledgeBaseError: if the fact is not of the vocabulary; names what is wrong and the
        choices."""
        if fact.predicate not in self.predicates:
            choices = ", ".join(sorted(self.file.predicates))
            raise KnowledgeBaseError(f"unknown predicate {fact.predicate!r} in {fact}; choices: {choices}")
        if (mismatch := self._mismatch(fact, objects)) is not None:
            raise KnowledgeBaseError(mismatch)

    def ground(
        self, action: str, arguments: Mapping[str, str], functions: Functions, *, objects: Mapping[str, str]
    ) -> GroundAction:
        """The action with these arguments (as `PlanNetAction.arguments` names them).

        :raises KnowledgeBaseError: if the action, an argument or a duration is not known.
        """
        if action not in self.actions:
            raise KnowledgeBaseError(f"unknown action {action!r}; choices: {', '.join(sorted(self.actions))}")
        misfits = []
        for op in self.operators_by_tag[action]:
            if (binding := binding_of(op, arguments)) is None:
                continue
            if (wrong := self.misfit(op, binding, objects)) is not None:
                misfits.append(wrong)
                continue
            if (ground := op.ground(binding, functions)) is not None:
                return ground
            wrong = f"{action}({dict(arguments)}): its duration {op.duration.text!r} has no value"
            raise KnowledgeBaseError(wrong)
        names = ", ".join(parameter.name for parameter in self.actions[action].parameters)
        raise KnowledgeBaseError(*misfits[:1] or [f"{action} takes ({names}), not {dict(arguments)}"])

    def misfit(self, op: Operator, binding: Mapping[str, str], objects: Mapping[str, str]) -> str | None:
        """Why the operator cannot be bound so, or None: each object is of its parameter's type, and none in two
        parameters that are to differ."""
        for name, kind in op.parameters.items():
            if not self.file.is_a(self._type_of(binding[name], objects), kind):
                return _choices(f"{op.spec.name}.{name}", binding[name], kind, self, objects)
        if same := [pair for pair in op.distinct if binding[pair[0]] == binding[pair[1]]]:
            return f"{op.spec.name}: {' and '.join(same[0])} are both {binding[same[0][0]]!r}"
        return None

    def _type_of(self, name: str, objects: Mapping[str, str]) -> str:
        return objects.get(name, self.constants.get(name, ""))

    def _mismatch(self, fact: Fact, objects: Mapping[str, str]) -> str | None:
        wanted = self.predicates[fact.predicate].arguments
        if len(fact.args) != len(wanted):
            return f"{fact}: {fact.predicate} takes ({', '.join(wanted)})"
        for value, (argument, kind) in zip(fact.args, wanted.items(), strict=True):
            if not self.file.is_a(self._type_of(value, objects), kind):
                return _choices(f"{fact}: {argument}", value, kind, self, objects)
        return None

    def _is_used(self, fact: Fact) -> bool:
        """True if some literal of the knowledge base has this relation with this predicate."""
        relation = fact.args[1]
        return any(
            literal.predicate == fact.predicate and literal.terms[1] in (relation, *op.parameters)
            for op in self.operators
            for literal in (*op.preconditions, *op.intended_effects, *op.other_effects)
        )

    def _misfit(self, relation: str, args: tuple[str, ...], objects: Mapping[str, str]) -> str:
        forms = [
            f"{relation}({', '.join(kind for kind in spec.arguments.values() if kind != RELATION)})"
            for name, spec in self.predicates.items()
            if spec.relational and self._is_used(Fact(name, ("", relation)))
        ]
        unknown = [value for value in args if not self._type_of(value, objects)]
        detail = f"; unknown: {', '.join(unknown)}, known: {', '.join(sorted(objects))}" if unknown else ""
        return f"{relation}({', '.join(args)}) does not fit; choices: {', '.join(sorted(set(forms)))}{detail}"


def binding_of(op: Operator, arguments: Mapping[str, str]) -> Mapping[str, str] | None:
    """The operator's binding for these arguments; None if it is another variant."""
    if any(arguments.get(name) != value for name, value in op.chosen.items()):
        return None
    binding: dict[str, str] = {}
    for parameter in op.spec.parameters:
        if parameter.name in op.teams:
            members = arguments.get(parameter.name, "").split(TEAM_SEPARATOR)
            if len(members) != len(op.teams[parameter.name]):
                return None
            binding |= dict(zip(op.teams[parameter.name], members, strict=True))
        elif parameter.name in op.parameters:
            if parameter.name not in arguments:
                return None
            binding[parameter.name] = arguments[parameter.name]
    return binding


def _choices(where: str, value: str, kind: str, base: KnowledgeBase, objects: Mapping[str, str]) -> str:
    fitting = sorted(
        name for name, other in {**base.constants, **objects}.items() if base.file.is_a(other, kind)
    )
    return f"{where} {value!r} is no {kind}; choices: {', '.join(fitting) or 'none'}"


@lru_cache(maxsize=8)
def _received(pickled_file: bytes) -> KnowledgeBase:
    return KnowledgeBase(pickle.loads(pickled_file))


def _hold(literals: Iterable[Literal], binding: Mapping[str, str], facts: Container[Fact]) -> bool:
    return all(one.ground(binding) in facts for one in literals)
