"""The mission organiser: turns an approved plan-net into a behaviour script for each robot (MACTA §4)."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from app.domain.mission_organiser.behaviours_library import Library
from app.domain.mission_organiser.delegation import delegable_legs, delegation_s
from app.domain.mission_organiser.synchronisation import clearance_at, clearances, message_count
from app.domain.world_model.senses import awaited_facts, unsensed
from app.domain.world_model.vocabulary import symbolic_all
from planner import TEAM_SEPARATOR, Fact, KnowledgeBase, PlanNet, PlanNetAction, Senses
from robots.wire import BehaviourPacket, BehaviourScript, Recipient

MIN_TIMEOUT_S = 30.0
TIMEOUT_FACTOR = 4.0
"""A packet fails if it runs this many times its action's expected duration, not before `MIN_TIMEOUT_S` (our choice)."""
MIN_WAIT_S = 60.0
WAIT_FACTOR = 3.0
"""A packet may wait this many times the plan's makespan for other robots (our choice); if it depends on none of them,
`MIN_WAIT_S`.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Organised:
    """The scripts, in alphabetical order of robots, and for each action why its packet was chosen."""

    scripts: tuple[BehaviourScript, ...]
    reasons: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class OrganiserFailure:
    """The plan-net cannot be turned into scripts; `reason` names the action and what is missing."""

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketChoice:
    """The packet for a robot's part in an action, the pre-conditions it requires there, and why this one.

    :param instead_of: the other packets of the robot that achieve the same.
    :param because: the facts about the robot and the place that decided for it.
    :param events: facts that hold once it has raised an event.
    :param level: its parameter for what a number is to be at its end; empty: none.
    """

    tag: str
    requires: tuple[Fact, ...]
    instead_of: tuple[str, ...] = ()
    because: tuple[Fact, ...] = ()
    events: Mapping[str, tuple[Fact, ...]] = field(default_factory=dict)
    level: str = ""
    reason: str


def organise(
    plan_net: PlanNet,
    library: Library,
    repertoires: Mapping[str, Sequence[str]],
    mission_id: str,
    knowledge_base: KnowledgeBase,
    *,
    facts: Collection[Fact] = frozenset(),
    script_ids: Callable[[str], str] | None = None,
    answer_s: float = 0.0,
    senses: Senses | None = None,
    clearing: Collection[str] = (),
    delegating: Collection[str] = (),
    not_before_at_s: float | None = None,
) -> Organised | OrganiserFailure:
    """Match each action's linking goals against the library's index and write the scripts.

    :param repertoires: robot → tags of the packets it can carry out.
    :param facts: of the world, which decide where several packets of a robot achieve the same.
    :param script_ids: robot → script id; by default mission and robot.
    :param answer_s: how long a message to a robot and its answer may take by radio; it extends the robots' waits for
        each other.
    :param clearing: robots that clear each other; the others wait for the service's word alone.
    :param delegating: robots that may put legs to each other, if that is granted; waits are the longer for it.
    :param not_before_at_s: when goals may become true at the earliest, by the world's clock; for actions with
        `not_before_s`.
    :param senses: what robots sense now, of those that do not sense all that is sensed; None: as when it was planned.
    """
    if senses and (lacking := next(unsensed(plan_net, senses, knowledge_base), None)) is not None:
        return OrganiserFailure(reason=lacking)
    found: dict[tuple[str, str], PacketChoice] = {}
    for action in plan_net.actions:
        for agent in action.agents:
            packet = find_packet(
                plan_net,
                action,
                agent,
                library=library,
                repertoires=repertoires,
                knowledge_base=knowledge_base,
                facts=facts,
            )
            if isinstance(packet, OrganiserFailure):
                return packet
            found[action.id, agent] = packet
    name = script_ids or (lambda robot: f"{mission_id}-{robot}")
    legs = {
        robot: delegable_legs(
            plan_net,
            robot,
            {action: choice.tag for (action, agent), choice in found.items() if agent == robot},
            facts=facts,
            repertoires=repertoires,
            delegating=delegating,
            senses=plan_net.senses if senses is None else senses,
        )
        for robot in plan_net.robots
    }
    later_s = message_count(plan_net) * answer_s
    later_s += delegation_s(plan_net, [leg for of_robot in legs.values() for leg in of_robot])
    writer = _ScriptWriter(
        plan_net,
        knowledge_base,
        found,
        later_s=later_s,
        clearing=frozenset(clearing),
        script_ids=name,
        not_before_at_s=not_before_at_s,
    )
    return Organised(
        scripts=tuple(
            BehaviourScript(
                id=name(robot),
                mission_id=mission_id,
                robot=robot,
                packets=tuple(writer.packets(robot)),
                delegable=legs[robot],
            )
            for robot in plan_net.robots
        ),
        reasons={
            action.id: "; ".join(found[action.id, agent].reason for agent in action.agents)
            for action in plan_net.actions
        },
    )


class _ScriptWriter:
    """Writes packets with their symbolic conditions and times."""

    def __init__(
        self,
        plan_net: PlanNet,
        knowledge_base: KnowledgeBase,
        found: Mapping[tuple[str, str], PacketChoice],
        *,
        later_s: float,
        clearing: frozenset[str],
        script_ids: Callable[[str], str],
        not_before_at_s: float | None,
    ) -> None:
        """
        :param found: by action id and robot.
        :param later_s: how much later than planned what robots wait for may come.
        """
        self._clearing = clearing
        self._not_before_at_s = not_before_at_s
        self._script_ids = script_ids
        self._wait_timeout_s = max(MIN_WAIT_S, WAIT_FACTOR * plan_net.makespan_s) + later_s
        self._plan_net = plan_net
        self._knowledge_base = knowledge_base
        self._found = found
        self._awaits = awaited_facts(plan_net, knowledge_base)
        self._clearances = clearances(plan_net)
        self._agents = {action.id: action.agents for action in plan_net.actions}
        self._whole_s = dict(_whole_durations_s(plan_net))

    def packets(self, robot: str) -> list[BehaviourPacket]:
        return [self._packet(action, robot) for action in self._plan_net.of_robot(robot)]

    def _packet(self, action: PlanNetAction, robot: str) -> BehaviourPacket:
        found = self._found[action.id, robot]
        awaits = self._awaits.get((action.id, robot), ())
        required = tuple(f for f in action.preconditions if f in found.requires or f in awaits)
        base = self._knowledge_base
        after = self._after(action, robot)
        times = self._times(action)
        depends = bool(awaits or after or times or len(action.agents) > 1)
        return BehaviourPacket(
            id=action.id,
            tag=found.tag,
            arguments={**action.arguments, **_roles(action, robot), **_level(action, found)},
            requires=symbolic_all(required, base),
            awaits=symbolic_all(awaits, base),
            after=(*after, *times),
            told_by={one: self._told_by(one, robot) for one in after if self._told_by(one, robot)},
            tells=tuple(self._tells(action, robot)),
            achieves=symbolic_all(linking_goals(self._plan_net, action), base),
            expected_start_s=action.earliest_start_s,
            expected_duration_s=action.duration_s,
            timeout_s=max(MIN_TIMEOUT_S, TIMEOUT_FACTOR * self._whole_s[action.id]),
            wait_timeout_s=self._wait_timeout_s if depends else MIN_WAIT_S,
            description=action.description,
            instead_of=found.instead_of,
            because=symbolic_all(found.because, base),
            events={name: symbolic_all(facts, base) for name, facts in found.events.items()},
        )

    def _after(self, action: PlanNetAction, robot: str) -> tuple[str, ...]:
        """The actions whose clearance the packet waits for, without those that its robot itself does alone."""
        before = self._clearances.get(action.id, ())
        return tuple(one for one in before if self._agents[one] != (robot,))

    def _times(self, action: PlanNetAction) -> tuple[str, ...]:
        """The time that the packet waits for, if any."""
        if self._not_before_at_s is None or action.not_before_s <= 0:
            return ()
        return (clearance_at(self._not_before_at_s),)

    def _told_by(self, action: str, robot: str) -> tuple[str, ...]:
        """The robots that tell this one when they have ended their parts of an action; none if one of them cannot."""
        doers = tuple(one for one in self._agents[action] if one != robot)
        return doers if self._clearing.issuperset((robot, *doers)) else ()

    def _tells(self, action: PlanNetAction, robot: str) -> Iterator[Recipient]:
        """The robots that wait for this one's part of an action and believe it."""
        waiting = (later for later, before in self._clearances.items() if action.id in before)
        for other in dict.fromkeys(agent for later in waiting for agent in self._agents[later]):
            if other != robot and robot in self._told_by(action.id, other):
                yield Recipient(robot=other, script_id=self._script_ids(other), within_s=self._wait_timeout_s)


def _whole_durations_s(plan_net: PlanNet) -> Iterator[tuple[str, float]]:
    """By id of each action its duration; of a phase that of all those of its action: one makes up for another."""
    for robot in plan_net.robots:
        chain: list[PlanNetAction] = []
        for action in plan_net.of_robot(robot):
            chain.append(action)
            if action.phase == action.phases:
                whole_s = sum(one.duration_s for one in chain)
                yield from ((one.id, whole_s) for one in chain)
                chain = []


def _roles(action: PlanNetAction, robot: str) -> dict[str, str]:
    """The arguments for a robot's part in an action of several robots."""
    others = [agent for agent in action.agents if agent != robot]
    return {"robot": robot, "partner": TEAM_SEPARATOR.join(others)} if others else {}


def _level(action: PlanNetAction, found: PacketChoice) -> dict[str, str]:
    """The packet's parameter for what a number is to be at its end, if it has one."""
    return {found.level: f"{action.level:.3f}"} if found.level and action.level is not None else {}


def linking_goals(plan_net: PlanNet, action: PlanNetAction) -> tuple[Fact, ...]:
    """The effects that later actions or the plan's goals depend on by causal links, in the action's order."""
    linked = {link.fact for link in plan_net.causal_links if link.producer == action.id}
    return tuple(fact for fact in dict.fromkeys(action.effects) if fact in linked)


def find_packet(
    plan_net: PlanNet,
    action: PlanNetAction,
    agent: str,
    *,
    library: Library,
    repertoires: Mapping[str, Sequence[str]],
    knowledge_base: KnowledgeBase,
    facts: Collection[Fact],
) -> PacketChoice | OrganiserFailure:
    """The packet that does the agent's part; a failure if there is none, or none of several is meant for it.

    Of several that the robot has, the one with the most facts `when` it is chosen; of equally many the library's first.
    """
    goals = _effects_to_achieve(plan_net, action, agent)
    wanted = " and ".join(map(str, symbolic_all(goals, knowledge_base))) or "nothing that is linked"
    what = f"{action.id} {action.tag}"
    fitting = [
        (entry, found)
        for entry in library.achieving(goals)
        if (found := entry.fits(action, agent, goals)) is not None
    ]
    if not fitting:
        return OrganiserFailure(
            reason=f"{what}: no packet in the behaviours library achieves {wanted} from what the action requires"
        )
    able = [pair for pair in fitting if pair[0].basic or pair[0].tag in repertoires.get(agent, ())]
    if not able:
        tags = " or ".join(dict.fromkeys(entry.tag for entry, _ in fitting))
        return OrganiserFailure(reason=f"{what}: {agent} has no {tags} in its repertoire")
    suited = [
        (entry, found, because)
        for entry, found in able
        if (because := entry.suited(found, facts)) is not None
    ]
    if not suited:
        tags = " and ".join(dict.fromkeys(entry.tag for entry, _ in able))
        return OrganiserFailure(reason=f"{what}: {tags} are not meant for {agent} and this place")
    entry, found, because = max(suited, key=lambda one: len(one[2]))  # of equally many, the library's first
    rivals = {one.tag for one, _, facts_of in suited if not facts_of} | {entry.tag}
    if not because and len(rivals) > 1:
        return OrganiserFailure(
            reason=f"{what}: {' and '.join(sorted(rivals))} all achieve {wanted}; one packet must"
        )
    required = {template.filled(found) for template in entry.requires}
    return PacketChoice(
        tag=entry.tag,
        requires=tuple(fact for fact in action.preconditions if fact in required),
        instead_of=tuple(dict.fromkeys(one.tag for one, _ in able if one.tag != entry.tag)),
        because=because,
        level=entry.level,
        events={name: tuple(one.filled(found) for one in templates) for name, templates in entry.events},
        reason=f"{agent} does {entry.tag}: it achieves {wanted}",
    )


def _effects_to_achieve(plan_net: PlanNet, action: PlanNetAction, agent: str) -> tuple[Fact, ...]:
    """The intended effects that `agent`'s packet must achieve: linked, and naming no other agent of the action."""
    others = set(action.agents) - {agent}
    mine = [fact for fact in action.intended_effects if not others & set(fact.args)]
    linked = set(linking_goals(plan_net, action))
    return tuple(fact for fact in mine if fact in linked) or tuple(mine)
