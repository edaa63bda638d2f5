"""How robots cope with mishaps: `python -m benchmarks.mishaps`.

`undertakings.py` has the robots' scripts, `acts.py` the mishaps, `cases.py` which of them happens when.
"""
