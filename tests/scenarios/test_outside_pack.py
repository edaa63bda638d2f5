"""A domain pack from outside the source tree: its action is planned, and its packet carried out, by the product.

The package is installed as an installer would leave it. It adds an action, a predicate, a packet, a verb, a
world, and in Python a stimulus and a response for a new pattern, and a condition.
"""

import os
import subprocess
import sys
from pathlib import Path

from tests.packages import write_package

ENTRY_POINTS = """\
[macta.packs]
photography = photography
[macta.conditions]
framed = photography.camera:Framed
[macta.stimuli]
off_centre = photography.camera:OffCentre
[macta.responses]
soft = photography.camera:Soft
"""

CAMERA = """\
from cmath import phase
from math import tanh

from robots.conditions.verdict import Condition, Verdict
from robots.perception.percepts import LOCATING, Percepts
from robots.reactive.responses import Response
from robots.reactive.stimuli import Stimulus


class OffCentre(Stimulus, needs=LOCATING):
    target: str

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        return None if at is None else max(-1.0, min(1.0, phase(at)))


class Soft(Response):
    def at(self, s: float) -> float:
        return tanh(2 * s)


class Framed(Condition, needs=LOCATING):
    target: str
    within_rad: float = 0.1

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        if at is None:
            return Verdict(False, f"does not see {self.target}")
        return Verdict(abs(phase(at)) <= self.within_rad, f"has {self.target} {phase(at):+.2f} rad off centre")
"""

MANIFEST = """\
name: photography
version: "1.0"
needs: {store: "1.0"}
"""

KNOWLEDGE_BASE = """\
predicates:
  photographed:
    arguments: {location: location}
    phrase: "{location} was photographed"
    denial: "{location} was not photographed"
actions:
  - identifier: 1
    name: PHOTOGRAPH
    parameters:
      - {name: robot, type: robot}
      - {name: rel, type: relation, values: [near]}
      - {name: ref, type: location}
    agents: [robot]
    preconditions: ["robot_position(robot, rel, ref)", "can(robot, PHOTOGRAPH)"]
    delete: []
    intended_effects: ["photographed(ref)"]
    other_effects: []
    duration: 5
    description: "{robot} photograph {ref}"
"""

LIBRARY = """\
packets:
  - tag: PHOTOGRAPH
    agent: "?robot"
    requires: ["robot_position(?robot, ?rel, ?ref)"]
    achieves: ["photographed(?ref)"]
"""

PACKET = """\
tag: PHOTOGRAPH
about: Turn the camera to a place and take its picture.
arguments: [ref]
places: [ref]
patterns:
  - name: aim
    dof: rotate
    level: task
    stimulus: {sense: off_centre, target: $ref}
    r: {form: soft}
    u: {form: constant, value: 1}
  - name: stand
    dof: translate
    level: task
    stimulus: {sense: always}
    r: {form: constant, value: 0}
    u: {form: constant, value: 1}
after:
  - {sense: framed, target: $ref, within_rad: 0.05}
  - {sense: elapsed, s: 2}
"""

VERBS = """\
verbs:
  - name: photograph
    words: [photograph, snap]
    slots:
      place: {kind: place, role: object}
    goals: ["photographed(?place)"]
"""

WORLD = """\
name: studio
compartments: [{name: floor, x: [0, 8], y: [0, 6]}]
walls:
  - {start: [0, 0], end: [8, 0]}
  - {start: [0, 6], end: [8, 6]}
  - {start: [0, 0], end: [0, 6]}
  - {start: [8, 0], end: [8, 6]}
locations:
  - {name: bay_1, kind: bay, at: [4, 1.5], approach_deg: [180]}
  - {name: bay_2, kind: bay, at: [6.5, 4.5], approach_deg: [180]}
robots:
  - {name: plain, compartment: floor, start: [1, 1, 0], repertoire: [NAVIGATE]}
  - {name: camera, compartment: floor, start: [1, 5, 0], repertoire: [NAVIGATE, PHOTOGRAPH]}
"""


def site(folder: Path) -> Path:
    texts = {
        "__init__.py": "",
        "camera.py": CAMERA,
        "pack.yaml": MANIFEST,
        "knowledge_base.yaml": KNOWLEDGE_BASE,
        "behaviours_library.yaml": LIBRARY,
        "repertoire/photograph.yaml": PACKET,
        "verbs.yaml": VERBS,
        "worlds/studio.yaml": WORLD,
    }
    files = {f"photography/{name}": text for name, text in texts.items()}
    return write_package(folder / "site", "macta_photography", ENTRY_POINTS, files)


def macta(folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    """The command, with the folder's packages installed."""
    script = "import sys; from app.cli import main; sys.argv[0] = 'macta'; main()"
    return subprocess.run(
        [sys.executable, "-c", script, *words],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), os.getcwd()])},
    )


def test_an_installed_packs_action_is_planned_and_carried_out(tmp_path: Path) -> None:
    folder = site(tmp_path)
    checked = macta(folder, "pack", "check", "photography")
    assert checked.returncode == 0, checked.stderr
    assert "photography 1.0: valid; actions PHOTOGRAPH" in checked.stdout
    goal = ("--world", "studio", "--goal", "photograph bay_2", "--flat-out")
    done = macta(folder, "demo", "--pack", "photography", *goal)
    assert done.returncode == 0, done.stdout + done.stderr
    said = " ".join(done.stdout.split())
    assert "PHOTOGRAPH near bay_2" in said
    assert "photographed(bay_2): true by the robots' reports" in said
    assert "Mission completed" in said


def test_a_condition_that_never_holds_keeps_the_goal_from_being_true(tmp_path: Path) -> None:
    folder = site(tmp_path)
    camera = folder / "photography" / "camera.py"
    camera.write_text(CAMERA.replace("abs(phase(at)) <= self.within_rad", "False"))
    packet = folder / "photography" / "repertoire" / "photograph.yaml"
    packet.write_text(
        PACKET.replace("places: [ref]\n", "places: [ref]\ngoal: $ref\nretries: 0\nstalled_s: 3\n")
    )
    goal = ("--world", "studio", "--goal", "photographed(bay_1)", "--flat-out")
    done = macta(folder, "demo", "--pack", "photography", *goal)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "photographed(bay_1): not true by the robots' reports" in " ".join(done.stdout.split())
    assert "off centre" in " ".join(done.stdout.split())
