"""A packet is tuned with data, for a robot or for one packet of a script; what does not fit is refused by name."""

from pathlib import Path

import pytest

from robots.errors import RepertoireError
from robots.executive.trace import Instant, Trace
from robots.physical.body import Pose
from robots.reactive.responses import Linear
from robots.reactive.stimuli import Proximity
from robots.repertoire import Tuning, load_repertoire, parameters
from robots.wire import Clearance, Message, PacketState, Performative, Retune, TuningReport
from robots.world import WorldFileError, load_world
from tests.robots.fake_world import FakeWorld
from tests.robots.sensed import PROFILE
from tests.robots.stories import Service, packet, room, run, run_for, script

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
            assert load_world(file, check_tuning=REPERTOIRE.tuned).robot("yard_1").tuning["NAVIGATE"]
            continue
        with pytest.raises(
            WorldFileError, match=r"robots.yard_1.tuning: NAVIGATE: translate/obstacle_avoid: r.gain"
        ):
            load_world(file, check_tuning=REPERTOIRE.tuned)


def test_parameters_are_listed_with_those_that_the_packet_leaves_at_their_defaults() -> None:
    tuned = parameters(REPERTOIRE.tuned({"NAVIGATE": GENTLE}).specs["NAVIGATE"])
    avoids = {"stimulus.reach_m": 0.4, "stimulus.sector_rad": 0.7, "r.gain": -0.5}
    assert tuned["translate/obstacle_avoid"] == {**avoids, "r.offset": 0.0, "r.limit": 1.0, "u.gain": 1.0}


def test_every_listed_parameter_can_be_set_to_what_it_is() -> None:
    for tag, spec in REPERTOIRE.specs.items():
        REPERTOIRE.tuned({tag: parameters(spec)})


SLOW = {"NAVIGATE": {"translate/advance": {"r.gain": 0.2}}}


def navigator() -> tuple[FakeWorld, Service]:
    world = room()
    service = Service(world, world.add("fred", Pose(x_m=4.2, y_m=1.2, heading_rad=0)), "fred")
    service.order(script("fred", packet("NAVIGATE", ref2="yard"), packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 0.5)
    return world, service


def reply(service: Service, request: Message) -> tuple[Performative, object]:
    answer = next(m for m in service.heard if m.in_reply_to == request.id)
    return answer.performative, answer.body


def of(trace: Trace, packet_id: str) -> list[Instant]:
    return [instant for instant in trace if instant.packet_id == packet_id]


def test_a_packet_under_way_is_not_tuned_but_the_next_one_is() -> None:
    world, service = navigator()
    request = service.send(Retune(version=1, tuning=SLOW))
    trace = world.agents["fred"].trace
    assert run(world, [service], lambda: len(of(trace, "NAVIGATE-door")) > 60)
    assert reply(service, request) == (Performative.AGREE, TuningReport(version=1))

    def advance(packet_id: str) -> float:
        return max(i.responses.shown().get("translate/advance", (0.0, 0.0))[0] for i in of(trace, packet_id))

    assert advance("NAVIGATE-yard") > 0.5
    assert advance("NAVIGATE-door") == pytest.approx(0.2, abs=0.01)


def test_tuning_replaces_what_was_sent_before_and_an_older_one_changes_nothing() -> None:
    world, service = navigator()
    service.send(Retune(version=2, tuning={}))
    late = service.send(Retune(version=1, tuning=SLOW))
    trace = world.agents["fred"].trace
    assert run(world, [service], lambda: len(of(trace, "NAVIGATE-door")) > 60)
    assert reply(service, late)[0] is Performative.AGREE
    assert max(i.responses.shown().get("translate/advance", (0.0, 0.0))[0] for i in trace) > 0.5


def test_tuning_that_the_robot_cannot_use_is_refused_and_changes_nothing() -> None:
    world, service = navigator()
    request = service.send(Retune(version=1, tuning={"FLY": {"translate/up": {"r.gain": 1.0}}}))
    run_for(world, [service], 0.2)
    performative, body = reply(service, request)
    assert performative is Performative.REFUSE
    assert isinstance(body, TuningReport)
    assert body.reason.startswith("unknown packet FLY")


def test_a_clearance_that_came_before_the_tuning_still_counts() -> None:
    world = room()
    service = Service(world, world.add("fred", Pose(x_m=4.2, y_m=1.2, heading_rad=0)), "fred")
    order = script("fred", packet("NAVIGATE", ref2="yard"), packet("NAVIGATE", ref2="door", after=["other"]))
    service.order(order)
    run_for(world, [service], 0.2)
    service.send(Clearance(script_id=order.id, ended=("other",)))
    run_for(world, [service], 0.2)
    service.send(Retune(version=1, tuning=SLOW))
    assert run(world, [service], lambda: service.packets.count(("NAVIGATE", PacketState.RUNNING)) == 2)
