"""The service: API, database, mission organiser and monitor, agent models, command line.

Imports `planner` and `robots`; only `composition.py` and `cli` wire `sim`, `web` and concrete links together.
"""
