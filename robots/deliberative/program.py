"""A rule file as data: what its text declares, each part with its place in the text."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from robots.data import StrEnum
from robots.deliberative.terms import Term, Value


@dataclass(frozen=True, slots=True)
class Place:
    """A place in a rule file, both counted from 1."""

    line: int
    column: int


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong at a place, and what may stand there."""

    place: Place
    words: str


@dataclass(frozen=True, slots=True)
class Literal:
    """`BELIEF(term)`, or `!BELIEF(term)`: not believed."""

    term: Term
    negated: bool
    place: Place


@dataclass(frozen=True, slots=True)
class Guard:
    """A comparison of bound values, such as `?share < 0.3`."""

    left: Value
    operator: str
    right: Value
    place: Place


@dataclass(frozen=True, slots=True)
class Conditions:
    """All of these; without any it always holds."""

    literals: tuple[Literal, ...] = ()
    guards: tuple[Guard, ...] = ()

    @property
    def positive(self) -> Iterator[Literal]:
        return (one for one in self.literals if not one.negated)


class Verb(StrEnum):
    """What a commitment may do with the packet under way."""

    SUSPEND = "suspend"
    """The robot stands until `resume`."""
    RESUME = "resume"
    """Go on with a suspended packet."""
    RETRY = "retry"
    """Begin the packet again."""
    GIVE_UP = "giveUp"
    """The packet has failed, and its script with it."""


@dataclass(frozen=True, slots=True)
class Adopt:
    """`adoptBelief(term)`."""

    term: Term
    place: Place


@dataclass(frozen=True, slots=True)
class Retract:
    """`retractBelief(term)`."""

    term: Term
    place: Place


@dataclass(frozen=True, slots=True)
class Activate:
    """`activate(TAG(name: value))`: run a packet of the repertoire."""

    tag: str
    arguments: tuple[tuple[str, Value], ...]
    place: Place


@dataclass(frozen=True, slots=True)
class Say:
    """`say(performative, receiver, content)`."""

    performative: Value
    receiver: Value
    content: Value
    place: Place


@dataclass(frozen=True, slots=True)
class Steer:
    """`suspend()`, `resume()`, `retry()` or `giveUp(reason)`, of the packet under way."""

    verb: Verb
    reason: Value
    place: Place


@dataclass(frozen=True, slots=True)
class RunPlan:
    """`name(values)`: a plan of the agent."""

    name: str
    values: tuple[Value, ...]
    place: Place


class Joint(StrEnum):
    """How the steps of a group are carried out."""

    SEQ = "SEQ"
    """One after the other; it fails with the first that fails."""
    PAR = "PAR"
    """All at once; it ends when all have ended, and has failed if one has."""
    OR = "OR"
    """One after the other, until one is fulfilled."""


@dataclass(frozen=True, slots=True)
class Group:
    """`SEQ(...)`, `PAR(...)` or `OR(...)`."""

    joint: Joint
    steps: "tuple[Step, ...]"
    place: Place


@dataclass(frozen=True, slots=True)
class Await:
    """`AWAIT(conditions)`: fulfilled once they hold."""

    conditions: Conditions
    place: Place


@dataclass(frozen=True, slots=True)
class Delay:
    """`DELAY(seconds)`."""

    seconds: Value
    place: Place


Action = Adopt | Retract | Activate | Say | Steer
"""The four things that a commitment may do."""
Step = Action | RunPlan | Group | Await | Delay


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """`conditions => COMMIT(agent, Now + delay_s, maintain, step)`. `agent`: to whom the robot commits itself."""

    number: int
    when: Conditions
    agent: Value
    delay_s: Value
    maintain: Conditions
    step: Step
    place: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """`PLAN name(?parameters) WHEN conditions COST seconds { step; ... }`: p = ⟨t(p), c(p), bd(p)⟩ (P-SMPA §4).

    Its name is what invokes it, `when` its context condition, whose variables its cost and steps may use. Without a
    cost it counts as 0 among its fellows.
    """

    name: str
    parameters: tuple[str, ...]
    when: Conditions = Conditions()
    cost: Value | None = None
    competes: bool = False
    step: Step
    place: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class PerceptorSpec:
    """`PERCEPTOR belief IS condition FOR ?variable IN domain;`.

    `condition`: the condition word and its fields, as in a packet's file, with variables in the places of values.
    """

    belief: Term
    condition: Mapping[str, object]
    domains: tuple[tuple[str, str], ...]
    place: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class RuleFile:
    """What a rule file says.

    :param version: the digest of its text.
    :param is_role: its rules apply only while `role(name)` is believed.
    :param actuators: what its commitments may use, by name; the choices that they are limited to, empty for all.
    :param carries: the packets that may run while the robot holds something.
    """

    name: str
    version: str
    is_role: bool
    origin: str
    text: str = field(repr=False)
    perceptors: tuple[PerceptorSpec, ...] = ()
    actuators: Mapping[str, frozenset[str]] = field(default_factory=dict)
    carries: frozenset[str] = frozenset()
    initial: tuple[Literal, ...] = ()
    rules: tuple[Rule, ...] = ()
    plans: Mapping[str, tuple[Plan, ...]] = field(default_factory=dict)


def plans_of(file: RuleFile) -> Iterator[Plan]:
    """All plans of a file."""
    for some in file.plans.values():
        yield from some


def parts_of(step: Step) -> Iterator[Step]:
    """The step and all steps within it, without those of other plans."""
    yield step
    if isinstance(step, Group):
        for one in step.steps:
            yield from parts_of(one)
