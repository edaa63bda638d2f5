"""A world's layout as clients see it."""

from typing import Any

from robots.world import WorldFile


def layout_of(world: WorldFile) -> dict[str, Any]:
    """The world file, with the places that facts name as `locations`, and locations with several berths as `racks`."""
    written = world.model_dump(mode="json")
    lying = world.initial_places
    racks = [
        location | {"berths": [berth.name for berth in world.places_by_location[location["name"]]]}
        for location in written["locations"]
        if location["capacity"] > 1
    ]
    return written | {
        "locations": [place.model_dump(mode="json") for place in world.places],
        "racks": racks,
        "samples": [sample | {"at": lying[sample["name"]]} for sample in written["samples"]],
    }
