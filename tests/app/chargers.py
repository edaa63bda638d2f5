"""Worlds with chargers that robots share, in place of homes."""

from robots.world import WorldFile


def with_shared_chargers(world: WorldFile) -> WorldFile:
    """The world without homes: the first of each area is a charger for all robots of the area."""
    data = world.model_dump(mode="json")
    homes = {robot["home"]: (robot["compartment"], robot["aisle"]) for robot in data["robots"]}
    first = {area: home for home, area in reversed(homes.items())}
    data["locations"] = [
        place | {"kind": "charger"} if place["name"] in homes else place
        for place in data["locations"]
        if place["name"] not in homes or place["name"] in first.values()
    ]
    data["robots"] = [robot | {"home": None} for robot in data["robots"]]
    return WorldFile.model_validate(data)
