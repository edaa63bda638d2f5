"""A compiled problem as PDDL text, by unified-planning's writer."""

import re
from typing import Any

from planner.interchange.compilation import UNIFIED_PLANNING_LOCK, CompiledProblem

_OBJECTS = re.compile(r"^(\s+)((?:c_\S+ )+)- ", re.MULTILINE)


def write_pddl(compiled: CompiledProblem) -> tuple[str, str]:
    """Domain and problem, the same text for the same problem in every process."""
    from unified_planning.io import PDDLWriter

    with UNIFIED_PLANNING_LOCK:
        writer = PDDLWriter(_sparse(compiled.up_problem))
        domain = writer.get_domain()
        problem = writer.get_problem()
    # The writer keeps constants in sets, whose order differs between processes.
    return _OBJECTS.sub(lambda m: f"{m[1]}{' '.join(sorted(m[2].split()))} - ", domain), problem


def _sparse(up_problem: Any) -> Any:
    """A view of the problem whose initial values are only those set: all others are false, or never read.

    The writer asks for every ground fluent's value, a million at 64 robots, to leave out the false ones.
    """
    parent = type(up_problem)
    sparse = type("SparseProblem", (parent,), {"initial_values": parent.explicit_initial_values})
    view: Any = object.__new__(sparse)
    view.__dict__.update(up_problem.__dict__)
    return view
