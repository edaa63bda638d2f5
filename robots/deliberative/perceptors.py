"""Perceptors: sensor conditions whose verdicts are beliefs, so that the sensors they need follow from the rules."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice, product

from pydantic import ValidationError

from robots.conditions.motion import Advanced, AtRest, Elapsed, Faster, Raised, Travelled, Turned
from robots.conditions.own_state import Commanded, NotDriven
from robots.conditions.verdict import Condition
from robots.deliberative.program import Fault, PerceptorSpec
from robots.deliberative.terms import NOT, Term, Value, Variable, as_value, instance, substitute, variables_in
from robots.errors import SensorOff
from robots.perception.percepts import Needs, Percepts
from robots.repertoire.schema import sensor_conditions

DOMAINS: Mapping[str, Callable[[Percepts], Iterable[str]]] = {
    "tracked": lambda percepts: percepts.cursors,
    "places": lambda percepts: percepts.profile.places,
    "robots": lambda percepts: percepts.profile.others,
    "me": lambda percepts: (percepts.me,),
    "wanted": lambda percepts: percepts.data.wanted,
}
"""What a perceptor's variable may range over: objects that are tracked, places of the map, other robots, the robot, and
what the current packet of a script names, as it has put it into the mutual data store.
"""
OF_A_PACKET = (Advanced, AtRest, Commanded, Elapsed, Faster, NotDriven, Raised, Travelled, Turned)
"""Conditions on the packet under way: its events say the same to rules."""
OF_A_PACKET_WORDS = frozenset(one.variant_name for one in OF_A_PACKET)
MAX_INSTANCES = 256
"""Of one perceptor in one cycle: more things than these are not sensed (our choice)."""
ANYTHING = "anything"


@dataclass(frozen=True, slots=True)
class Percept:
    """A belief that a perceptor brings, and what was perceived, in words."""

    term: Term
    words: str


class Perceptor:
    """One declared perceptor. Its conditions are made once for each thing."""

    def __init__(self, spec: PerceptorSpec) -> None:
        """:raises pydantic.ValidationError: if the condition is not one, or has other fields."""
        self.spec = spec
        self._names = [name for name, _ in spec.domains]
        self._made: dict[tuple[str, ...], tuple[Term, Term, Condition]] = {}
        example = _condition(spec, dict.fromkeys(self._names, ANYTHING))
        self.needs: Needs = example.needs
        self.quantities: frozenset[str] = example.quantities

    def read(self, percepts: Percepts) -> Iterator[Percept]:
        """`belief` or `not(belief)` for each thing; none while a sensor that it needs does not run."""
        if not percepts.data.holds(self.needs):
            return
        try:
            for belief, opposite, condition in self._conditions(percepts):
                verdict = condition.check(percepts)
                yield Percept(belief if verdict.holds else opposite, verdict.words)
        except SensorOff:
            # NOTE: of a condition that needs a sensor for some things only, which it does not declare
            return

    def _conditions(self, percepts: Percepts) -> Iterator[tuple[Term, Term, Condition]]:
        things = product(*(DOMAINS[domain](percepts) for _, domain in self.spec.domains))
        for chosen in islice(things, MAX_INSTANCES):
            if chosen not in self._made:
                if len(self._made) >= MAX_INSTANCES:
                    self._made.clear()
                self._made[chosen] = self._make(dict(zip(self._names, chosen, strict=True)))
            yield self._made[chosen]

    def _make(self, bindings: Mapping[str, Value]) -> tuple[Term, Term, Condition]:
        belief = instance(self.spec.belief, bindings)
        return belief, Term(NOT, (as_value(belief),)), _condition(self.spec, bindings)


def perceptor_faults(spec: PerceptorSpec) -> Iterator[Fault]:
    """Unknown conditions, fields and domains, and variables that range over nothing."""
    ranged = {name for name, _ in spec.domains}
    for _, domain in spec.domains:
        if domain not in DOMAINS:
            yield Fault(spec.place, f"unknown domain {domain}; choices: {', '.join(sorted(DOMAINS))}")
    used = dict.fromkeys((*variables_in(as_value(spec.belief)), *_variables(spec.condition)))
    for name in used:
        if name not in ranged:
            choices = ", ".join(sorted(DOMAINS))
            yield Fault(spec.place, f"?{name} ranges over nothing: add FOR ?{name} IN one of {choices}")
    for name in sorted(ranged - set(variables_in(as_value(spec.belief)))):
        yield Fault(
            spec.place, f"?{name} is not in the belief {spec.belief}: it would stand for several things"
        )
    for word in _words(spec.condition):
        if word in OF_A_PACKET_WORDS:
            yield Fault(
                spec.place,
                f"{word} is a condition on a packet; believe event(TAG, name) or packet(TAG, state)",
            )
    try:
        _condition(spec, dict.fromkeys(ranged | used.keys(), ANYTHING))
    except ValidationError as error:
        for one in error.errors():
            slot = ".".join(str(part) for part in one["loc"][1:])
            yield Fault(spec.place, f"{slot}: {one['msg']}" if slot else one["msg"])


def _condition(spec: PerceptorSpec, bindings: Mapping[str, Value]) -> Condition:
    return sensor_conditions().validate_python([_filled(spec.condition, bindings)])[0]


def _filled(data: object, bindings: Mapping[str, Value]) -> object:
    if isinstance(data, Mapping):
        return {name: _filled(one, bindings) for name, one in data.items()}
    if isinstance(data, list):
        return [_filled(one, bindings) for one in data]
    return substitute(data, bindings) if isinstance(data, Variable) else data


def _words(data: object) -> Iterator[object]:
    """The condition words, of composite conditions, too."""
    if isinstance(data, Mapping):
        yield data.get("sense")
        for one in data.values():
            yield from _words(one)
    elif isinstance(data, list):
        for one in data:
            yield from _words(one)


def condition_kinds(data: object) -> Iterator[type[Condition]]:
    """The classes of the conditions that data state, of composite conditions, too."""
    named = {one.variant_name: one for one in Condition.__subclasses__()}
    return (named[word] for word in _words(data) if isinstance(word, str) and word in named)


def _variables(data: object) -> Iterator[str]:
    if isinstance(data, Mapping):
        for one in data.values():
            yield from _variables(one)
    elif isinstance(data, list):
        for one in data:
            yield from _variables(one)
    elif isinstance(data, Variable):
        yield data.name
