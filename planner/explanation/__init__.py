"""Why a plan-net is as it is: what each action is for, why this robot, why this order, what makes the makespan.

`explain` puts it together; `purpose`, `constraining`, `recruiting`, `ordering` and `timing` answer one question each.
"""

from planner.explanation.constraining import ConstraintCost
from planner.explanation.explain import UNCONSTRAINED, ActionExplanation, Explanation, explain
from planner.explanation.timing import Wait

__all__ = ["UNCONSTRAINED", "ActionExplanation", "ConstraintCost", "Explanation", "Wait", "explain"]
