"""PDDL: what other planners read and write."""

from planner.pddl.domain import domain_text, write_domain
from planner.pddl.problem import problem_text, write_problem
from planner.pddl.vocabulary import Form, Vocabulary

__all__ = ["Form", "Vocabulary", "domain_text", "problem_text", "write_domain", "write_problem"]
