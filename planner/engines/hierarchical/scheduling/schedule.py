"""A decoded choice."""

from planner.engines.hierarchical.scheduling.decoder import IMPOSSIBLE, decode
from planner.engines.hierarchical.scheduling.decoder_state import board_for
from planner.engines.hierarchical.scheduling.model import Choice, Floats, Model


class Schedule:
    """A decoded choice (`choice`: as it was taken): its steps with their agents in an order they can be carried out."""

    def __init__(self, model: Model, choice: Choice, weights: Floats) -> None:
        board = board_for(model)
        board.taken[:] = choice.agent
        cost, length, makespan = decode(model, choice, weights, board)
        self.choice = choice._replace(agent=board.taken)
        self.cost = float(cost)
        self.makespan_s = float(makespan)
        self.steps = board.steps[:length]
        self.team = board.crews[:length]
        self.configurations = board.configuration
        self.missing = int(board.stuck[0])

    @property
    def is_possible(self) -> bool:
        return self.cost < IMPOSSIBLE
