"""Plan-nets (MACTA §4): extraction from a sequence, schedule, synchronisation of robots, validation."""
