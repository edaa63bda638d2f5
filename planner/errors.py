"""The planner's errors. What is expected to happen (unsolvable, timed out) is a result, not an error."""


class PlannerError(Exception):
    """The root of everything the planner raises."""


class KnowledgeBaseError(PlannerError, ValueError):
    """Raised when a knowledge base, or a fact put to it, does not fit; names the slot and the choices."""


class Unsupported(PlannerError, ValueError):
    """Raised when a problem from elsewhere has a feature that plan-net actions lack; names it and a workaround."""


class InvalidPlan(PlannerError):
    """Raised when an engine's sequence of actions does not reach the goals from the problem's facts."""


class OrderNotKept(InvalidPlan):
    """Raised when a sequence cannot be put into an order in which goals come true as they are to; names them."""


class CyclicOrder(PlannerError):
    """Raised when orderings contradict each other: `nodes` are on cycles or behind them."""

    def __init__(self, nodes: list[int]) -> None:
        super().__init__(f"the orderings are cyclic among {nodes}")
        self.nodes = nodes


class UnknownEngine(PlannerError, ValueError):
    """Raised when an engine is asked for by a name that none has; names the choices."""


class UnknownAction(PlannerError, ValueError):
    """Raised when a mission's progress names an action that its plan-net lacks; names those it has."""


class OutOfTime(PlannerError):
    """Raised when the time limit is reached while a search is being prepared."""
