"""Fragments: sequences of actions that reach some goals alone, found by search and reused by lifting."""
