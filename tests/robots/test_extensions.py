"""Conditions, stimuli, responses and avoidance methods that installed packages add to what data may name."""

from itertools import count
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from robots.errors import RepertoireError
from robots.reactive.avoidance import Velocity, Wanted
from robots.reactive.responses import AnyResponse, Linear, Response
from robots.repertoire import Repertoire, load_repertoire
from tests.packages import installed, write_package
from tests.robots.sensed import percepts

NUMBERS = count(1)

PYTHON = """\
from math import tanh

from robots.conditions.verdict import Condition, Verdict
from robots.perception.percepts import Percepts
from robots.reactive.avoidance import Avoidance, AvoidanceMethod, Velocity, Wanted
from robots.reactive.responses import Response
from robots.reactive.stimuli import Stimulus


class Rested{n}(Condition):
    s: float

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.progress.elapsed_s >= self.s, "rests")


class Fatigue{n}(Stimulus):
    full_s: float = 10.0

    def read(self, percepts: Percepts) -> float:
        return min(1.0, percepts.progress.elapsed_s / self.full_s)


class Soft{n}(Response):
    def at(self, s: float) -> float:
        return tanh(s)


class HalfPace{n}(AvoidanceMethod):
    share: float = 0.5

    def begin(self) -> Avoidance:
        return self

    def steer(self, wanted: Wanted, percepts: Percepts) -> Velocity:
        return Velocity(self.share * wanted.pace_m_s, wanted.direction_rad)
"""
ENTRY_POINTS = """\
[macta.conditions]
rested{n} = {module}:Rested{n}
[macta.stimuli]
fatigue{n} = {module}:Fatigue{n}
[macta.responses]
soft{n} = {module}:Soft{n}
[macta.avoidances]
half_pace{n} = {module}:HalfPace{n}
"""
PACKET = """\
tag: REST
about: Slows down.
arguments: [ref]
avoid: {{by: half_pace{n}, share: 0.4}}
patterns:
  - name: slow_down
    dof: translate
    level: self
    stimulus: {{sense: fatigue{n}, full_s: 5}}
    r: {{form: soft{n}}}
    u: {{form: constant, value: 1}}
after:
  - {{sense: not, of: {{sense: not, of: {{sense: rested{n}, s: 3}}}}}}
"""


class Package:
    """An installed package, with names of its own: Python keeps the classes of others."""

    def __init__(self, folder: Path, entry_points: str = ENTRY_POINTS, python: str = PYTHON) -> None:
        self.n = next(NUMBERS)
        self.module = f"tired_rovers_{self.n}"
        names = {"n": self.n, "module": self.module}
        texts = {f"{self.module}.py": python.replace("{n}", str(self.n))}
        write_package(folder, self.module, entry_points.format(**names), texts)
        self.folder = folder

    def repertoire(self, right: str = "", wrong: str = "") -> Repertoire:
        text = PACKET.replace(right, wrong) if right else PACKET
        with installed(self.folder):
            return load_repertoire([("rest.yaml", text.format(n=self.n))])


def test_data_name_what_an_installed_package_brings(tmp_path: Path) -> None:
    package = Package(tmp_path)
    repertoire = package.repertoire()
    with installed(tmp_path):
        bound = repertoire.specs["REST"].bind({"ref": "bay"})
    parts = (bound.patterns[0].stimulus, bound.patterns[0].r, bound.avoid)
    assert [type(part).__module__ for part in parts] == [package.module] * 3
    assert bound.patterns[0].r.at(1.0) == pytest.approx(0.7616, abs=1e-4)
    assert bound.avoid is not None
    wanted = Wanted(direction_rad=0.1, pace_m_s=1.0, limits=Velocity(1.0, 1.0))
    assert bound.avoid.begin().steer(wanted, percepts()) == (0.4, 0.1)


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("full_s: 5", "full_s: long", ["line 9, patterns.0.stimulus", "full_s", "valid number"]),
        ("full_s: 5", "fall_s: 5", ["line 9, patterns.0.stimulus", "fall_s"]),
        ("sense: fatigue", "sense: tedium", ["line 9", "unknown sense 'tedium", "fatigue", "choices: ahead"]),
        ("sense: rested", "sense: woken", ["line 13, after.0", "unknown sense 'woken", "rested", "holding"]),
        ("form: soft", "form: hard", ["line 10, patterns.0.r", "unknown form 'hard", "soft", "linear"]),
        ("by: half", "by: no", ["line 4, avoid", "unknown by 'no", "half_pace", "vfh_plus", "patterns"]),
        ("share: 0.4", "part: 0.4", ["line 4, avoid", "part"]),
    ],
)
def test_what_does_not_fit_is_refused_with_line_slot_and_choices(
    tmp_path: Path, right: str, wrong: str, words: list[str]
) -> None:
    with pytest.raises(RepertoireError) as refused:
        Package(tmp_path).repertoire(right, wrong)
    assert [word for word in words if word not in str(refused.value)] == [], str(refused.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("rested{n} = {module}:Rested{n}", "rested{n} = {module}:Nobody", ["cannot be loaded", "Nobody"]),
        ("rested{n} = {module}:Rested{n}", "rested{n} = {module}:Soft{n}", ["no subclass of", "Condition"]),
        ("rested{n} = {module}:Rested{n}", "rested{n} = nowhere:Rested", ["No module named 'nowhere'"]),
        ("soft{n} = {module}:Soft{n}", "soft{n} = {module}:Soft{n}x", ["macta.responses", "1.2"]),
    ],
)
def test_a_broken_entry_point_is_named_with_its_package(
    tmp_path: Path, old: str, new: str, words: list[str]
) -> None:
    package = Package(tmp_path, ENTRY_POINTS.replace(old, new))
    with pytest.raises(RepertoireError) as refused:
        package.repertoire()
    assert [word for word in (*words, package.module) if word not in str(refused.value)] == []


def test_a_class_registered_under_another_name_is_refused(tmp_path: Path) -> None:
    package = Package(tmp_path, ENTRY_POINTS.replace("rested{n} =", "tired{n} ="))
    with pytest.raises(RepertoireError, match="register it as rested"):
        package.repertoire("sense: rested", "sense: tired")


def test_two_packages_with_the_same_name_are_refused_naming_both(tmp_path: Path) -> None:
    package = Package(tmp_path)
    rival = ENTRY_POINTS.partition("[macta.stimuli]")[0].format(n=package.n, module="rival")
    write_package(tmp_path, "rival", rival, {})
    with pytest.raises(RepertoireError) as refused:
        package.repertoire()
    assert "rival 1.2" in str(refused.value)
    assert f"{package.module} 1.2" in str(refused.value)


def test_a_class_of_a_package_does_not_replace_one_of_ours(tmp_path: Path) -> None:
    usurper = "\n\nclass Linear(Response):\n    def at(self, s: float) -> float:\n        return -s\n"
    Package(tmp_path, python=PYTHON + usurper).repertoire()
    assert "Linear" in [one.__name__ for one in Response.__subclasses__() if one is not Linear]
    chosen = TypeAdapter(AnyResponse).validate_python({"form": "linear"})
    assert type(chosen) is Linear
