"""Missions: their life as a durable workflow, the monitor's rules, and the book of robots' reports (MACTA §4)."""
