"""Drivers who walk along paths to trucks and deliver packages by road."""

from random import Random

from unified_planning.model import Problem

from benchmarks.domains.graph import connected
from benchmarks.domains.model import Form, Model, numbered


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: packages."""
    random = Random(f"driverlog {size} {seed}")
    model = _domain(form)
    places = model.objects("place", numbered("place", 3 + size // 2))
    drivers = model.objects("driver", numbered("driver", 1 + size // 3))
    trucks = model.objects("truck", numbered("truck", 1 + size // 3))
    for way, seconds in (("road", (2, 6)), ("path", (4, 15))):
        for one, other in connected(places, len(places), random):
            lasts = random.randint(*seconds)
            for begin, end in ((one, other), (other, one)):
                model.holds(f"{way} {begin} {end}")
                model.takes(f"{way}_time {begin} {end}", lasts)
    for truck in trucks:
        model.holds(f"parked {truck} {random.choice(places)}", f"vacant {truck}")
    model.holds(*(f"on_foot {driver} {random.choice(places)}" for driver in drivers))
    model.wants(f"on_foot {drivers[0]} {random.choice(places)}")
    for package in model.objects("package", numbered("package", size)):
        begin, end = random.sample(places, 2)
        model.holds(f"stored {package} {begin}")
        model.wants(f"stored {package} {end}")
    return model.finished()


def _domain(form: Form) -> Model:
    model = Model("driverlog", form)
    model.kinds("driver", "truck", "package", "place")
    model.predicates(
        on_foot="driver place",
        drives="driver truck",
        vacant="truck",
        parked="truck place",
        stored="package place",
        loaded="package truck",
        road="place place",
        path="place place",
    )
    model.times(road_time="place place", path_time="place place")
    model.action(
        "walk",
        {"driver": "driver", "from_place": "place", "to_place": "place"},
        needs=["on_foot driver from_place", "path from_place to_place"],
        deletes=["on_foot driver from_place"],
        adds=["on_foot driver to_place"],
        lasts="path_time from_place to_place",
    )
    model.action(
        "drive",
        {"driver": "driver", "truck": "truck", "from_place": "place", "to_place": "place"},
        needs=["drives driver truck", "parked truck from_place", "road from_place to_place"],
        deletes=["parked truck from_place"],
        adds=["parked truck to_place"],
        lasts="road_time from_place to_place",
    )
    seat = {"driver": "driver", "truck": "truck", "place": "place"}
    model.action(
        "get_in",
        seat,
        needs=["on_foot driver place", "parked truck place", "vacant truck"],
        deletes=["on_foot driver place", "vacant truck"],
        adds=["drives driver truck"],
        lasts=1,
    )
    model.action(
        "get_out",
        seat,
        needs=["drives driver truck", "parked truck place"],
        deletes=["drives driver truck"],
        adds=["on_foot driver place", "vacant truck"],
        lasts=1,
    )
    cargo = {"package": "package", "truck": "truck", "place": "place"}
    model.action(
        "load",
        cargo,
        needs=["stored package place", "parked truck place"],
        deletes=["stored package place"],
        adds=["loaded package truck"],
        lasts=2,
    )
    model.action(
        "unload",
        cargo,
        needs=["loaded package truck", "parked truck place"],
        deletes=["loaded package truck"],
        adds=["stored package place"],
        lasts=2,
    )
    return model
