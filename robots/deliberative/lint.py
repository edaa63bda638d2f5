"""What is wrong with the rule files of one agent, although each of them can be read."""

from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from itertools import chain

from robots.deliberative.costs import packets_in
from robots.deliberative.guards import holds
from robots.deliberative.perceptors import perceptor_faults
from robots.deliberative.program import (
    Activate,
    Adopt,
    Await,
    Conditions,
    Delay,
    Fault,
    Guard,
    Literal,
    Place,
    Plan,
    Retract,
    Rule,
    RuleFile,
    RunPlan,
    Say,
    Steer,
    Step,
    parts_of,
    plans_of,
)
from robots.deliberative.steps import TIMEOUT, WAIT_TIMEOUT
from robots.deliberative.syntax import refusal
from robots.deliberative.terms import (
    NOT,
    Term,
    Value,
    Variable,
    as_term,
    as_value,
    is_ground,
    opposite,
    renamed,
    shown,
    unify,
    variables_in,
)
from robots.deliberative.vocabulary import ASSIGNED, EVENTS, KNOWN, PERFORMATIVES, ROLE, form
from robots.errors import RuleError
from robots.repertoire import PacketSpec, Repertoire
from robots.repertoire.parameters import LIMITS

OWN_FIELDS = (TIMEOUT, WAIT_TIMEOUT)
"""Of a packet itself, which a rule may set beside its arguments."""
TARGET = ("object", "x", "y")


def check(files: Sequence[RuleFile], repertoire: Repertoire) -> None:
    """Check the files of one agent together: a role's rules may use what the agent's commitments adopt.

    :raises RuleError: naming file, line and column of each fault, and the way out.
    """
    refused: list[str] = []
    names: dict[str, str] = {}
    for file in files:
        if file.name in names:
            raise RuleError(f"{file.origin} and {names[file.name]} both define {file.name}")
        names[file.name] = file.origin
    brought = _Brought(files)
    for file in files:
        faults = list(_Lint(file, files, brought, repertoire).faults())
        if faults:
            refused.append(str(refusal(file.origin, faults)))
    if refused:
        raise RuleError("\n".join(refused))


class _Brought:
    """The beliefs that something brings: perceptors, events, initial beliefs, commitments."""

    def __init__(self, files: Sequence[RuleFile]) -> None:
        self.perceived = [spec.belief for file in files for spec in file.perceptors]
        steps = [step for file in files for step in _steps(file)]
        adopted = [step.term for step in steps if isinstance(step, Adopt)]
        initial = [literal.term for file in files for literal in file.initial]
        given = [form(name, arguments) for name, arguments in {**EVENTS, **KNOWN, **ASSIGNED}.items()]
        both = [*self.perceived, *(opposite(one) for one in self.perceived)]
        self._all = [_marked(one) for one in (*both, *adopted, *initial, *given)]
        self.names = sorted({f"{one.functor}/{len(one.args)}" for one in self._all if one.functor != NOT})

    def may_hold(self, term: Term) -> bool:
        value = as_value(term)
        return any(unify(value, as_value(one)) is not None for one in self._all)

    def is_perceived(self, term: Term) -> bool:
        """True if a perceptor brings it or its opposite."""
        value = as_value(_plain(term))
        return any(unify(value, renamed(as_value(one), "'")) is not None for one in self.perceived)


class _Lint:
    """The faults of one file."""

    def __init__(
        self, file: RuleFile, files: Sequence[RuleFile], brought: _Brought, repertoire: Repertoire
    ) -> None:
        self._file = file
        self._brought = brought
        self._repertoire = repertoire
        self._plans: dict[str, tuple[Plan, ...]] = {}
        for one in files:
            for name, plans in one.plans.items():
                self._plans[name] = (*self._plans.get(name, ()), *plans)

    def faults(self) -> Iterator[Fault]:
        for spec in self._file.perceptors:
            yield from perceptor_faults(spec)
            if _plain(spec.belief).functor in (*EVENTS, *KNOWN, ROLE):
                yield Fault(spec.place, f"{spec.belief.functor} is not sensed; give the belief another name")
        for literal in self._file.initial:
            if not is_ground(as_value(literal.term)):
                yield Fault(literal.place, f"an initial belief has no variables: {literal.term}")
            yield from self._own_belief(literal.term, literal.place)
        for tag in sorted(self._file.carries | self._file.actuators.get("activate", frozenset())):
            if not _contents(self._repertoire, tag):
                yield Fault(Place(1, 1), self._unknown_packet(tag))
        for rule in self._file.rules:
            yield from self._rule(rule)
        for plan in plans_of(self._file):
            yield from self._plan(plan)

    def _rule(self, rule: Rule) -> Iterator[Fault]:
        bound = {name for one in rule.when.positive for name in variables_in(as_value(one.term))}
        yield from self._guards(rule.when, bound)
        yield from self._never(rule.when)
        used = chain(variables_in(rule.agent), variables_in(rule.delay_s))
        for name in used:
            if name not in bound:
                yield _unbound(name, rule.place, "no positive BELIEF of the rule")
        yield from self._maintained(rule.maintain, bound)
        yield from self._step(rule.step, bound, "no positive BELIEF of the rule")

    def _plan(self, plan: Plan) -> Iterator[Fault]:
        if plan.name in self._reached(plan.step):
            yield Fault(plan.place, f"the plan {plan.name} runs itself; end it and let a rule begin it again")
        fellows = self._plans[plan.name]
        if len(fellows) > 1 and not all(one.competes for one in fellows):
            yield Fault(
                plan.place,
                f"several files have a plan {plan.name}; plans that compete have WHEN or COST each",
            )
        elif len({len(one.parameters) for one in fellows}) > 1:
            yield Fault(plan.place, f"the plans {plan.name} have different numbers of parameters")
        binder = "no parameter of the plan"
        if plan.when.literals:
            binder += ", nor positive BELIEF of its WHEN,"
        bound = set(plan.parameters)
        bound |= {name for one in plan.when.positive for name in variables_in(as_value(one.term))}
        yield from self._maintained(plan.when, bound)
        cost = 0.0 if plan.cost is None else plan.cost
        for tag in packets_in(cost):
            if not _contents(self._repertoire, tag):
                yield Fault(plan.place, self._unknown_packet(tag))
        for name in dict.fromkeys(variables_in(cost)):
            if name not in bound:
                yield _unbound(name, plan.place, binder)
        yield from self._step(plan.step, bound, binder)

    def _reached(self, step: Step) -> set[str]:
        """The plans that a step runs, and those that they run."""
        found: set[str] = set()
        left = [step]
        while left:
            for one in parts_of(left.pop()):
                if isinstance(one, RunPlan) and one.name in self._plans and one.name not in found:
                    found.add(one.name)
                    left += [plan.step for plan in self._plans[one.name]]
        return found

    def _guards(self, conditions: Conditions, bound: set[str]) -> Iterator[Fault]:
        for guard in conditions.guards:
            for name in chain(variables_in(guard.left), variables_in(guard.right)):
                if name not in bound:
                    yield _unbound(name, guard.place, "no positive BELIEF beside it")

    def _maintained(self, conditions: Conditions, bound: set[str]) -> Iterator[Fault]:
        """Of AWAIT and conditions to keep: variables that are not bound stand for anything."""
        yield from self._guards(conditions, bound)
        yield from self._never(conditions)

    def _never(self, conditions: Conditions) -> Iterator[Fault]:
        """Conditions that cannot hold."""
        for guard in conditions.guards:
            fixed = is_ground(guard.left) and is_ground(guard.right)
            irreflexive = guard.left == guard.right and guard.operator in ("!=", "<", ">")
            if irreflexive or (fixed and not holds(guard, {})):
                yield Fault(guard.place, f"never holds: {_compared(guard)}")
        believed = {one.term: one for one in conditions.positive}
        for literal in conditions.literals:
            if not literal.negated and opposite(literal.term) in believed:
                if literal.term.functor == NOT:
                    yield Fault(literal.place, f"never holds together with BELIEF({opposite(literal.term)})")
            elif literal.negated and literal.term in believed:
                yield Fault(literal.place, f"never holds together with BELIEF({literal.term})")
            elif not literal.negated and not self._brought.may_hold(literal.term):
                yield Fault(literal.place, self._unbrought(literal))

    def _unbrought(self, literal: Literal) -> str:
        words = f"never holds: no perceptor, event, initial belief or adoptBelief brings {literal.term}"
        wanted = _plain(literal.term)
        name = f"{wanted.functor}/{len(wanted.args)}"
        near = get_close_matches(name, [one for one in self._brought.names if one != name], n=1)
        near += [
            one for one in self._brought.names if one.split("/")[0] == wanted.functor and one not in near
        ]
        return f"{words}; did you mean {' or '.join(near)}?" if near else words

    def _step(self, step: Step, bound: set[str], binder: str) -> Iterator[Fault]:
        for one in parts_of(step):
            for name in dict.fromkeys(_used(one)):
                if name not in bound:
                    yield _unbound(name, one.place, binder)
            if isinstance(one, Adopt | Retract):
                yield from self._own_belief(one.term, one.place)
            elif isinstance(one, Activate):
                yield from self._activation(one)
            elif isinstance(one, Say):
                yield from self._speech(one)
            elif isinstance(one, Steer):
                yield from self._declared(one.verb.value, "", one.place)
            elif isinstance(one, RunPlan):
                yield from self._call(one)
            elif isinstance(one, Await):
                yield from self._maintained(one.conditions, bound)

    def _own_belief(self, term: Term, place: Place) -> Iterator[Fault]:
        """Beliefs that only sensors and events bring."""
        if _plain(term).functor in (*EVENTS, *KNOWN):
            yield Fault(place, f"{_plain(term).functor} comes from the robot itself; adopt another belief")
        elif self._brought.is_perceived(term):
            yield Fault(place, f"{term} is sensed by a perceptor; adopt another belief")

    def _declared(self, actuator: str, choice: str, place: Place) -> Iterator[Fault]:
        limited = self._file.actuators.get(actuator)
        if limited is None:
            wanted = f"{actuator}({choice})" if choice else actuator
            yield Fault(place, f"{actuator} is not declared; add ACTUATOR {wanted};")
        elif limited and choice and choice not in limited:
            allowed = ", ".join(sorted(limited))
            yield Fault(place, f"{choice} is not among those of ACTUATOR {actuator}({allowed})")

    def _speech(self, one: Say) -> Iterator[Fault]:
        choice = ""
        if not isinstance(one.performative, Variable):
            choice = shown(one.performative)
            if choice not in PERFORMATIVES:
                near = get_close_matches(choice, PERFORMATIVES, n=1)
                way_out = f"did you mean {near[0]}?" if near else f"choices: {', '.join(PERFORMATIVES)}"
                yield Fault(one.place, f"unknown performative {choice}; {way_out}")
        elif limited := ", ".join(sorted(self._file.actuators.get("say", ()))):
            way_out = f"write one of ACTUATOR say({limited}), or ACTUATOR say for all"
            yield Fault(one.place, f"{shown(one.performative)} may be any performative; {way_out}")
        yield from self._declared("say", choice, one.place)

    def _call(self, one: RunPlan) -> Iterator[Fault]:
        plan = next(iter(self._plans.get(one.name, ())), None)
        if plan is None:
            known = sorted(self._plans)
            near = get_close_matches(one.name, known, n=1)
            words = f"did you mean {near[0]}?" if near else f"plans: {', '.join(known) or 'none'}"
            yield Fault(one.place, f"unknown action or plan {one.name}; {words}")
        elif len(plan.parameters) != len(one.values):
            wanted = len(plan.parameters)
            yield Fault(one.place, f"the plan {one.name} takes {wanted} values, not {len(one.values)}")

    def _activation(self, one: Activate) -> Iterator[Fault]:
        contents = _contents(self._repertoire, one.tag)
        if not contents:
            yield Fault(one.place, self._unknown_packet(one.tag))
            return
        yield from self._declared("activate", one.tag, one.place)
        given = dict(one.arguments)
        for spec in contents[:1]:
            parameters = {**LIMITS, **spec.parameters}
            target = TARGET if spec.target else ()
            known = {*spec.arguments, *spec.optional, *parameters, *target, *OWN_FIELDS}
            if missing := [name for name in spec.arguments if name not in given]:
                yield Fault(one.place, f"{one.tag} lacks the argument {', '.join(missing)}")
            if spec.target and ("object" in given) == ("x" in given and "y" in given):
                yield Fault(one.place, f"{one.tag} needs either object, or x and y")
            for name, value in one.arguments:
                if name not in known:
                    near = get_close_matches(name, sorted(known), n=1)
                    way_out = f"did you mean {near[0]}?" if near else f"it has {', '.join(sorted(known))}"
                    yield Fault(one.place, f"{one.tag} has no parameter {name}; {way_out}")
                elif name in OWN_FIELDS and is_ground(value) and not isinstance(value, float | int):
                    yield Fault(one.place, f"{one.tag}: {name} = {shown(value)} is no number of seconds")
                elif name in parameters and is_ground(value):
                    try:
                        parameters[name].read(shown(value))
                    except ValueError as error:
                        yield Fault(one.place, f"{one.tag}: {name} = {error}")

    def _unknown_packet(self, tag: str) -> str:
        tags = sorted({spec.tag for spec in self._repertoire.specs.values()})
        near = get_close_matches(tag, tags, n=1)
        return f"unknown packet {tag}; " + (
            f"did you mean {near[0]}?" if near else f"known: {', '.join(tags)}"
        )


def _contents(repertoire: Repertoire, tag: str) -> list[PacketSpec]:
    return [spec for spec in repertoire.specs.values() if spec.tag == tag]


def _steps(file: RuleFile) -> Iterator[Step]:
    for step in (*(rule.step for rule in file.rules), *(plan.step for plan in plans_of(file))):
        yield from parts_of(step)


def _used(step: Step) -> Iterator[str]:
    """The variables that a step itself uses; those of an AWAIT may stand for anything."""
    values: Iterable[Value] = ()
    match step:
        case Adopt(term=term) | Retract(term=term):
            values = term.args
        case Activate(arguments=arguments):
            values = tuple(value for _, value in arguments)
        case Say(performative=performative, receiver=receiver, content=content):
            values = (performative, receiver, content)
        case Steer(reason=reason):
            values = (reason,)
        case RunPlan(values=given):
            values = given
        case Delay(seconds=seconds):
            values = (seconds,)
    for value in values:
        yield from variables_in(value)


def _unbound(name: str, place: Place, binder: str) -> Fault:
    said = "?_" if name.startswith("?") else f"?{name}"
    return Fault(place, f"{said} is not bound: {binder} contains it")


def _plain(term: Term) -> Term:
    """The term itself, of `not(t)`, too."""
    return as_term(term.args[0]) if term.functor == NOT and _is_named(term.args[0]) else term


def _is_named(value: Value) -> bool:
    return isinstance(value, Term | str)


def _marked(term: Term) -> Term:
    return as_term(renamed(as_value(term), "'"))


def _compared(guard: Guard) -> str:
    return f"{shown(guard.left)} {guard.operator} {shown(guard.right)}"
