"""Rules tried on what a robot has recorded: which of them would have fired, when and with which values.

Nothing is acted on. Every action is taken to succeed at once, and the record goes on as it was.
"""

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from operator import itemgetter

from robots.conditions.own_state import Bumped
from robots.conditions.verdict import Condition
from robots.deliberative.actuators import DONE, Activation, Attempt, Claim, Outcome, Utterance
from robots.deliberative.agent import Agent
from robots.deliberative.commitments import Commitment
from robots.deliberative.perceptors import Perceptor, condition_kinds
from robots.deliberative.program import PerceptorSpec, RuleFile, Verb
from robots.deliberative.rule_set import teams_of
from robots.deliberative.situation import Task, known_of, taken_over
from robots.deliberative.terms import Term
from robots.deliberative.vocabulary import EVENT, HOME, ME, PACKET, SCRIPT
from robots.errors import RuleError
from robots.executive.mind_memory import AttemptMemory
from robots.perception.percepts import Needs, Percepts
from robots.reactive.stall import for_rules
from robots.repertoire import Repertoire

_OF_OTHERS_IN_VIEW = ("robots.conditions.sight", "robots.conditions.long_objects")
"""The modules of conditions that ask for beacons and robots in view."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedInstant:
    """What a robot perceived at a time, and what became of its packets and scripts since the last one.

    :param raised: packets' tags with the events that they raised. :param packets: tags with new states.
    :param scripts: new states. :param task: the packet of the service's script that was under way.
    :param heard: what was said to the robot, `message(performative, sender, content)`.
    """

    percepts: Percepts
    raised: Sequence[tuple[str, str]] = ()
    packets: Sequence[tuple[str, str]] = ()
    scripts: Sequence[str] = ()
    task: Task | None = None
    heard: Sequence[Term] = ()

    def events(self, left_to_rules: Container[str]) -> Iterator[Term]:
        """As rules that act on some of the packets' events would have heard them."""
        for tag, raised in groupby(self.raised, key=itemgetter(0)):
            yield from (
                Term(EVENT, (tag, name)) for name in for_rules([one for _, one in raised], left_to_rules)
            )
        yield from self.heard
        yield from (Term(PACKET, one) for one in self.packets)
        yield from (Term(SCRIPT, (one,)) for one in self.scripts)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rehearsal:
    """:param fired: each firing of a rule by its agent. :param unread: perceptors of which the record says nothing."""

    fired: Sequence[tuple[str, Commitment]]
    unread: Sequence[tuple[str, PerceptorSpec]]


def rehearse(
    files: Sequence[RuleFile],
    repertoire: Repertoire,
    instants: Iterable[RecordedInstant],
    *,
    robot: str,
    home: str | None = None,
    has_touches: bool = True,
) -> Rehearsal:
    """Let each agent deliberate once for each instant.

    :param has_touches: whether the instants have what the bumper has read.
    :raises RuleError: naming file, line and column of each fault.
    """
    known = [Term(ME, (robot,)), *([Term(HOME, (home,))] if home else [])]
    instants = list(instants)
    sensed = frozenset[str]().union(*(one.percepts.data.values for one in instants))
    unknown = frozenset() if has_touches else frozenset({Bumped})
    unread: list[tuple[str, PerceptorSpec]] = []
    agents: list[Agent] = []
    for team in teams_of(files, repertoire):
        readable = [
            _readable(file, partial(_is_recorded, sensed=sensed, unknown=unknown), unread) for file in team
        ]
        agents.append(Agent(team[0].name, readable, _Pretended(), known=known))
    fired: list[tuple[str, Commitment]] = []
    left_to_rules = taken_over([agent.name for agent in agents])
    for instant in instants:
        known_now = known_of(instant.task, instant.percepts)
        events = list(instant.events(left_to_rules))
        for agent in agents:
            agent.cycle(instant.percepts.time_s, events, instant.percepts, known_now)
            fired += [(agent.name, one) for one in agent.made]
    return Rehearsal(
        fired=fired, unread=[one for number, one in enumerate(unread) if one not in unread[:number]]
    )


def _readable(
    file: RuleFile, is_recorded: Callable[[PerceptorSpec], bool], unread: list[tuple[str, PerceptorSpec]]
) -> RuleFile:
    """The file without the perceptors of which the record says nothing; those are added to `unread`."""
    kept = []
    for spec in file.perceptors:
        if is_recorded(spec):
            kept.append(spec)
        else:
            unread.append((file.name, spec))
    return replace(file, perceptors=tuple(kept))


def _is_recorded(spec: PerceptorSpec, *, sensed: Needs, unknown: frozenset[type[Condition]]) -> bool:
    """:param sensed: the sensors of which the record has readings. :param unknown: conditions on what it has not."""
    perceptor = Perceptor(spec)
    kinds = set(condition_kinds(spec.condition))
    of_others = any(kind.__module__ in _OF_OTHERS_IN_VIEW for kind in kinds)
    return not of_others and not perceptor.quantities and perceptor.needs <= sensed and not kinds & unknown


class _Pretended:
    """Actuators that do nothing."""

    senses = True

    def activate(self, wanted: Activation) -> Outcome:
        return DONE

    def resume(self, wanted: Activation, memory: AttemptMemory) -> Attempt:
        """:raises RuleError: always: a rehearsal begins at its beginning."""
        raise RuleError(f"{wanted.tag} cannot be gone on with in a rehearsal")

    def standing(self, claim: Claim) -> tuple[bool, bool]:
        return False, False

    def restore_standing(self, claim: Claim, *, is_granted: bool, keeps: bool) -> None:
        """Nothing: no claim waits."""

    def say(self, utterance: Utterance) -> Outcome:
        return DONE

    def measure(self, name: str, arguments: tuple[str, ...]) -> float | None:
        return 0.0

    def steer(self, verb: Verb, reason: str) -> Outcome:
        return DONE
