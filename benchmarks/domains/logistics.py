"""Packages to other cities: a truck in each city, planes between their airports."""

from itertools import permutations
from random import Random

from unified_planning.model import Problem

from benchmarks.domains.model import Form, Model, numbered


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: packages."""
    random = Random(f"logistics {size} {seed}")
    model = Model("logistics", form)
    model.kinds("vehicle", "place", "package")
    model.kinds("truck", "plane", of="vehicle")
    model.predicates(
        parked="vehicle place",
        stored="package place",
        loaded="package vehicle",
        road="place place",
        air="place place",
    )
    model.times(road_time="place place", air_time="place place")
    for name, kind, way in (("drive", "truck", "road"), ("fly", "plane", "air")):
        model.action(
            name,
            {"vehicle": kind, "from_place": "place", "to_place": "place"},
            needs=["parked vehicle from_place", f"{way} from_place to_place"],
            deletes=["parked vehicle from_place"],
            adds=["parked vehicle to_place"],
            lasts=f"{way}_time from_place to_place",
        )
    cargo = {"package": "package", "vehicle": "vehicle", "place": "place"}
    model.action(
        "load",
        cargo,
        needs=["stored package place", "parked vehicle place"],
        deletes=["stored package place"],
        adds=["loaded package vehicle"],
        lasts=1,
    )
    model.action(
        "unload",
        cargo,
        needs=["loaded package vehicle", "parked vehicle place"],
        deletes=["loaded package vehicle"],
        adds=["stored package place"],
        lasts=1,
    )
    cities = [numbered(f"city{number + 1}place", 3) for number in range(2 + size // 4)]
    for places in cities:
        model.objects("place", places)
    trucks = model.objects("truck", numbered("truck", len(cities)))
    planes = model.objects("plane", numbered("plane", 1 + size // 6))
    airports = [places[0] for places in cities]
    for truck, places in zip(trucks, cities, strict=True):
        model.holds(f"parked {truck} {random.choice(places)}")
        _join(model, "road", places, (2, 5), random)
    _join(model, "air", airports, (6, 12), random)
    model.holds(*(f"parked {plane} {random.choice(airports)}" for plane in planes))
    everywhere = [place for places in cities for place in places]
    for package in model.objects("package", numbered("package", size)):
        begin, end = random.sample(everywhere, 2)
        model.holds(f"stored {package} {begin}")
        model.wants(f"stored {package} {end}")
    return model.finished()


def _join(model: Model, way: str, places: list[str], seconds: tuple[int, int], random: Random) -> None:
    """A way between any two of the places, as long in both directions."""
    for one, other in permutations(places, 2):
        model.holds(f"{way} {one} {other}")
        if one < other:
            lasts = random.randint(*seconds)
            model.takes(f"{way}_time {one} {other}", lasts)
            model.takes(f"{way}_time {other} {one}", lasts)
