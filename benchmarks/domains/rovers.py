"""Rovers that analyse soil and rock, take images and send all of it to a lander, one message at a time."""

from random import Random

from unified_planning.model import Problem

from benchmarks.domains.graph import connected
from benchmarks.domains.model import Form, Model, numbered

MODES = ("colour", "infrared")


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: things to be sent."""
    random = Random(f"rovers {size} {seed}")
    model = _domain(form)
    points = model.objects("point", numbered("point", size + 3))
    rovers = model.objects("rover", numbered("rover", 1 + size // 3))
    targets = model.objects("target", numbered("target", 2))
    modes = model.objects("mode", MODES)
    model.objects("lander", ["base"])
    model.holds("listening base")
    model.holds(*(f"in_reach {point}" for point in random.sample(points, 1 + len(points) // 4)))
    for one, other in connected(points, size, random):
        lasts = random.randint(3, 8)
        for begin, end in ((one, other), (other, one)):
            model.holds(f"path {begin} {end}")
            model.takes(f"path_time {begin} {end}", lasts)
    for number, rover in enumerate(rovers):
        (camera,) = model.objects("camera", [f"camera{number + 1}"])
        model.holds(f"at {rover} {random.choice(points)}", f"empty {rover}", f"aboard {camera} {rover}")
        # The first has all, so that there is a plan.
        model.holds(*(f"{kit} {rover}" for kit in ("digs", "drills") if number == 0 or random.random() < 0.6))
        model.holds(*(f"offers {camera} {mode}" for mode in modes if number == 0 or random.random() < 0.6))
        model.holds(f"reference {camera} {random.choice(targets)}")
    for target in targets:
        model.holds(*(f"in_sight {target} {point}" for point in random.sample(points, 2)))
    images = [f"image_sent {target} {mode}" for target in targets for mode in modes]
    soils = [f"soil_sent {point}" for point in points]
    rocks = [f"rock_sent {point}" for point in points]
    for number in range(size):
        wanted = (soils, rocks, images)[number % 3] or soils
        goal = wanted.pop(random.randrange(len(wanted)))
        model.wants(goal)
        kind, *words = goal.split()
        if kind != "image_sent":
            model.holds(f"{kind.removesuffix('_sent')}_at {words[0]}")
    return model.finished()


def _domain(form: Form) -> Model:
    model = Model("rovers", form)
    model.kinds("rover", "point", "camera", "mode", "target", "lander")
    model.predicates(
        at="rover point",
        path="point point",
        in_reach="point",
        in_sight="target point",
        soil_at="point",
        rock_at="point",
        digs="rover",
        drills="rover",
        empty="rover",
        full="rover",
        has_soil="rover point",
        has_rock="rover point",
        has_image="rover target mode",
        aboard="camera rover",
        offers="camera mode",
        reference="camera target",
        calibrated="camera rover",
        listening="lander",
        soil_sent="point",
        rock_sent="point",
        image_sent="target mode",
    )
    model.times(path_time="point point")
    model.action(
        "navigate",
        {"rover": "rover", "from_point": "point", "to_point": "point"},
        needs=["at rover from_point", "path from_point to_point"],
        deletes=["at rover from_point"],
        adds=["at rover to_point"],
        lasts="path_time from_point to_point",
    )
    for kind, kit, lasts in (("soil", "digs", 6), ("rock", "drills", 8)):
        model.action(
            f"sample_{kind}",
            {"rover": "rover", "point": "point"},
            needs=["at rover point", f"{kind}_at point", f"{kit} rover", "empty rover"],
            deletes=["empty rover", f"{kind}_at point"],
            adds=["full rover", f"has_{kind} rover point"],
            lasts=lasts,
        )
        _send(model, kind, {"subject": "point"}, 5)
    model.action(
        "drop",
        {"rover": "rover"},
        needs=["full rover"],
        deletes=["full rover"],
        adds=["empty rover"],
        lasts=1,
    )
    model.action(
        "calibrate",
        {"rover": "rover", "camera": "camera", "target": "target", "point": "point"},
        needs=["at rover point", "aboard camera rover", "reference camera target", "in_sight target point"],
        adds=["calibrated camera rover"],
        lasts=4,
    )
    model.action(
        "take_image",
        {"rover": "rover", "camera": "camera", "target": "target", "mode": "mode", "point": "point"},
        needs=[
            "at rover point",
            "aboard camera rover",
            "offers camera mode",
            "in_sight target point",
            "calibrated camera rover",
        ],
        deletes=["calibrated camera rover"],
        adds=["has_image rover target mode"],
        lasts=3,
    )
    _send(model, "image", {"subject": "target", "mode": "mode"}, 7)
    return model


def _send(model: Model, kind: str, subject: dict[str, str], lasts: int) -> None:
    words = " ".join(subject)
    model.action(
        f"send_{kind}",
        {"rover": "rover", "lander": "lander", **subject, "point": "point"},
        needs=["at rover point", "in_reach point", f"has_{kind} rover {words}", "listening lander"],
        deletes=["listening lander"],
        adds=["listening lander", f"{kind}_sent {words}"],
        lasts=lasts,
    )
