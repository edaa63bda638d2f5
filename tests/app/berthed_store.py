"""The sample store with room for three samples in bay_7 and for two in bay_1 and in bay_2, where sample_2 lies."""

from robots.world import WorldFile, load_world

ROOM = {"bay_1": 2, "bay_2": 2, "bay_7": 3}


def berthed_store(**changes: object) -> WorldFile:
    file = load_world("sample_store").model_dump()
    locations = [
        place | {"capacity": ROOM.get(place["name"], place["capacity"])} for place in file["locations"]
    ]
    return WorldFile.model_validate(file | {"locations": locations} | changes)
