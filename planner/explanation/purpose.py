"""What each action is there for: the goals it serves, and the causal links that lead there."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.knowledge.phrases import phrase
from planner.plan_nets.plan_net import GOAL, INITIAL, CausalLink, PlanNet, PlanNetAction


@dataclass(frozen=True, slots=True, kw_only=True)
class Purpose:
    """The goals an action serves, in the plan-net's order, and a chain of links from it to one of them."""

    goals: tuple[Fact, ...]
    chain: tuple[CausalLink, ...]


def purposes(plan_net: PlanNet, knowledge_base: KnowledgeBase) -> Mapping[str, Purpose]:
    """Each action's purpose, by its id.

    The chain begins with what the action is chosen for (an intended effect, or to make way) and is as short as
    can be from there on.
    """
    going: dict[str, list[CausalLink]] = defaultdict(list)
    for link in plan_net.causal_links:
        if link.producer != INITIAL:
            going[link.producer].append(link)
    place = {goal: number for number, goal in enumerate(plan_net.goals)}
    served: dict[str, frozenset[Fact]] = {}
    chains: dict[str, tuple[CausalLink, ...]] = {GOAL: ()}
    chosen: dict[str, tuple[CausalLink, ...]] = {}
    # NOTE: actions are in the order of a linearisation, so consumers come after producers.
    for action in reversed(plan_net.actions):
        links = sorted(going[action.id])
        served[action.id] = frozenset().union(
            *({link.fact} if link.consumer == GOAL else served[link.consumer] for link in links)
        )
        ways = [(link, *chains[link.consumer]) for link in links]
        chains[action.id] = min(ways, key=len, default=())
        chosen_for = [way for way in ways if _is_chosen_for(way[0].fact, action, knowledge_base)]
        chosen[action.id] = min(chosen_for, key=len, default=chains[action.id])
    return {
        action.id: Purpose(
            goals=tuple(sorted(served[action.id], key=place.__getitem__)), chain=chosen[action.id]
        )
        for action in plan_net.actions
    }


def chain_in_words(
    purpose: Purpose, names: Mapping[str, str], knowledge_base: KnowledgeBase
) -> Iterator[str]:
    """The chain in words, a sentence a link.

    :param names: how actions are called, by id.
    """
    for link in purpose.chain:
        what = phrase(knowledge_base, link.fact)
        end = "a goal" if link.consumer == GOAL else f"needed by {names[link.consumer]}"
        yield f"{names[link.producer]} brings about that {what}: {end}"


def _is_chosen_for(fact: Fact, action: PlanNetAction, knowledge_base: KnowledgeBase) -> bool:
    return fact in action.intended_effects or knowledge_base.predicates[fact.predicate].make_way
