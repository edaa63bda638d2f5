"""Trials of the service: soak (goals and faults drawn at random) and sweep (missions over many seeds).

A soak is a client of the API that also kills and restarts `macta serve`; a sweep plans and organises missions without
a service. Only the command line reads the simulation's ground truth.
"""
