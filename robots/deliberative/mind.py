"""The mind of one robot: its agents, who share its body by competence and rank (SRA: several agents supervise a robot).

An earlier agent ranks before a later one: its packets take the body from the other's, which wait until it is free. A
packet of the robot's upkeep or of an operator who drives it comes before all of them.
"""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from math import inf

from robots.deliberative.actuators import (
    DONE,
    Activation,
    Attempt,
    Claim,
    Outcome,
    Speak,
    Utterance,
    restored_outcome,
    stored_outcome,
)
from robots.deliberative.agent import Agent
from robots.deliberative.commitments import DropReason
from robots.deliberative.costs import BATTERY, LASTS
from robots.deliberative.program import Await, RuleFile, Verb, parts_of, plans_of
from robots.deliberative.reader import beliefs_of
from robots.deliberative.rule_set import read_rule_set, teams_of
from robots.deliberative.situation import CHARGING, Task, known_of, taken_over
from robots.deliberative.stored import restored, stored
from robots.deliberative.terms import Term, as_value, unify
from robots.deliberative.told import told_agent, told_message
from robots.deliberative.vocabulary import EVENT, HOME, ME, MESSAGE, PACKET, ROLE, SCRIPT
from robots.errors import RuleError
from robots.executive.breakpoints import HeldFiring
from robots.executive.executive import Executive
from robots.executive.leg_cost import way_to_s
from robots.executive.mind_memory import AttemptMemory, HeardMemory, MindMemory, SharedBodyMemory
from robots.executive.own_packets import why_held
from robots.perception.percepts import NOTHING, Needs, Percepts
from robots.physical.profile import RobotProfile
from robots.repertoire import Repertoire
from robots.wire import (
    MAX_TOLD,
    MAX_TOLD_MESSAGES,
    OWN,
    BehaviourPacket,
    BehaviourScript,
    ScriptState,
    ToldAgent,
    ToldMessage,
)

TIMEOUT_S = 60.0
WAIT_TIMEOUT_S = 30.0
"""Of a packet whose rule does not say otherwise."""
MAX_HEARD = 64
"""Messages in one cycle; later ones wait."""


class Mind:
    """The agents of a robot. To be given to its `BehaviouralAgent`."""

    def __init__(
        self,
        profile: RobotProfile,
        repertoire: Repertoire,
        files: Sequence[RuleFile],
        *,
        speak: Speak | None = None,
        competence: Mapping[str, frozenset[str]] | None = None,
        role: str = "",
        now_s: float = 0.0,
    ) -> None:
        """
        :param files: of agents, in order of rank, and of roles that any of them may take.
        :param speak: sends what they say; None: nobody hears them.
        :param competence: the actuators that an agent may use, by its name; an agent that is left out may use all.
        :param role: that the robot plays; empty: none.
        :raises RuleError: naming what cannot be used, and why.
        """
        self._profile = profile
        self._repertoire = repertoire
        self._speak = speak
        self._competence = competence or {}
        self._heard: list[Utterance] = []
        self._told_messages: deque[ToldMessage] = deque(maxlen=MAX_TOLD_MESSAGES)
        self._body = _Body(profile)
        self._files: tuple[RuleFile, ...] = ()
        self._takes_over = frozenset[str]()
        self._listens_to: list[Term] = []
        self.version = 0
        """Of the rules that were sent last; 0: those that it was made with."""
        self.role = ""
        self.agents: list[Agent] = []
        self._breakpoints = frozenset[str]()
        self.load(files, now_s, role)

    @property
    def needs(self) -> Needs:
        """The sensors that the rules need now."""
        return NOTHING.union(*(agent.needs for agent in self.agents))

    def load(self, files: Sequence[RuleFile], now_s: float, role: str = "") -> None:
        """Use these rules from the next cycle on. Agents of the same name keep what they have adopted as beliefs, and
        what they have retracted.

        :param role: that every agent believes the robot to play; empty: none.
        :raises RuleError: naming what cannot be used; then nothing changes.
        """
        teams = teams_of(files, self._repertoire)
        for team in teams:
            self._check_competence(team)
        agents = [self._agent(team, rank, now_s, role) for rank, team in enumerate(teams)]
        missing = NOTHING.union(*(agent.all_needs for agent in agents)) - self._profile.sensors
        if missing:
            names = ", ".join(file.name for file in files)
            raise RuleError(
                f"{self._profile.name} has no {', '.join(sorted(missing))}, which rules {names} need"
            )
        before = {agent.name: agent for agent in self.agents}
        for agent in self.agents:
            agent.end(DropReason.RULES, "its rules were replaced", now_s)
        for agent in agents:
            if agent.name in before:
                agent.retract(before[agent.name].retracted())
                agent.adopt(before[agent.name].lasting(), now_s)
        self.agents = agents
        self.break_at(self._breakpoints)
        self._takes_over = taken_over([agent.name for agent in agents])
        self.role = role
        self._files = tuple(files)
        self._listens_to = [one for file in files for one in believed(file) if one.functor == MESSAGE]

    def break_at(self, rules: frozenset[str]) -> None:
        """Hold back what these rules, "guard:3" and the like, commit to until the next cycle."""
        self._breakpoints = rules
        for agent in self.agents:
            agent.breakpoints = rules

    @property
    def held(self) -> Sequence[HeldFiring]:
        """What is held back until the next cycle, by rank of the agents."""
        return [one for agent in self.agents for one in agent.held]

    @property
    def charges(self) -> bool:
        """True if an agent of that name looks after the battery."""
        return any(agent.name == CHARGING for agent in self.agents)

    @property
    def takes_over(self) -> frozenset[str]:
        """The packets' events on which its agents act in place of the packets' own retries and limits."""
        return self._takes_over

    @property
    def digests(self) -> Mapping[str, str]:
        """Of the rule files in use, by name."""
        return {file.name: file.version for file in self._files}

    def told(self) -> tuple[ToldAgent, ...]:
        """What its agents believe and are committed to, in order of rank."""
        return tuple(told_agent(agent, MAX_TOLD // len(self.agents)) for agent in self.agents)

    def follow(self, files: Mapping[str, str], version: int, now_s: float, role: str = "") -> str | None:
        """Follow these rule files in this role, or return the reason against them; then the present ones stay."""
        try:
            self.load(read_rule_set(files), now_s, role)
        except RuleError as error:
            return str(error)
        self.version = version
        return None

    def memory(self) -> MindMemory:
        """The rule files, the role, and what the agents have adopted and retracted."""
        return MindMemory(
            version=self.version,
            files={file.name: file.text for file in self._files},
            role=self.role,
            beliefs={agent.name: tuple(map(str, agent.lasting())) for agent in self.agents},
            retracted={agent.name: tuple(map(str, agent.retracted())) for agent in self.agents},
        )

    def hand_over(self) -> MindMemory:
        """The memory with all that the agents believe and are committed to, for another program."""
        body = self._body
        running = body.running
        shared = SharedBodyMemory(count=body.count)
        if running is not None:
            outcome = stored_outcome(running.outcome)
            attempt = AttemptMemory(script_id=running.script_id, outcome=outcome)
            shared = SharedBodyMemory(count=body.count, running=attempt, rank=running.rank)
        more = {
            "agents": {agent.name: agent.memory() for agent in self.agents},
            "body": shared,
            "heard": tuple(
                HeardMemory(performative=one.performative, other=one.other, content=stored(one.content))
                for one in self._heard
            ),
            "told": tuple(self._told_messages),
        }
        return self.memory().model_copy(update=more)

    def recall(self, memory: MindMemory, now_s: float) -> None:
        """Restore it. Rules that the robot can no longer follow are left out.

        :raises RuleError: if a mind that was handed over is none of these rules.
        """
        if self.follow(memory.files, memory.version, now_s, memory.role) is not None:
            return
        if memory.agents is not None:
            self._take_over(memory)
            return
        for agent in self.agents:
            retracted = memory.retracted.get(agent.name, ())
            agent.retract(term for term in agent.initial if str(term) in retracted)
            for text in memory.beliefs.get(agent.name, ()):
                with suppress(RuleError):  # a name of a message's content that no rule file can write
                    agent.adopt(beliefs_of([text]), now_s)

    def _take_over(self, memory: MindMemory) -> None:
        body = self._body
        shared = memory.body
        body.count = shared.count
        body.running = None
        if shared.running is not None:
            body.running = _PacketAttempt(body, shared.running.script_id, shared.rank)
            body.running.recall(shared.running)
        for agent in self.agents:
            if (one := (memory.agents or {}).get(agent.name)) is not None:
                agent.recall(one)
        self._heard = [
            Utterance(performative=one.performative, other=one.other, content=restored(one.content))
            for one in memory.heard
        ]
        self._told_messages.extend(memory.told)

    def hear(self, utterance: Utterance, now_s: float) -> bool:
        """Believe in the next cycle that someone has said this; False if no condition may match it."""
        self._told_messages.append(told_message(utterance, now_s))
        said = as_value(_message(utterance))
        if not any(unify(as_value(one), said) is not None for one in self._listens_to):
            return False
        self._heard.append(utterance)
        return True

    @property
    def told_messages(self) -> tuple[ToldMessage, ...]:
        """What was said to the robot and nothing but its rules may take, the last ones, oldest first."""
        return tuple(self._told_messages)

    def cycle(self, executive: Executive, percepts: Percepts | None, now_s: float) -> None:
        """One cycle of every agent, by rank."""
        self._body.executive = executive
        self._body.percepts = percepts
        self._body.now_s = now_s
        heard = self._heard[:MAX_HEARD]
        del self._heard[:MAX_HEARD]
        events = [_message(one) for one in heard]
        while executive.news:
            news = executive.news.popleft()
            events += [Term(EVENT, (news.tag, name)) for name in news.events]
            if news.tag:
                events.append(Term(PACKET, (news.tag, news.state.value)))
            else:
                events.append(Term(SCRIPT, (news.state.value,)))
        script = executive.script
        run = executive.current
        is_served = script is not None and not script.is_own and run is not None
        task = Task(tag=run.packet.tag, arguments=run.packet.arguments) if is_served and run else None
        known = known_of(task, percepts)
        for agent in self.agents:
            agent.cycle(now_s, events, percepts, known)
        self._body.grant()

    def _agent(self, team: Sequence[RuleFile], rank: int, now_s: float, role: str) -> Agent:
        known = [Term(ME, (self._profile.name,))]
        if self._profile.home is not None:
            known.append(Term(HOME, (self._profile.home,)))
        if role:
            known.append(Term(ROLE, (role,)))
        actuators = _AgentActuators(self._body, rank, self._speak)
        return Agent(team[0].name, team, actuators, known=known, now_s=now_s)

    def _check_competence(self, team: Sequence[RuleFile]) -> None:
        name = team[0].name
        allowed = self._competence.get(name)
        for file in team:
            refused = sorted(file.actuators.keys() - allowed) if allowed is not None else []
            if refused:
                granted = ", ".join(sorted(allowed or ())) or "none"
                raise RuleError(
                    f"{file.origin}: {name} may not use {', '.join(refused)}; its actuators: {granted}"
                )


def _message(utterance: Utterance) -> Term:
    return Term(MESSAGE, (utterance.performative, utterance.other, utterance.content))


def believed(file: RuleFile) -> Iterator[Term]:
    """The terms of the conditions of its rules and plans."""
    for rule in file.rules:
        yield from (one.term for one in rule.when.positive)
    for plan in plans_of(file):
        yield from (one.term for one in plan.when.positive)
    for step in (*(rule.step for rule in file.rules), *(plan.step for plan in plans_of(file))):
        for part in parts_of(step):
            if isinstance(part, Await):
                yield from (one.term for one in part.conditions.positive)


@dataclass(slots=True)
class _Body:
    """What the agents share, as of this cycle, and the packet that one of them runs."""

    profile: RobotProfile
    executive: Executive | None = None
    percepts: Percepts | None = None
    now_s: float = 0.0
    count: int = 0
    running: "_PacketAttempt | None" = None
    """The last one."""
    claims: list[Claim] = field(default_factory=list)
    """Those that waited in this cycle for the body, which was free."""
    granted: Claim | None = None
    """That has the body in this cycle, if it is free."""

    def grant(self) -> None:
        """Give the body to the cheapest of the claims in the next cycle; of equal ones to the earlier agent's."""
        claims = self.claims
        self.claims = []
        self.granted = None
        if not claims:
            return
        known = [one.cost() for one in claims]
        costs = [inf if cost is None else cost for cost in known]
        first = costs.index(min(costs))
        self.granted = claims[first]
        for one, cost in zip(claims, costs, strict=True):
            if one is not self.granted:
                best = f"{self.granted.title}, which costs {costs[first]:.3g}"
                one.tell(f"waits at {cost:.3g} for {best}")


@dataclass(slots=True)
class _PacketAttempt:
    """A packet that an agent of this rank runs, as a script of the robot's own."""

    body: _Body
    script_id: str
    rank: int
    claim: Claim | None = None
    _outcome: Outcome | None = field(default=None, init=False)

    @property
    def outcome(self) -> Outcome | None:
        executive = self.body.executive
        if self._outcome is None and executive is not None:
            state = executive.state_of(self.script_id)
            is_last = executive.script_id == self.script_id
            words = executive.end_reason if is_last else executive.own_reason
            if state is ScriptState.FINISHED:
                self._outcome = DONE
            elif state is ScriptState.FAILED:
                self._outcome = Outcome(False, words)
            elif state is ScriptState.CANCELLED or state is None:
                self._outcome = Outcome(False, "the robot was ordered otherwise", DropReason.ORDER)
        return self._outcome

    def recall(self, memory: AttemptMemory) -> None:
        self._outcome = restored_outcome(memory.outcome)

    def cancel(self, words: str) -> None:
        if self.outcome is None and self.body.executive is not None:
            self._outcome = Outcome(False, words, DropReason.REPLACED)
            self.body.executive.withdraw_own(self.script_id, self.body.percepts, self.body.now_s)


class _AgentActuators:
    """The actuators as one agent has them."""

    def __init__(self, body: _Body, rank: int, speak: Speak | None) -> None:
        self._body = body
        self._rank = rank
        self._speak = speak

    def activate(self, wanted: Activation) -> Attempt | Outcome | None:
        body = self._body
        executive = body.executive
        running = body.running if body.running is not None and body.running.outcome is None else None
        if executive is None or not self._may_begin(executive, wanted, running):
            return None
        if executive.script is None and body.percepts is not None:
            held = why_held(body.profile, body.percepts, may_carry=True)
            if held is not None:
                return Outcome(False, held)
        if running is not None:
            running.cancel(f"{wanted.tag} of {wanted.because} takes its place")
        own = self._script(wanted)
        if executive.script is None:
            refusal = executive.begin_own(own, body.percepts, body.now_s)
        else:
            refusal = executive.interpose(
                own, body.percepts, body.now_s, may_carry=wanted.may_carry, because=wanted.because
            )
        if refusal is not None:
            return Outcome(False, refusal)
        body.running = _PacketAttempt(body, own.id, self._rank, wanted.claim)
        return body.running

    def resume(self, wanted: Activation, memory: AttemptMemory) -> Attempt:
        running = self._body.running
        if running is not None and running.script_id == memory.script_id:
            running.claim = wanted.claim
            return running
        attempt = _PacketAttempt(self._body, memory.script_id, self._rank, wanted.claim)
        attempt.recall(memory)
        return attempt

    def standing(self, claim: Claim) -> tuple[bool, bool]:
        body = self._body
        return body.granted is claim, body.running is not None and body.running.claim is claim

    def restore_standing(self, claim: Claim, *, is_granted: bool, keeps: bool) -> None:
        if is_granted:
            self._body.granted = claim
        if keeps and self._body.running is not None:
            self._body.running.claim = claim

    def _may_begin(self, executive: Executive, wanted: Activation, running: _PacketAttempt | None) -> bool:
        """Whether nothing goes before a packet that an agent wants. `running`: the agents' own, None if none runs."""
        if running is not None and self._goes_first(running, wanted):
            return False
        script = executive.script
        if script is not None and script.is_own and (running is None or running.script_id != script.id):
            return False  # upkeep, or an operator drives the robot
        current = executive.current
        if current is not None and (current.grips or executive.state is ScriptState.PAUSED):
            return False
        return running is not None or self._has_turn(wanted.claim)

    def _goes_first(self, running: _PacketAttempt, wanted: Activation) -> bool:
        """Plans with a cost leave each other the body; others take it from agents of their own or a later rank."""
        if running.claim is not None and wanted.claim is not None:
            return True
        return running.rank < self._rank

    def _has_turn(self, claim: Claim | None) -> bool:
        """Whether a claim has the free body now: granted, or kept from packet to packet; if not, it is noted."""
        body = self._body
        keeps = body.granted is None and body.running is not None and body.running.claim is claim
        if claim is None or claim is body.granted or keeps:
            return True
        body.claims.append(claim)
        return False

    def say(self, utterance: Utterance) -> Outcome:
        if self._speak is None:
            return Outcome(False, f"{self._body.profile.name} cannot speak to {utterance.other}")
        refusal = self._speak(utterance)
        return DONE if refusal is None else Outcome(False, refusal)

    @property
    def senses(self) -> bool:
        return self._body.percepts is not None

    def measure(self, name: str, arguments: tuple[str, ...]) -> float | None:
        percepts = self._body.percepts
        if percepts is None:
            return None
        if name == BATTERY:
            return percepts.battery
        if name == LASTS:
            lasted_s = None if self._body.executive is None else self._body.executive.lasted_s(arguments[0])
            return TIMEOUT_S / 2 if lasted_s is None else lasted_s
        return way_to_s(arguments[0], percepts)

    def steer(self, verb: Verb, reason: str) -> Outcome:
        body = self._body
        executive = body.executive
        if executive is None:
            return Outcome(False, "no packet is under way")
        if verb is Verb.SUSPEND:
            refusal = executive.suspend(reason, body.percepts, body.now_s)
        elif verb is Verb.RESUME:
            refusal = executive.resume_suspended(body.percepts, body.now_s)
        elif verb is Verb.RETRY:
            refusal = executive.begin_again(reason, body.percepts, body.now_s)
        else:
            refusal = executive.give_up(reason, body.percepts, body.now_s)
        return DONE if refusal is None else Outcome(False, refusal)

    def _script(self, wanted: Activation) -> BehaviourScript:
        body = self._body
        body.count += 1
        # NOTE: the time tells it from those before a restart, whose ids the executive remembers.
        name = f"{wanted.agent}_{body.now_s:.2f}_{body.count}"
        timeout_s = wanted.timeout_s if wanted.timeout_s is not None else TIMEOUT_S
        wait_s = wanted.wait_timeout_s if wanted.wait_timeout_s is not None else WAIT_TIMEOUT_S
        packet = BehaviourPacket(
            id=name,
            tag=wanted.tag,
            arguments=dict(wanted.arguments),
            expected_start_s=0.0,
            expected_duration_s=max(timeout_s / 2, 0.1),
            timeout_s=max(timeout_s, 0.1),
            wait_timeout_s=max(wait_s, 0.1),
            description=f"by {wanted.because}",
        )
        return BehaviourScript(id=f"{OWN}:{name}", mission_id=OWN, robot=body.profile.name, packets=(packet,))
