"""A decoded choice."""

from planner.engines.hierarchical.scheduling.decoder import IMPOSSIBLE, decode
from planner.engines.hierarchical.scheduling.decoder_state import decoder_state_for
from planner.engines.hierarchical.scheduling.model import Choice, Floats, Model


class Schedule:
    """A decoded choice (`choice`: as it was taken): its steps with their agents in an order they can be carried out."""

    def __init__(self, model: Model, choice: Choice, weights: Floats) -> None:
        state = decoder_state_for(model)
        state.taken[:] = choice.agent
        cost, length, makespan = decode(model, choice, weights, state)
        self.choice = choice._replace(agent=state.taken)
        self.cost = float(cost)
        self.makespan_s = float(makespan)
        self.steps = state.steps[:length]
        self.team = state.step_agents[:length]
        self.configurations = state.configuration
        self.missing = int(state.missing_fact[0])

    @property
    def is_possible(self) -> bool:
        return self.cost < IMPOSSIBLE
