"""Persons who fly between cities. The original's fuel, a number that flights consume, is left out."""

from itertools import permutations
from random import Random

from unified_planning.model import Problem

from benchmarks.domains.model import Form, Model, numbered


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: persons."""
    random = Random(f"zenotravel {size} {seed}")
    model = Model("zenotravel", form)
    model.kinds("person", "plane", "city")
    model.predicates(waits="person city", seated="person plane", parked="plane city", route="city city")
    model.times(flight_time="city city")
    model.action(
        "fly",
        {"plane": "plane", "from_city": "city", "to_city": "city"},
        needs=["parked plane from_city", "route from_city to_city"],
        deletes=["parked plane from_city"],
        adds=["parked plane to_city"],
        lasts="flight_time from_city to_city",
    )
    travel = {"person": "person", "plane": "plane", "city": "city"}
    model.action(
        "board",
        travel,
        needs=["waits person city", "parked plane city"],
        deletes=["waits person city"],
        adds=["seated person plane"],
        lasts=2,
    )
    model.action(
        "leave",
        travel,
        needs=["seated person plane", "parked plane city"],
        deletes=["seated person plane"],
        adds=["waits person city"],
        lasts=2,
    )
    cities = model.objects("city", numbered("city", 3 + size // 2))
    for one, other in permutations(cities, 2):
        model.holds(f"route {one} {other}")
        if one < other:
            lasts = random.randint(4, 12)
            model.takes(f"flight_time {one} {other}", lasts)
            model.takes(f"flight_time {other} {one}", lasts)
    for plane in model.objects("plane", numbered("plane", 1 + size // 3)):
        model.holds(f"parked {plane} {random.choice(cities)}")
    for person in model.objects("person", numbered("person", size)):
        begin, end = random.sample(cities, 2)
        model.holds(f"waits {person} {begin}")
        model.wants(f"waits {person} {end}")
    return model.finished()
