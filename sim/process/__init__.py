"""A simulated world in a process of its own: pacing, control channel, snapshots, restart after a death."""
