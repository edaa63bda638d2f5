"""Recovery (what MACTA §4 left open): what to do when a mission does not go as planned.

`rules` and `links` are pure; `planning` has a mission's plan repaired, `revising` puts the new plan in the old one's
place.
"""
