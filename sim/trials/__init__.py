"""Experiments on simulated robots without a service: interference, injected faults, scripts given directly."""
