"""Imports foreign planning problems as knowledge bases: from unified-planning's model and from PDDL."""

from planner.interchange.foreign.pddl_reader import import_domain, import_problem
from planner.interchange.foreign.up_reader import ReadProblem, read_up_problem

__all__ = ["ReadProblem", "import_domain", "import_problem", "read_up_problem"]
