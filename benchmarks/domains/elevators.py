"""Passengers of a building with slow lifts within its halves and a fast one between every other floor."""

from collections.abc import Sequence
from itertools import pairwise, permutations
from random import Random

from unified_planning.model import Problem

from benchmarks.domains.model import Form, Model, numbered

FLOORS = 9
HALF = FLOORS // 2
SLOW_S = 6
FAST_S = 2
STOP_S = 3
"""To start and stop; on top of that, seconds for each floor by a slow and by a fast lift."""


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: passengers."""
    random = Random(f"elevators {size} {seed}")
    model = _domain(form)
    floors = model.objects("floor", numbered("floor", FLOORS))
    slow = model.objects("slow", ["lower", "upper"])
    fast = model.objects("fast", ["express"])
    counts = model.objects("tally", [f"persons{number}" for number in range(4)])
    model.holds(*(f"one_more {before} {after}" for before, after in pairwise(counts)))
    for one, other in permutations(range(FLOORS), 2):
        for kind, seconds in (("slow", SLOW_S), ("fast", FAST_S)):
            model.takes(f"{kind}_time {floors[one]} {floors[other]}", STOP_S + seconds * abs(one - other))
    served: dict[str, Sequence[str]] = {
        slow[0]: floors[: HALF + 1],
        slow[1]: floors[HALF:],
        fast[0]: floors[::2],
    }
    for lift, stops in served.items():
        model.holds(f"stands {lift} {random.choice(stops)}", f"riders {lift} {counts[0]}")
        model.holds(*(f"shaft {lift} {one} {other}" for one, other in permutations(stops, 2)))
        steps = pairwise(counts[: 3 if lift in slow else 4])
        model.holds(*(f"room {lift} {before} {after}" for before, after in steps))
    for passenger in model.objects("passenger", numbered("passenger", size)):
        begin, end = random.sample(floors, 2)
        model.holds(f"waits {passenger} {begin}")
        model.wants(f"waits {passenger} {end}")
    return model.finished()


def _domain(form: Form) -> Model:
    model = Model("elevators", form)
    model.kinds("passenger", "floor", "lift", "tally")
    model.kinds("slow", "fast", of="lift")
    model.predicates(
        waits="passenger floor",
        aboard="passenger lift",
        stands="lift floor",
        shaft="lift floor floor",
        riders="lift tally",
        one_more="tally tally",
        room="lift tally tally",
    )
    model.times(slow_time="floor floor", fast_time="floor floor")
    for kind in ("slow", "fast"):
        model.action(
            f"ride_{kind}",
            {"lift": kind, "from_floor": "floor", "to_floor": "floor"},
            needs=["stands lift from_floor", "shaft lift from_floor to_floor"],
            deletes=["stands lift from_floor"],
            adds=["stands lift to_floor"],
            lasts=f"{kind}_time from_floor to_floor",
        )
    step = {
        "passenger": "passenger",
        "lift": "lift",
        "floor": "floor",
        "present": "tally",
        "changed": "tally",
    }
    model.action(
        "board",
        step,
        needs=[
            "waits passenger floor",
            "stands lift floor",
            "riders lift present",
            "room lift present changed",
        ],
        deletes=["waits passenger floor", "riders lift present"],
        adds=["aboard passenger lift", "riders lift changed"],
        lasts=1,
    )
    model.action(
        "leave",
        step,
        needs=[
            "aboard passenger lift",
            "stands lift floor",
            "riders lift present",
            "one_more changed present",
        ],
        deletes=["aboard passenger lift", "riders lift present"],
        adds=["waits passenger floor", "riders lift changed"],
        lasts=1,
    )
    return model
