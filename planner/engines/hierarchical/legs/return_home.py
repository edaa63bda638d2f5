"""The facts once things are where actions brought them and the agents are back where they stood at first."""

from collections.abc import Sequence

from planner.engines.hierarchical.legs.leg import Vocabulary
from planner.engines.hierarchical.legs.setups import FactTable, Setups, Way
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.progression import progressed
from planner.problem.interface import PlanningProblem


class ReturnHome:
    """Sends the agents of one problem back, so that what is planned from later facts begins where each agent is."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem, words: Vocabulary) -> None:
        self._base = knowledge_base
        self._problem = problem
        self._words = words
        self._statics = FactTable(fact for fact in problem.facts if not words.is_fluent(fact))
        self._setups: dict[str, Setups] = {}

    def after(self, facts: frozenset[Fact], actions: Sequence[GroundAction]) -> frozenset[Fact]:
        """The facts after the actions and the ways home, of those agents that find one."""
        state = progressed(facts, actions)
        away = sorted({agent for action in actions for agent in action.agents})
        ways = [way for agent in away if (way := self._way(agent, state))]
        while ways:
            clear = next((way for way in ways if _is_open(way, state)), None)
            if clear is None:
                break
            state = progressed(state, clear.actions)
            ways.remove(clear)
        return state

    def _way(self, agent: str, state: frozenset[Fact]) -> Way | None:
        home = self._words.configuration(agent, self._problem.facts)
        here = self._words.configuration(agent, state)
        if agent not in self._setups:
            self._setups[agent] = Setups(self._base, self._problem, self._words, self._statics, agent)
        return self._setups[agent].way(here, home)


def _is_open(way: Way, state: frozenset[Fact]) -> bool:
    for action in way.actions:
        if not state.issuperset(action.preconditions):
            return False
        state = progressed(state, (action,))
    return True
