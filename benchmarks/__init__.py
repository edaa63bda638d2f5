"""Figures of how well Macta does; nothing here is asserted."""
