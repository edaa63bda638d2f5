"""Which packet of the behaviours library carries out an action: found by its linking goals (MACTA §4)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.domain.mission_organiser.behaviours_library import Library
from app.domain.world_model.vocabulary import symbolic_all
from planner import Fact, KnowledgeBase, PlanNet, PlanNetAction


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """The packet for a robot's part in an action, the pre-conditions it requires there, and why this one."""

    tag: str
    requires: tuple[Fact, ...]
    reason: str


def linking_goals(plan_net: PlanNet, action: PlanNetAction) -> tuple[Fact, ...]:
    """The facts that later actions or the plan's goals take from this action, in the order of its effects."""
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
) -> Found | str:
    """The one packet that does the agent's part; in words why there is none, or more than one."""
    goals = _share(plan_net, action, agent)
    wanted = " and ".join(map(str, symbolic_all(goals, knowledge_base))) or "nothing that is linked"
    what = f"{action.id} {action.tag}"
    fitting = {
        entry.tag: found
        for entry in library.achieving(goals)
        if (found := entry.fits(action, agent, goals)) is not None
    }
    if not fitting:
        return f"{what}: no packet in the behaviours library achieves {wanted} from what the action requires"
    able = [tag for tag in fitting if tag in repertoires.get(agent, ())]
    if not able:
        return f"{what}: {agent} has no {' or '.join(fitting)} in its repertoire"
    if len(able) > 1:
        return f"{what}: {' and '.join(able)} all achieve {wanted}; one packet must"
    required = {
        Fact(template.predicate, tuple(fitting[able[0]].get(term, term) for term in template.terms))
        for entry in library.entries
        if entry.tag == able[0]
        for template in entry.requires
    }
    return Found(
        tag=able[0],
        requires=tuple(fact for fact in action.preconditions if fact in required),
        reason=f"{agent} does {able[0]}: it achieves {wanted}",
    )


def _share(plan_net: PlanNet, action: PlanNetAction, agent: str) -> tuple[Fact, ...]:
    """The intended effects a packet of `agent` is sought by: linked, naming no other agent of the action."""
    others = set(action.agents) - {agent}
    mine = [fact for fact in action.intended_effects if not others & set(fact.args)]
    linked = set(linking_goals(plan_net, action))
    return tuple(fact for fact in mine if fact in linked) or tuple(mine)
