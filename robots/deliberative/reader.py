"""Statements of a rule file as a `RuleFile`: beliefs, conditions, commitments, plans and declarations."""

import hashlib
import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from itertools import count
from math import isfinite
from pathlib import Path

from robots.deliberative.costs import MEASURES, PRODUCT, SUM
from robots.deliberative.program import (
    Activate,
    Adopt,
    Await,
    Conditions,
    Delay,
    Fault,
    Group,
    Guard,
    Joint,
    Literal,
    PerceptorSpec,
    Place,
    Plan,
    Retract,
    Rule,
    RuleFile,
    RunPlan,
    Say,
    Steer,
    Step,
    Verb,
)
from robots.deliberative.syntax import Node, parse, refusal
from robots.deliberative.terms import NOT, Term, Value, Variable, as_value
from robots.errors import RuleError

BELIEF = "BELIEF"
COMMIT = "COMMIT"
SELF = "Self"
NOW = "Now"
TRUE = Term("true")
"""`BELIEF(true)` always holds."""
ACTIONS = ("adoptBelief", "retractBelief", "activate", "activateBehavior", "say", *Verb)
ACTUATORS = ("activate", "say", *Verb)
"""What a file declares before its commitments use it; beliefs are the agent's own."""
DIGITS = 12
"""Of a version."""


def read_rules(file: Path) -> RuleFile:
    """:raises RuleError: naming the file, and the line and column of each fault."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RuleError(f"{file} cannot be read: {error}") from error
    return rules_of(text, str(file))


def rules_of(text: str, origin: str) -> RuleFile:
    """:raises RuleError: naming the origin, and the line and column of each fault."""
    return _Reader(text, origin).read(parse(text, origin))


def beliefs_of(texts: Iterable[str]) -> list[Term]:
    """Beliefs as they are written.

    :raises RuleError: if one is no belief.
    """
    stated = "\n".join(f"{BELIEF}({text});" for text in texts)
    return [
        one.term
        for one in _Reader(stated, "beliefs").read(parse(f"AGENT recalled;\n{stated}", "beliefs")).initial
    ]


class _Refused(Exception):
    """Raised at the first fault of a statement."""

    def __init__(self, place: Place, words: str) -> None:
        super().__init__(words)
        self.fault = Fault(place, words)


class _Reader:
    """Reads one file, and goes on with the next statement after a fault."""

    def __init__(self, text: str, origin: str) -> None:
        self._text = text
        self._origin = origin
        self._faults: list[Fault] = []
        self._perceptors: list[PerceptorSpec] = []
        self._actuators: dict[str, frozenset[str]] = {}
        self._carries: set[str] = set()
        self._initial: list[Literal] = []
        self._rules: list[Rule] = []
        self._plans: dict[str, tuple[Plan, ...]] = {}
        self._anonymous = count(1)

    def read(self, start: Node) -> RuleFile:
        header, *statements = start.parts
        readers = {
            "perceptor": self._perceptor,
            "actuator": self._actuator,
            "carry": self._carry,
            "plan": self._plan,
            "initial": self._initially,
            "rule": self._rule,
        }
        for statement in statements:
            try:
                readers[statement.kind](statement)
            except _Refused as refused:
                self._faults.append(refused.fault)
        if self._faults:
            raise refusal(self._origin, self._faults)
        kind, name = header.parts
        return RuleFile(
            name=name.word,
            version=digest_of(self._text),
            is_role=kind.kind == "ROLE",
            origin=self._origin,
            text=self._text,
            perceptors=tuple(self._perceptors),
            actuators=self._actuators,
            carries=frozenset(self._carries),
            initial=tuple(self._initial),
            rules=tuple(self._rules),
            plans=self._plans,
        )

    def _perceptor(self, node: Node) -> None:
        _, belief, _, condition, *ranges = node.parts
        domains: tuple[tuple[str, str], ...] = ()
        if ranges:
            words = [one.word for one in ranges[0].parts if one.kind in ("VARIABLE", "NAME")]
            domains = tuple((name[1:], domain) for name, domain in zip(words[::2], words[1::2], strict=True))
        said = self._condition_word(condition)
        self._perceptors.append(
            PerceptorSpec(belief=self._term(belief), condition=said, domains=domains, place=node.place)
        )

    def _actuator(self, node: Node) -> None:
        for one in node.parts[1:]:
            name, arguments = _call(one)
            known = _canonical(name, ACTUATORS)
            if known is None:
                raise _Refused(one.place, f"unknown actuator {name}{_choose(name, ACTUATORS)}")
            limited = frozenset(self._word(argument) for argument in arguments)
            earlier = self._actuators.get(known, limited)
            self._actuators[known] = limited | earlier if limited and earlier else frozenset()

    def _carry(self, node: Node) -> None:
        self._carries.update(one.word for one in node.parts[1:])

    def _plan(self, node: Node) -> None:
        _, head, *clauses, steps = node.parts
        name, arguments = _call(head)
        stated = {word.kind: said for word, said in zip(clauses[::2], clauses[1::2], strict=True)}
        when = self._conditions(stated["WHEN"]) if "WHEN" in stated else Conditions()
        cost = self._cost(stated["COST"]) if "COST" in stated else None
        parameters = []
        for one in arguments:
            if one.kind != "variable" or one.parts[0].word == "?_":
                raise _Refused(one.place, "a plan's parameters are ?variables with names")
            parameters.append(one.parts[0].word[1:])
        known = self._plans.get(name, ())
        if known and not (stated and all(one.competes for one in known)):
            first = known[0].place.line
            words = f"the plan {name} is defined a second time, first in line {first}"
            raise _Refused(head.place, f"{words}; plans that compete have WHEN or COST each")
        if known and len(known[0].parameters) != len(parameters):
            raise _Refused(head.place, f"the plans {name} have different numbers of parameters")
        if _canonical(name, (*ACTIONS, *Joint, "AWAIT", "DELAY")) is not None:
            raise _Refused(head.place, f"{name} is an action's name; give the plan another one")
        inner = tuple(self._step(one) for one in steps.parts)
        step = inner[0] if len(inner) == 1 else Group(Joint.SEQ, inner, node.place)
        plan = Plan(
            name=name,
            parameters=tuple(parameters),
            when=when,
            cost=cost,
            competes=bool(stated),
            step=step,
            place=head.place,
        )
        self._plans[name] = (*known, plan)

    def _cost(self, node: Node) -> Value:
        """Numbers, variables and measures of the robot, with + and *."""
        if node.kind in ("plus", "times"):
            left, right = (self._cost(one) for one in node.parts)
            return Term(SUM if node.kind == "plus" else PRODUCT, (left, right))
        value = self._value(node)
        named = value.functor if isinstance(value, Term) else value
        count = len(value.args) if isinstance(value, Term) else 0
        if isinstance(named, str) and MEASURES.get(named) != count:
            choices = ", ".join(f"{name}/{arity}" for name, arity in MEASURES.items())
            raise _Refused(node.place, f"a cost has no {value}; it has numbers, ?variables and {choices}")
        return value

    def _initially(self, node: Node) -> None:
        for one in node.parts:
            if not _is_call(one, BELIEF):
                raise _Refused(one.place, "expected BELIEF(...), or conditions => COMMIT(...)")
            self._initial.append(Literal(self._term(_only(one)), False, one.place))

    def _rule(self, node: Node) -> None:
        when, commit = node.parts
        if not _is_call(commit, COMMIT):
            raise _Refused(commit.place, "expected COMMIT(action), or COMMIT(agent, time, action)")
        given = commit.parts[1:]
        agent: Value = SELF
        delay_s: Value = 0.0
        maintain = Conditions()
        if len(given) not in (1, 3, 4):
            words = "COMMIT takes an action; or an agent, a time and an action; or a condition to keep before that"
            raise _Refused(commit.place, words)
        if len(given) > 1:
            agent = self._value(given[0])
            delay_s = self._time(given[1])
        if len(given) == 4:
            maintain = self._conditions(given[2])
        self._rules.append(
            Rule(
                number=len(self._rules),
                when=self._conditions(when),
                agent=agent,
                delay_s=delay_s,
                maintain=maintain,
                step=self._step(given[-1]),
                place=node.place,
            )
        )

    def _time(self, node: Node) -> Value:
        """The delay of `Now` or `Now + seconds`."""
        now, seconds = node.parts if node.kind == "plus" else (node, None)
        if now.kind != "name" or now.parts[0].word.lower() != NOW.lower():
            raise _Refused(node.place, "a time is Now, or Now + seconds")
        return 0.0 if seconds is None else self._number_or_variable(seconds)

    def _conditions(self, node: Node) -> Conditions:
        literals: list[Literal] = []
        guards: list[Guard] = []
        for one in node.parts if node.kind == "joined" else (node,):
            if one.kind == "comparison":
                left, operator, right = one.parts
                guards.append(Guard(self._value(left), operator.word, self._value(right), one.place))
                continue
            negated = one.kind == "negated"
            inner = one.parts[0] if negated else one
            if not _is_call(inner, BELIEF):
                raise _Refused(inner.place, "expected BELIEF(...), !BELIEF(...) or a comparison")
            literal = Literal(self._term(_only(inner)), negated, one.place)
            if literal.term == TRUE and not negated:
                continue
            literals.append(literal)
        return Conditions(tuple(literals), tuple(guards))

    def _step(self, node: Node) -> Step:
        name, arguments = _call(node)
        joint = _canonical(name, tuple(Joint))
        if joint is not None:
            if not arguments:
                raise _Refused(node.place, f"{joint} needs at least one action")
            return Group(Joint(joint), tuple(self._step(one) for one in arguments), node.place)
        if name.upper() == "AWAIT":
            return Await(self._conditions(_only(node)), node.place)
        if name.upper() == "DELAY":
            return Delay(self._number_or_variable(_only(node)), node.place)
        action = _canonical(name, ACTIONS)
        if action is None:
            return RunPlan(name, tuple(self._value(one) for one in arguments), node.place)
        return self._action(action, node, arguments)

    def _action(self, name: str, node: Node, arguments: Sequence[Node]) -> Step:
        if name in ("adoptBelief", "retractBelief"):
            believed = _only(node)
            term = self._term(_only(believed) if _is_call(believed, BELIEF) else believed)
            return Adopt(term, node.place) if name == "adoptBelief" else Retract(term, node.place)
        if name in ("activate", "activateBehavior"):
            tag, settings = _call(_only(node))
            return Activate(tag, tuple(self._setting(one) for one in settings), node.place)
        if name == "say":
            if len(arguments) != 3:
                raise _Refused(node.place, "say takes a performative, a receiver and a content")
            performative, receiver, content = (self._value(one) for one in arguments)
            return Say(performative, receiver, content, node.place)
        if len(arguments) > 1:
            raise _Refused(node.place, f"{name} takes one reason, or nothing")
        reason = self._value(arguments[0]) if arguments else ""
        return Steer(Verb(name), reason, node.place)

    def _setting(self, node: Node) -> tuple[str, Value]:
        if node.kind != "named":
            raise _Refused(node.place, "a packet's arguments are written name: value")
        name, value = node.parts
        return name.word, self._value(value)

    def _condition_word(self, node: Node) -> dict[str, object]:
        """`close(object: ?b, m: 1)` as the data of a condition: {sense: close, object: ?b, m: 1}."""
        name, arguments = _call(node)
        said: dict[str, object] = {"sense": name}
        for one in arguments:
            if one.kind != "named":
                raise _Refused(one.place, f"the fields of {name} are written name: value")
            field, value = one.parts
            said[field.word] = self._field(value)
        return said

    def _field(self, node: Node) -> object:
        if node.kind == "call":
            return self._condition_word(node)
        if node.kind == "list":
            return [self._field(one) for one in node.parts]
        value = self._value(node)
        if value in ("true", "false"):
            return value == "true"
        return value

    def _number_or_variable(self, node: Node) -> Value:
        value = self._value(node)
        if isinstance(value, Variable | float | int):
            return value
        raise _Refused(node.place, "expected seconds, as a number or a ?variable")

    def _word(self, node: Node) -> str:
        value = self._value(node)
        if isinstance(value, str):
            return value
        raise _Refused(node.place, "expected a name")

    def _term(self, node: Node) -> Term:
        value = self._value(node)
        if isinstance(value, Term) and value.functor == NOT:
            inner = value.args[0]
            if not isinstance(inner, Term | str) or (isinstance(inner, Term) and inner.functor == NOT):
                raise _Refused(node.place, "not takes one belief: not(close(ball))")
        if isinstance(value, Term):
            return value
        if isinstance(value, str) and node.kind == "name":
            return Term(value)
        raise _Refused(node.place, "expected a belief such as close(ball)")

    def _value(self, node: Node) -> Value:
        match node.kind:
            case "number" | "minus":
                number = float(node.parts[0].word)
                if not isfinite(number):
                    raise _Refused(node.place, f"{node.parts[0].word} is too large for a number")
                return -number if node.kind == "minus" else number
            case "string":
                return re.sub(r"\\(.)", lambda found: found[1].replace("n", "\n"), node.parts[0].word[1:-1])
            case "variable":
                name = node.parts[0].word[1:]
                return Variable(f"?{next(self._anonymous)}") if name == "_" else Variable(name)
            case "name":
                return node.parts[0].word
            case "call":
                name, arguments = _call(node)
                if _canonical(name, (BELIEF, COMMIT)):
                    raise _Refused(
                        node.place, f"{name} cannot stand within a belief or an action's arguments"
                    )
                if name == NOT and len(arguments) != 1:
                    raise _Refused(node.place, "not takes one belief: not(close(ball))")
                return as_value(Term(name, tuple(self._value(one) for one in arguments)))
        raise _Refused(node.place, "expected a name, number, string, ?variable or name(...)")


def digest_of(text: str) -> str:
    """The version of a rule file: of its text, however its lines end."""
    plain = "\n".join(text.splitlines()).strip()
    return hashlib.sha256(plain.encode()).hexdigest()[:DIGITS]


def _call(node: Node) -> tuple[str, tuple[Node, ...]]:
    """The name and arguments of `name(...)`, or of a name alone."""
    if node.kind not in ("call", "name"):
        raise _Refused(node.place, "expected a name, or name(...)")
    name, *arguments = node.parts
    return name.word, tuple(arguments)


def _is_call(node: Node, name: str) -> bool:
    return node.kind == "call" and node.parts[0].word.upper() == name


def _only(node: Node) -> Node:
    name, arguments = _call(node)
    if len(arguments) != 1:
        raise _Refused(node.place, f"{name} takes exactly one argument, not {len(arguments)}")
    return arguments[0]


def _canonical(name: str, known: Iterable[str]) -> str | None:
    """The name as this house writes it, whatever its case."""
    return next((one for one in known if one.lower() == name.lower()), None)


def _choose(name: str, known: Iterable[str]) -> str:
    """What to write instead of an unknown name."""
    choices = sorted(known)
    near = get_close_matches(name, choices, n=1)
    return f"; did you mean {near[0]}?" if near else f"; choices: {', '.join(choices) or 'none'}"
