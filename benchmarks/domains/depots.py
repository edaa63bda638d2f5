"""Crates that hoists stack on pallets and trucks carry between depots."""

from itertools import permutations
from random import Random

from unified_planning.model import Problem

from benchmarks.domains.model import Form, Model, numbered


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: crates."""
    random = Random(f"depots {size} {seed}")
    model = _domain(form)
    places = model.objects("place", numbered("depot", 3 + size // 6))
    pallets = model.objects("pallet", numbered("pallet", len(places)))
    hoists = model.objects("hoist", numbered("hoist", len(places)))
    crates = model.objects("crate", numbered("crate", size))
    for one, other in permutations(places, 2):
        model.holds(f"road {one} {other}")
        if one < other:
            lasts = random.randint(3, 9)
            model.takes(f"road_time {one} {other}", lasts)
            model.takes(f"road_time {other} {one}", lasts)
    for truck in model.objects("truck", numbered("truck", 2)):
        model.holds(f"parked {truck} {random.choice(places)}")
    for place, hoist in zip(places, hoists, strict=True):
        model.holds(f"stands {hoist} {place}", f"idle {hoist}")
    where = dict(zip(pallets, places, strict=True))
    model.holds(*(f"lies {pallet} {place}" for pallet, place in where.items()))
    tops = list(pallets)
    for crate in crates:
        number = random.randrange(len(tops))
        place = where[pallets[number]]
        model.holds(f"on {crate} {tops[number]}", f"lies {crate} {place}")
        tops[number] = crate
    model.holds(*(f"clear {top}" for top in tops))
    tops = list(pallets)
    for crate in random.sample(crates, size):
        number = random.randrange(len(tops))
        model.wants(f"on {crate} {tops[number]}")
        tops[number] = crate
    return model.finished()


def _domain(form: Form) -> Model:
    model = Model("depots", form)
    model.kinds("place", "truck", "hoist", "surface")
    model.kinds("pallet", "crate", of="surface")
    model.predicates(
        parked="truck place",
        road="place place",
        stands="hoist place",
        idle="hoist",
        lifting="hoist crate",
        lies="surface place",
        on="crate surface",
        clear="surface",
        loaded="crate truck",
    )
    model.times(road_time="place place")
    model.action(
        "drive",
        {"truck": "truck", "from_place": "place", "to_place": "place"},
        needs=["parked truck from_place", "road from_place to_place"],
        deletes=["parked truck from_place"],
        adds=["parked truck to_place"],
        lasts="road_time from_place to_place",
    )
    stacking = {"hoist": "hoist", "crate": "crate", "surface": "surface", "place": "place"}
    model.action(
        "lift",
        stacking,
        needs=["stands hoist place", "lies crate place", "idle hoist", "on crate surface", "clear crate"],
        deletes=["lies crate place", "idle hoist", "on crate surface", "clear crate"],
        adds=["lifting hoist crate", "clear surface"],
        lasts=1,
    )
    model.action(
        "put_down",
        stacking,
        needs=["stands hoist place", "lies surface place", "lifting hoist crate", "clear surface"],
        deletes=["lifting hoist crate", "clear surface"],
        adds=["lies crate place", "idle hoist", "on crate surface", "clear crate"],
        lasts=1,
    )
    loading = {"hoist": "hoist", "crate": "crate", "truck": "truck", "place": "place"}
    model.action(
        "load",
        loading,
        needs=["stands hoist place", "parked truck place", "lifting hoist crate"],
        deletes=["lifting hoist crate"],
        adds=["loaded crate truck", "idle hoist"],
        lasts=3,
    )
    model.action(
        "unload",
        loading,
        needs=["stands hoist place", "parked truck place", "loaded crate truck", "idle hoist"],
        deletes=["loaded crate truck", "idle hoist"],
        adds=["lifting hoist crate"],
        lasts=4,
    )
    return model
