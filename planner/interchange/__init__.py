"""Exchange with other planners: PDDL out, PDDL and unified-planning in, unified-planning's validator."""
