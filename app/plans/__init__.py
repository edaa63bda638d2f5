"""Plans: the planning process, a goal's planning as a durable workflow, and operators' decisions."""
