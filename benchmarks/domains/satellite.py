"""Satellites that turn to directions and take images with calibrated instruments, one of which has power at a time."""

from itertools import permutations
from random import Random

from unified_planning.model import Problem

from benchmarks.domains.model import Form, Model, numbered


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: images."""
    random = Random(f"satellite {size} {seed}")
    model = _domain(form)
    directions = model.objects("direction", numbered("direction", size + 3))
    satellites = model.objects("satellite", numbered("satellite", 1 + size // 3))
    modes = model.objects("mode", numbered("mode", 2 + size // 6))
    for one, other in permutations(directions, 2):
        model.holds(f"apart {one} {other}")
        if one < other:
            lasts = random.randint(2, 9)
            model.takes(f"slew_time {one} {other}", lasts)
            model.takes(f"slew_time {other} {one}", lasts)
    aboard = []
    for satellite in satellites:
        model.holds(f"points {satellite} {random.choice(directions)}", f"power_free {satellite}")
        for _ in range(random.randint(1, 2)):
            (instrument,) = model.objects("instrument", [f"instrument{len(aboard) + 1}"])
            aboard.append(instrument)
            model.holds(
                f"aboard {instrument} {satellite}", f"reference {instrument} {random.choice(directions)}"
            )
            model.holds(f"offers {instrument} {random.choice(modes)}")
    model.holds(*(f"offers {random.choice(aboard)} {mode}" for mode in modes))
    for direction in random.sample(directions, size):
        model.wants(f"image {direction} {random.choice(modes)}")
    return model.finished()


def _domain(form: Form) -> Model:
    model = Model("satellite", form)
    model.kinds("satellite", "instrument", "mode", "direction")
    model.predicates(
        points="satellite direction",
        apart="direction direction",
        aboard="instrument satellite",
        offers="instrument mode",
        reference="instrument direction",
        power_free="satellite",
        powered="instrument",
        calibrated="instrument",
        image="direction mode",
    )
    model.times(slew_time="direction direction")
    device = {"satellite": "satellite", "instrument": "instrument"}
    model.action(
        "turn",
        {"satellite": "satellite", "from_direction": "direction", "to_direction": "direction"},
        needs=["points satellite from_direction", "apart from_direction to_direction"],
        deletes=["points satellite from_direction"],
        adds=["points satellite to_direction"],
        lasts="slew_time from_direction to_direction",
    )
    model.action(
        "switch_on",
        device,
        needs=["aboard instrument satellite", "power_free satellite"],
        deletes=["power_free satellite", "calibrated instrument"],
        adds=["powered instrument"],
        lasts=2,
    )
    model.action(
        "switch_off",
        device,
        needs=["aboard instrument satellite", "powered instrument"],
        deletes=["powered instrument"],
        adds=["power_free satellite"],
        lasts=1,
    )
    model.action(
        "calibrate",
        {**device, "direction": "direction"},
        needs=[
            "aboard instrument satellite",
            "powered instrument",
            "reference instrument direction",
            "points satellite direction",
        ],
        adds=["calibrated instrument"],
        lasts=5,
    )
    model.action(
        "take_image",
        {**device, "direction": "direction", "mode": "mode"},
        needs=[
            "aboard instrument satellite",
            "powered instrument",
            "calibrated instrument",
            "offers instrument mode",
            "points satellite direction",
        ],
        adds=["image direction mode"],
        lasts=7,
    )
    return model
