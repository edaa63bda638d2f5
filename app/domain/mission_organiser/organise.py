"""The mission organiser: from an approved plan-net to one behaviour script a robot (MACTA §4)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from app.domain.mission_organiser.behaviours_library import Library
from app.domain.mission_organiser.coupling import Awaits, awaited, cleared, exchanges
from app.domain.mission_organiser.matching import Found, find_packet, linking_goals
from app.domain.world_model.vocabulary import symbolic_all
from planner import TEAM_SEPARATOR, KnowledgeBase, PlanNet, PlanNetAction
from robots.wire import BehaviourPacket, BehaviourScript

SHORTEST_TIMEOUT_S = 30.0
TIMEOUT_FACTOR = 4.0
"""A packet may run this many times its expected duration before it has failed (our choice)."""
SHORTEST_WAIT_S = 60.0
WAIT_FACTOR = 3.0
"""A packet may wait this many times the whole plan's span for what other robots are to bring about (our choice); for
what none of them is to, no longer than `SHORTEST_WAIT_S`.
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


def organise(
    plan_net: PlanNet,
    library: Library,
    repertoires: Mapping[str, Sequence[str]],
    mission_id: str,
    knowledge_base: KnowledgeBase,
    *,
    script_ids: Callable[[str], str] | None = None,
    answer_s: float = 0.0,
) -> Organised | OrganiserFailure:
    """Match each action's linking goals against the library's index and write the scripts.

    :param repertoires: robot → tags of the packets it can carry out.
    :param script_ids: robot → script id; by default mission and robot.
    :param answer_s: what a word to a robot and its answer may take by radio: so much longer robots wait for each other.
    """
    found: dict[tuple[str, str], Found] = {}
    for action in plan_net.actions:
        for agent in action.agents:
            packet = find_packet(
                plan_net,
                action,
                agent,
                library=library,
                repertoires=repertoires,
                knowledge_base=knowledge_base,
            )
            if isinstance(packet, str):
                return OrganiserFailure(reason=packet)
            found[action.id, agent] = packet
    name = script_ids or (lambda robot: f"{mission_id}-{robot}")
    patience_s = exchanges(plan_net) * answer_s
    write = _Writer(plan_net, knowledge_base, found, awaited(plan_net, knowledge_base), patience_s)
    return Organised(
        scripts=tuple(
            BehaviourScript(
                id=name(robot), mission_id=mission_id, robot=robot, packets=tuple(write.packets(robot))
            )
            for robot in plan_net.robots
        ),
        reasons={
            action.id: "; ".join(found[action.id, agent].reason for agent in action.agents)
            for action in plan_net.actions
        },
    )


class _Writer:
    """Writes packets with their symbolic conditions and times."""

    def __init__(
        self,
        plan_net: PlanNet,
        knowledge_base: KnowledgeBase,
        found: Mapping[tuple[str, str], Found],
        awaits: Awaits,
        radio_s: float,
    ) -> None:
        self._patience_s = max(SHORTEST_WAIT_S, WAIT_FACTOR * plan_net.makespan_s) + radio_s
        self._plan_net, self._knowledge_base = plan_net, knowledge_base
        self._found, self._awaits, self._cleared = found, awaits, cleared(plan_net)
        self._agents = {action.id: action.agents for action in plan_net.actions}

    def packets(self, robot: str) -> list[BehaviourPacket]:
        return [self._packet(action, robot) for action in self._plan_net.of_robot(robot)]

    def _packet(self, action: PlanNetAction, robot: str) -> BehaviourPacket:
        found = self._found[action.id, robot]
        awaits = self._awaits.get((action.id, robot), ())
        required = tuple(f for f in action.preconditions if f in found.requires or f in awaits)
        base, after = self._knowledge_base, self._after(action, robot)
        depends = bool(awaits or after or len(action.agents) > 1)
        return BehaviourPacket(
            id=action.id,
            tag=found.tag,
            arguments={**action.arguments, **_roles(action, robot)},
            requires=symbolic_all(required, base),
            awaits=symbolic_all(awaits, base),
            after=after,
            achieves=symbolic_all(linking_goals(self._plan_net, action), base),
            expected_start_s=action.earliest_start_s,
            expected_duration_s=action.duration_s,
            timeout_s=max(SHORTEST_TIMEOUT_S, TIMEOUT_FACTOR * action.duration_s),
            wait_timeout_s=self._patience_s if depends else SHORTEST_WAIT_S,
            description=action.description,
        )

    def _after(self, action: PlanNetAction, robot: str) -> tuple[str, ...]:
        """The actions it is to be cleared of: not those it does alone, for it knows when they have ended."""
        before = self._cleared.get(action.id, ())
        return tuple(one for one in before if self._agents[one] != (robot,))


def _roles(action: PlanNetAction, robot: str) -> dict[str, str]:
    """Who is who for a robot that acts with others: `robots` lists them all, in the same order for each."""
    others = [agent for agent in action.agents if agent != robot]
    return {"robot": robot, "partner": TEAM_SEPARATOR.join(others)} if others else {}
