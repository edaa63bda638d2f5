"""The corridor to the kitchen door, and the script of the plan "GetIn Kitchen" (P-SMPA §3, §6). Lengths in metres."""

from importlib import resources

from robots.physical.profile import Architecture
from robots.repertoire import Repertoire, load_repertoire
from robots.wire import BehaviourPacket, BehaviourScript
from robots.world import WorldFile

ROBOT = "nao"
DOOR = "kitchen_door"
LENGTH_M = 14.0
WIDTH_M = 3.0
START_M = 1.0
DOOR_M = LENGTH_M - 0.4
SONAR_MIN_M = 0.25
SONAR_MAX_M = 2.55


def corridor(architecture: Architecture) -> WorldFile:
    """A corridor from west to east with the door at its end."""
    corners = [(0.0, 0.0), (LENGTH_M, 0.0), (LENGTH_M, WIDTH_M), (0.0, WIDTH_M)]
    return WorldFile.model_validate(
        {
            "name": "corridor",
            "title": "Corridor to the kitchen door",
            "compartments": [{"name": "corridor", "x": (0, LENGTH_M), "y": (0, WIDTH_M)}],
            "walls": [
                {"start": a, "end": b} for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
            ],
            "locations": [
                {"name": DOOR, "kind": "door", "at": (DOOR_M, WIDTH_M / 2), "approach_deg": (180,)}
            ],
            "robots": [
                {
                    "name": ROBOT,
                    "compartment": "corridor",
                    "start": (START_M, WIDTH_M / 2, 0),
                    "architecture": architecture,
                    "whiskers": 48,
                    "whisker_range_m": SONAR_MAX_M,
                    "whisker_least_m": SONAR_MIN_M,
                }
            ],
        }
    )


def get_in_kitchen(timeout_s: float) -> BehaviourScript:
    """The plan's "go to door" action as a script."""
    go = BehaviourPacket(
        id="go_to_door",
        tag="GO_TO_DOOR",
        arguments={"door": DOOR},
        expected_start_s=0.0,
        expected_duration_s=30.0,
        timeout_s=timeout_s,
        wait_timeout_s=timeout_s,
    )
    return BehaviourScript(id="get_in_kitchen", mission_id="interference", robot=ROBOT, packets=(go,))


def repertoire() -> Repertoire:
    """The robot's only packet."""
    text = resources.files("sim.trials.interference").joinpath("go_to_door.yaml").read_text(encoding="utf-8")
    return load_repertoire([("go_to_door.yaml", text)])
