"""PDDL: what other planners read and write."""

from planner.interchange.pddl.domain import domain_text
from planner.interchange.pddl.problem import PddlTask, pddl_of, problem_text
from planner.interchange.pddl.vocabulary import Form, Vocabulary

__all__ = ["Form", "PddlTask", "Vocabulary", "domain_text", "pddl_of", "problem_text"]
