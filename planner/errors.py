"""The planner's errors. What is expected to happen (unsolvable, timed out) is a result, not an error."""


class PlannerError(Exception):
    """The root of everything the planner raises."""


class KnowledgeBaseError(PlannerError, ValueError):
    """Raised when a knowledge base, or a fact put to it, does not fit; names the slot and the choices."""


class InvalidPlan(PlannerError):
    """Raised when an engine's sequence of actions does not reach the goals from the problem's facts."""
