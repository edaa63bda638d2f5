"""How whole missions cope with mishaps: `python -m benchmarks.recoveries`.

`cases.py` has the mishaps, `watch.py` observes the radio, `trial.py` runs one mission with one mishap.
"""
