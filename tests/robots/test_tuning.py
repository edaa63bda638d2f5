"""A packet is tuned with data, for a robot or for one packet of a script; what does not fit is refused by name."""

from pathlib import Path

import pytest

from robots.errors import RepertoireError
from robots.repertoire import Tuning, load_repertoire
from robots.responses import Linear
from robots.stimuli import Proximity
from robots.world import WorldFileError, load_world
from tests.robots.sensed import PROFILE
from tests.robots.stories import packet

REPERTOIRE = load_repertoire()
GENTLE = {"translate/obstacle_avoid": {"stimulus.reach_m": 0.4, "r.gain": -0.5}}


def avoidance(tag: str, repertoire: object = None, **more: object) -> tuple[object, object]:
    """Stimulus and response of a packet's translate/obstacle_avoid."""
    wanted = packet(tag, ref2="bay").model_copy(update=more)
    bound = (repertoire or REPERTOIRE).bind(wanted, PROFILE)  # type: ignore[attr-defined]
    one = next(one for one in bound.patterns if (one.dof, one.name) == ("translate", "obstacle_avoid"))
    return one.stimulus, one.r


def test_a_robots_tuning_replaces_parameters_and_leaves_the_rest() -> None:
    stimulus, response = avoidance("NAVIGATE", REPERTOIRE.tuned({"NAVIGATE": GENTLE}))
    assert isinstance(stimulus, Proximity)
    assert isinstance(response, Linear)
    assert (stimulus.reach_m, stimulus.sector_rad, response.gain) == (0.4, 0.7, -0.5)


def test_one_packet_of_a_script_can_be_tuned_alone() -> None:
    tuned, plain = avoidance("NAVIGATE", tuning=GENTLE), avoidance("NAVIGATE")
    assert tuned != plain
    assert tuned == avoidance("NAVIGATE", REPERTOIRE.tuned({"NAVIGATE": GENTLE}))


@pytest.mark.parametrize(
    ("tuning", "names"),
    [
        (
            {"translate/avoid": {"r.gain": 1}},
            r"NAVIGATE has no pattern translate/avoid; it has .*rotate/steer",
        ),
        ({"translate/advance": {"gain": 1}}, r"NAVIGATE: translate/advance: gain = 1.*stimulus.X"),
        ({"translate/advance": {"r.gian": 1}}, r"NAVIGATE: translate/advance: r.gian = 1.*[Uu]nexpected"),
        ({"translate/advance": {"r.limit": 1.5}}, r"NAVIGATE: translate/advance: r.limit = 1.5.*less than"),
        ({"translate/advance": {"stimulus.full_m": 0}}, r"stimulus.full_m = 0.*greater than 0"),
        ({"translate/advance": {"stimulus.full_m": float("nan")}}, r"stimulus.full_m = nan"),
        ({"translate/advance": {"stimulus.place": 3}}, r"stimulus.place = 3.*string"),
    ],
)
def test_tuning_that_does_not_fit_is_refused_by_packet_pattern_and_parameter(
    tuning: Tuning, names: str
) -> None:
    with pytest.raises(RepertoireError, match=names):
        REPERTOIRE.tuned({"NAVIGATE": tuning})


def test_tuning_an_unknown_packet_is_refused() -> None:
    with pytest.raises(RepertoireError, match="unknown packet FLY"):
        REPERTOIRE.tuned({"FLY": {}})


def test_a_world_file_tunes_its_robots_and_is_checked_when_loaded(tmp_path: Path) -> None:
    text = (Path("robots/world/files") / "sample_store.yaml").read_text()
    assert "name: yard_1," in text
    for gain, fits in ((-0.5, True), (-500, False)):
        file = tmp_path / f"store{gain}.yaml"
        tuning = f'{{NAVIGATE: {{"translate/obstacle_avoid": {{"r.gain": {gain}}}}}}}'
        file.write_text(text.replace("name: yard_1,", f"name: yard_1, tuning: {tuning},", 1))
        if fits:
            assert load_world(file).robot("yard_1").tuning["NAVIGATE"]
            continue
        with pytest.raises(
            WorldFileError, match=r"robots.yard_1.tuning: NAVIGATE: translate/obstacle_avoid: r.gain"
        ):
            load_world(file)
