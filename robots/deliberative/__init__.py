"""The deliberative level (SRA): beliefs, commitment rules and plans on board, in a dialect of AF-APL.

A commitment may adopt or retract a belief, activate packets of the repertoire, say something, or suspend, retry or give
up the packet under way. It never reorders a script nor touches what its packets wait for.
"""
