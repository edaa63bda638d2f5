"""Two robots that meet head-on in an aisle, by its width: `python -m benchmarks.meetings [--seeds 4] [--rules]`.

Each is to drive to where the other comes from. Robots are 0.44 m across and keep 0.15 m from each other. With --rules
the aisle leads from one room to another, and the robots' software is compared with the rules `give_way`, where they
hear each other and where they do not, and with an empty file of that name.
"""

import argparse
from collections.abc import Mapping, Sequence
from statistics import median

from benchmarks.errands import packet
from robots.wire import BehaviourScript, ScriptState
from robots.world import WorldFile
from robots.world.rule_files import shipped_rules
from sim.trials.script_runner import ScriptRunner

LONG_M = 7.0
WIDTHS_M = (2.0, 1.6, 1.3, 1.0)
TIMEOUT_S = 60.0


def aisle(width_m: float) -> WorldFile:
    """Walled all round, a beacon at each end; fred starts in the west, ginger in the east."""
    corners = [(0, 0), (LONG_M, 0), (LONG_M, width_m), (0, width_m)]
    walls = [
        {"start": one, "end": other} for one, other in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    middle_m = width_m / 2
    return WorldFile.model_validate(
        {
            "name": "aisle",
            "compartments": [{"name": "aisle", "x": (0, LONG_M), "y": (0, width_m)}],
            "walls": walls,
            "locations": [
                {"name": "west_end", "kind": "place", "at": (0.1, middle_m), "approach_deg": (0,)},
                {"name": "east_end", "kind": "place", "at": (LONG_M - 0.1, middle_m), "approach_deg": (180,)},
            ],
            "robots": [
                {"name": "fred", "compartment": "aisle", "start": (1, middle_m, 0)},
                {"name": "ginger", "compartment": "aisle", "start": (LONG_M - 1, middle_m, 180)},
            ],
            "samples": [],
        }
    )


ROOM_M = 3.0
BETWEEN_M = 3.5


def passage(width_m: float, rules: str | None, *, hear: bool) -> WorldFile:
    """Two rooms and an aisle between them; fred starts in the western room, ginger in the eastern one.

    :param rules: of both robots, called `give_way`; None for none. :param hear: whether the robots hear each other.
    """
    east_m = ROOM_M + BETWEEN_M
    length_m = east_m + ROOM_M
    low_m = (ROOM_M - width_m) / 2
    high_m = low_m + width_m
    outline = [
        (0, 0),
        (ROOM_M, 0),
        (ROOM_M, low_m),
        (east_m, low_m),
        (east_m, 0),
        (length_m, 0),
        (length_m, ROOM_M),
        (east_m, ROOM_M),
        (east_m, high_m),
        (ROOM_M, high_m),
        (ROOM_M, ROOM_M),
        (0, ROOM_M),
    ]
    places = {
        "west_north": ((ROOM_M / 2, ROOM_M - 0.1), 270),
        "west_south": ((ROOM_M / 2, 0.1), 90),
        "east_north": ((east_m + ROOM_M / 2, ROOM_M - 0.1), 270),
        "east_south": ((east_m + ROOM_M / 2, 0.1), 90),
    }
    own = {} if rules is None else {"give_way": rules}
    starts = {"fred": (ROOM_M - 0.6, ROOM_M / 2, 0), "ginger": (east_m + 0.6, ROOM_M / 2, 180)}
    return WorldFile.model_validate(
        {
            "name": "passage",
            "compartments": [{"name": "rooms", "x": (0, length_m), "y": (0, ROOM_M)}],
            "walls": [
                {"start": one, "end": other}
                for one, other in zip(outline, outline[1:] + outline[:1], strict=True)
            ],
            "locations": [
                {"name": name, "kind": "place", "at": at, "approach_deg": (axis,)}
                for name, (at, axis) in places.items()
            ],
            "robots": [
                {"name": name, "compartment": "rooms", "start": start, "rules": own}
                for name, start in starts.items()
            ],
            "samples": [],
            **({"peer_link": {}} if hear else {}),
        }
    )


def variants() -> Mapping[str, tuple[str | None, bool]]:
    """The rules of both robots, and whether they hear each other."""
    rules = shipped_rules()["give_way"].read_text(encoding="utf-8")
    return {
        "software": (None, True),
        "rules that speak": (rules, True),
        "rules without speech": (rules, False),
        "empty rules": ("AGENT give_way;", True),
    }


def drive(robot: str, start: str, end: str, timeout_s: float) -> BehaviourScript:
    go = packet(1, "NAVIGATE", robot=robot, rel1="near", ref1=start, rel2="near", ref2=end)
    limited = go.model_copy(update={"timeout_s": timeout_s})
    return BehaviourScript(id=robot, mission_id="meeting", robot=robot, packets=(limited,))


IN_AISLE = {"fred": ("west_end", "east_end"), "ginger": ("east_end", "west_end")}
THROUGH = {"fred": ("west_north", "east_south"), "ginger": ("east_north", "west_south")}


def meet(
    world: WorldFile, ways: Mapping[str, tuple[str, str]], seed: int, timeout_s: float
) -> tuple[bool, float, Sequence[str]]:
    """Whether both arrived, the seconds until both had ended, and what they reported if not."""
    runner = ScriptRunner(world, seed=seed, jitter_m=0.2)
    scripts = [drive(robot, start, end, timeout_s) for robot, (start, end) in ways.items()]
    try:
        over = runner.run(scripts, timeout_s=4 * timeout_s)
        failed = [one.detail for one in runner.ended.values() if one.state is not ScriptState.FINISHED]
        return over and not failed, runner.simulation.clock.now_s(), failed if over else ["no end"]
    finally:
        runner.simulation.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--rules", action="store_true", help="compare the rules `give_way` with the software")
    parser.add_argument("--widths", type=float, nargs="+", default=WIDTHS_M)
    options = parser.parse_args()
    for width_m in options.widths:
        if not options.rules:
            show(f"{width_m:.1f} m wide", aisle(width_m), IN_AISLE, options.seeds)
            continue
        for name, (rules, hear) in variants().items():
            show(f"{width_m:.1f} m wide, {name}", passage(width_m, rules, hear=hear), THROUGH, options.seeds)


def show(title: str, world: WorldFile, ways: Mapping[str, tuple[str, str]], seeds: int) -> None:
    met = [meet(world, ways, seed, TIMEOUT_S) for seed in range(seeds)]
    took_s = [each_s for arrived, each_s, _ in met if arrived]
    longest_s = max(each_s for _, each_s, _ in met)
    passing = f", in {median(took_s):.0f} s (median)" if took_s else ""
    print(
        f"{title}: {len(took_s)}/{len(met)} passed{passing}, all ended within {longest_s:.0f} s", flush=True
    )
    for words in [words for _, _, said in met for words in said]:
        print(f"    {words}")


if __name__ == "__main__":
    main()
