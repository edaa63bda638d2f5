"""What becomes of robots that something befalls: `python -m benchmarks.mishaps`.

`undertakings.py` is what they are about, `acts.py` what is done to them, `cases.py` which of it when.
"""
