"""Missions: their durable workflow from dispatch to end, recovery, and the recording of robots' reports (MACTA §4)."""
