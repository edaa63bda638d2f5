"""What becomes of whole missions that something befalls: `python -m benchmarks.recoveries`.

`cases.py` is what befalls whom when, `watch.py` what goes over the radio, `trial.py` one mission with one mishap.
"""
