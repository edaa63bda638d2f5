"""PyBullet worlds, one process a world: they implement the robots' `Body`. Imports `robots` only."""
