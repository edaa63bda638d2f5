"""PDDL: what other planners read and write."""

from planner.interchange.pddl.domain import domain_text, write_domain
from planner.interchange.pddl.problem import PddlTask, problem_text, write_problem
from planner.interchange.pddl.vocabulary import Form, Vocabulary

__all__ = ["Form", "PddlTask", "Vocabulary", "domain_text", "problem_text", "write_domain", "write_problem"]
