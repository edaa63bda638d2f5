"""Why a plan-net is as it is: what each action is for, why this robot, why this order, what makes the makespan.

`explain` puts it together; `purpose`, `recruiting`, `ordering` and `timing` each answer one of the questions.
"""

from planner.explanation.explain import ActionExplanation, Explanation, explain
from planner.explanation.timing import Wait

__all__ = ["ActionExplanation", "Explanation", "Wait", "explain"]
