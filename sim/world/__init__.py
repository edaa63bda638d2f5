"""A simulated world in the calling process: scene, bodies, agents, links and clock."""
