"""Faults on the VDA 5050 link: losses, repetitions, delays, restarts, against a vehicle in the same process."""
