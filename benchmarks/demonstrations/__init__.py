"""The demonstrations of the Social Robot Architecture, as worlds that ship, played without a service."""
