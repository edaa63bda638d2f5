"""A world goes on in another edition: what was there stays where it is, what is new is there, what is gone is not."""

from math import hypot
from typing import Any

import pytest

from robots.physical.body import GRIPPER_REACH_M, Gripper, Pose
from robots.wire import (
    WORLD,
    Acknowledgement,
    BehaviourPacket,
    BehaviourScript,
    Factsheet,
    Message,
    Performative,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    WorldChange,
    WorldEdition,
)
from robots.world import Edition, Sample, WorldFile, load_world
from sim.snapshot import WorldSnapshot
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.sim.rig import run_s

FILE = load_world("sample_store")
NEW = Sample(name="sample_9", at="door_2")


def changed(world: WorldFile = FILE, *, without: str = "", new: Sample | None = None) -> WorldFile:
    kept = [sample for sample in world.samples if sample.name != without]
    samples = [*kept, *([new] if new else ())]
    return WorldFile.model_validate(
        {**world.model_dump(), "samples": [sample.model_dump() for sample in samples]}
    )


def asked(simulation: Simulation, edition: int, world: WorldFile) -> WorldEdition:
    """What the world answers to a request to take up an edition."""
    change = WorldChange(edition=edition, world=world.model_dump(mode="json"))
    request = Message(
        performative=Performative.REQUEST, sender="service", receiver=WORLD, sent_at_s=0.0, body=change
    )
    simulation.link.send(request)
    run_s(simulation, 0.1)
    (answer,) = (one for one in simulation.link.receive() if one.sender == WORLD)
    assert answer.in_reply_to == request.id
    assert isinstance(answer.body, WorldEdition)
    return answer.body


def simulated(snapshot: WorldSnapshot | None = None, edition: Edition | None = None) -> Simulation:
    return Simulation(
        FILE, make_agent=behavioural_agent, seed=3, jitter_m=0.0, snapshot=snapshot, edition=edition
    )


def test_a_sample_is_added_and_another_removed_while_nothing_else_moves() -> None:
    simulation = simulated()
    run_s(simulation, 1.0)
    before = simulation.truth()
    assert asked(simulation, 1, changed(without="sample_1", new=NEW)).edition == 1
    after = simulation.truth()
    assert after.samples.keys() == before.samples.keys() - {"sample_1"} | {"sample_9"}
    assert after.samples["sample_9"].place == "door_2"
    for name in ("sample_2", "sample_3", "sample_4"):
        assert after.samples[name] == before.samples[name]
    for name, pose in before.robots.items():
        now = after.robots[name]
        assert hypot(now.x_m - pose.x_m, now.y_m - pose.y_m) < 0.01


def test_an_edition_that_was_taken_up_is_not_taken_up_again() -> None:
    simulation = simulated()
    assert asked(simulation, 2, changed(new=NEW)).edition == 2
    scene = simulation.scene
    assert asked(simulation, 1, changed(without="sample_1")).edition == 2
    assert simulation.scene is scene


def test_a_world_that_cannot_be_made_is_refused_and_the_present_one_goes_on() -> None:
    simulation = simulated()
    nowhere = {**FILE.model_dump(mode="json"), "samples": [{"name": "sample_9", "at": "nowhere"}]}
    simulation.link.send(
        Message(
            performative=Performative.REQUEST,
            sender="service",
            receiver=WORLD,
            sent_at_s=0.0,
            body=WorldChange(edition=1, world=nowhere),
        )
    )
    run_s(simulation, 0.1)
    (answer,) = (one for one in simulation.link.receive() if one.sender == WORLD)
    assert isinstance(answer.body, WorldEdition)
    assert answer.performative is Performative.REFUSE
    assert "unknown location 'nowhere'" in answer.body.reason
    assert "sample_1" in simulation.truth().samples


def test_a_changed_world_goes_on_from_its_snapshot_without_being_told_of_the_change() -> None:
    simulation = simulated()
    asked(simulation, 1, changed(without="sample_1", new=NEW))
    snapshot = WorldSnapshot.model_validate_json(simulation.snapshot().model_dump_json())
    resumed = simulated(snapshot)
    assert resumed.edition == 1
    assert resumed.truth() == simulation.truth()


def test_a_world_goes_on_in_an_edition_that_is_newer_than_its_snapshot() -> None:
    simulation = simulated()
    run_s(simulation, 0.5)
    resumed = simulated(simulation.snapshot(), Edition(1, changed(new=NEW)))
    assert resumed.edition == 1
    assert resumed.truth().samples["sample_9"].place == "door_2"
    assert resumed.truth().robots == simulation.truth().robots


def test_what_a_robot_held_is_gone_from_its_jaws_with_the_sample() -> None:
    simulation = simulated()
    x_m, y_m, _ = simulation.scene.sample_point("sample_1")
    simulation.scene.put_rover("yard_1", Pose(x_m=x_m - GRIPPER_REACH_M, y_m=y_m, heading_rad=0.0))
    simulation.bodies["yard_1"].set_gripper(closed=True)
    assert simulation.truth().samples["sample_1"].holders == ("yard_1",)
    simulation.take_up(Edition(1, changed(without="sample_1")))
    run_s(simulation, 0.1)
    assert "sample_1" not in simulation.truth().samples
    assert simulation.bodies["yard_1"].sense().gripper in (None, Gripper(closed=True, between_jaws=None))


def test_a_robot_is_added_another_removed_and_a_place_moved_while_scripts_go_on() -> None:
    simulation = simulated()
    script = to_the_door("yard_1")
    simulation.link.send(asked_of("yard_1", ScriptRequest(script=script)))
    run_s(simulation, 1.0)
    document = FILE.model_dump()
    robots = [one for one in document["robots"] if one["name"] != "yard_2"]
    new = {"name": "yard_3", "compartment": "yard", "start": [4, 1.4, -90]}
    places = [one | {"at": (6.3, 0.4)} if one["name"] == "door_2" else one for one in document["locations"]]
    changed_world = {**document, "robots": [*robots, new], "locations": places}
    assert asked(simulation, 1, WorldFile.model_validate(changed_world)).edition == 1
    assert simulation.truth().robots.keys() == {"yard_1", "yard_3", "store_1", "store_2"}
    simulation.link.send(asked_of("yard_3", ScriptRequest(script=to_the_door("yard_3", "door_2"))))
    ended: dict[str, ScriptState] = {}

    def both_ended() -> bool:
        for message in simulation.link.receive():
            if isinstance(message.body, ScriptReport):
                ended[message.sender] = message.body.state
        return len(ended) == 2

    simulation.run_until(both_ended, timeout_s=60)
    assert ended == {"yard_1": ScriptState.FINISHED, "yard_3": ScriptState.FINISHED}
    x_m, y_m = (simulation.truth().robots["yard_3"].x_m, simulation.truth().robots["yard_3"].y_m)
    assert hypot(x_m - 6.3, y_m - 1.2) < 0.3  # before the door where it is now


def with_robot(name: str, **values: Any) -> WorldFile:
    """The world in which one robot is otherwise."""
    document = FILE.model_dump()
    robots = [one | values if one["name"] == name else one for one in document["robots"]]
    return WorldFile.model_validate({**document, "robots": robots})


@pytest.mark.parametrize(
    "values",
    [
        {"speed_m_s": 0.2, "turn_rad_s": 0.8},
        {"repertoire": ["NAVIGATE"]},
        {"home": None},
        {"start": [2.0, 1.4, 0]},
        {"architecture": "sequential"},
        {"sonar": ["real"]},
        {"sonar": ["map", "virtual"]},
        {"sensors": [{"kind": "camera"}]},
        {"tuning": {"NAVIGATE": {"translate/obstacle_avoid": {"stimulus.reach_m": 0.4}}}},
        {"link": {"delay_s": 0.5}},
    ],
)
def test_a_robot_that_is_changed_goes_on_with_its_script_from_where_it_is(values: dict[str, Any]) -> None:
    simulation = simulated()
    simulation.link.send(asked_of("yard_1", ScriptRequest(script=to_the_door("yard_1"))))
    run_s(simulation, 1.5)
    before = simulation.truth().robots
    simulation.take_up(Edition(1, with_robot("yard_1", **values)))
    assert simulation.truth().robots == before
    ended: list[ScriptState] = []

    def has_ended() -> bool:
        ended.extend(
            one.body.state for one in simulation.link.receive() if isinstance(one.body, ScriptReport)
        )
        return bool(ended)

    simulation.run_until(has_ended, timeout_s=45)
    assert ended == [ScriptState.FINISHED]


def test_a_robot_that_is_made_slower_drives_slower_at_once() -> None:
    simulation = simulated()
    simulation.link.send(asked_of("yard_1", ScriptRequest(script=to_the_door("yard_1"))))
    run_s(simulation, 2.0)
    simulation.take_up(Edition(1, with_robot("yard_1", speed_m_s=0.1)))
    run_s(simulation, 0.5)
    before = simulation.truth().robots["yard_1"]
    run_s(simulation, 1.0)
    after = simulation.truth().robots["yard_1"]
    assert 0.0 < hypot(after.x_m - before.x_m, after.y_m - before.y_m) < 0.12


def test_a_robot_gets_another_radio() -> None:
    simulation = simulated()
    simulation.take_up(Edition(1, with_robot("yard_1", link={"delay_s": 2.0})))
    simulation.link.send(asked_of("yard_1", ScriptRequest(script=to_the_door("yard_1"))))
    run_s(simulation, 3.0)
    assert not [one for one in simulation.link.receive() if isinstance(one.body, Acknowledgement)]
    run_s(simulation, 1.5)
    assert [one for one in simulation.link.receive() if isinstance(one.body, Acknowledgement)]


def test_a_robot_with_software_of_its_own_is_not_simulated() -> None:
    simulation = simulated()
    run_s(simulation, 0.5)
    simulation.take_up(Edition(1, with_robot("yard_1", external=True)))
    run_s(simulation, 0.5)
    assert simulation.truth().robots.keys() == {"yard_2", "store_1", "store_2"}
    document = FILE.model_dump()
    nobody = [robot | {"external": True} for robot in document["robots"]]
    simulation.take_up(Edition(2, WorldFile.model_validate({**document, "robots": nobody})))
    run_s(simulation, 0.5)
    assert simulation.truth().robots == {}
    assert simulation.truth().samples["sample_1"].place == "door_1"
    simulation.take_up(Edition(3, FILE))
    run_s(simulation, 0.1)
    assert simulation.truth().robots.keys() == {"yard_1", "yard_2", "store_1", "store_2"}


def test_a_robot_tells_what_it_is_when_it_starts_and_once_it_has_changed() -> None:
    simulation = simulated()
    run_s(simulation, 0.5)

    def told() -> list[tuple[str, int, int | None, float]]:
        return [
            (one.sender, sheet.number, sheet.edition, sheet.speed_m_s)
            for one in simulation.link.receive()
            if isinstance(sheet := one.body, Factsheet)
        ]

    assert sorted(told()) == [(one.name, 0, 0, 0.5) for one in sorted(FILE.robots, key=lambda one: one.name)]
    snapshot = WorldSnapshot.model_validate_json(simulation.snapshot().model_dump_json())
    simulation.take_up(Edition(1, with_robot("yard_1", speed_m_s=0.2)))
    run_s(simulation, 0.5)
    news = {one for one in told() if one[1] > 0}  # the first ones are repeated: nobody has confirmed them
    assert news == {("yard_1", 1, 1, 0.2)}
    resumed = simulated(snapshot)
    run_s(resumed, 0.5)
    numbers = {
        one.sender: one.body.number for one in resumed.link.receive() if isinstance(one.body, Factsheet)
    }
    assert set(numbers.values()) == {0}


def test_agents_in_processes_of_their_own_go_on_as_in_one() -> None:
    document = FILE.model_dump()
    robots = [one for one in document["robots"] if one["name"] != "store_1"]
    new = {"name": "yard_3", "compartment": "yard", "start": [4, 1.4, -90]}
    edition = Edition(1, WorldFile.model_validate({**document, "robots": [*robots, new]}))
    truths = []
    for processes in (1, 3):
        simulation = Simulation(FILE, make_agent=behavioural_agent, seed=3, jitter_m=0.0, processes=processes)
        simulation.link.send(asked_of("yard_1", ScriptRequest(script=to_the_door("yard_1"))))
        run_s(simulation, 0.5)
        simulation.take_up(edition)
        simulation.link.send(asked_of("yard_3", ScriptRequest(script=to_the_door("yard_3", "door_2"))))
        run_s(simulation, 3.0)
        truths.append(simulation.truth())
        simulation.close()
    assert truths[0] == truths[1]
    assert truths[0].robots["yard_3"].x_m > 4.2  # under way


def asked_of(robot: str, body: ScriptRequest) -> Message:
    return Message(
        performative=Performative.REQUEST, sender="service", receiver=robot, sent_at_s=0.0, body=body
    )


def to_the_door(robot: str, place: str = "door_1") -> BehaviourScript:
    """One packet: drive near a door."""
    start = f"{robot}_spot" if robot == "yard_3" else f"home_{robot}"
    packet = BehaviourPacket(
        id="a1",
        tag="NAVIGATE",
        arguments={
            "robots": robot,
            "rel1": "near",
            "ref1": start,
            "rel2": "near",
            "ref2": place,
            "area": "yard",
        },
        expected_start_s=0.0,
        expected_duration_s=20.0,
        timeout_s=50.0,
        wait_timeout_s=20.0,
    )
    return BehaviourScript(id=f"{robot}-script", mission_id="m", robot=robot, packets=(packet,))


def test_a_delivery_arrives_once_its_place_is_free_and_its_robots_are_not_told() -> None:
    deliveries = [
        {"name": "sample_8", "at": "door_2", "after_s": 0.5},
        {"name": "sample_9", "at": "door_1", "after_s": 0.5},
    ]
    file = WorldFile.model_validate({**FILE.model_dump(), "deliveries": deliveries})
    simulation = Simulation(file, make_agent=behavioural_agent, seed=3, jitter_m=0.0)
    assert "sample_8" not in simulation.truth().samples
    run_s(simulation, 1.0)
    assert simulation.truth().samples["sample_8"].place == "door_2"
    assert "sample_9" not in simulation.truth().samples  # sample_1 lies at door_1
    simulation.take_up(Edition(1, changed(file, without="sample_1")))
    run_s(simulation, 0.1)
    assert simulation.truth().samples["sample_9"].place == "door_1"
    snapshot = WorldSnapshot.model_validate_json(simulation.snapshot().model_dump_json())
    resumed = Simulation(file, make_agent=behavioural_agent, snapshot=snapshot)
    assert resumed.truth() == simulation.truth()
    known = {"name": "sample_8", "at": "door_2", "length_m": 0.0}
    seen = {**file.model_dump(), "samples": [known], "deliveries": deliveries[1:]}
    simulation.take_up(Edition(2, WorldFile.model_validate(seen)))
    assert simulation.truth().samples.keys() == {"sample_8", "sample_9"}


def other_body(world: WorldFile, robot: str, kind: str) -> WorldFile:
    document = world.model_dump()
    robots = [one | {"body": kind} if one["name"] == robot else one for one in document["robots"]]
    return WorldFile.model_validate({**document, "robots": robots})


@pytest.mark.parametrize("kinds", [("avatar", "velocity"), ("wheeled", "avatar"), ("avatar", "wheeled")])
def test_a_robots_software_goes_on_with_its_script_in_other_bodies(kinds: tuple[str, str]) -> None:
    simulation = simulated()
    simulation.link.send(asked_of("yard_1", ScriptRequest(script=to_the_door("yard_1"))))
    run_s(simulation, 1.0)
    software = dict(simulation.agents)
    world = FILE
    sheets: list[Factsheet] = []
    ended: list[ScriptState] = []

    def receive() -> bool:
        for message in simulation.link.receive():
            if message.sender == "yard_1" and isinstance(message.body, Factsheet):
                sheets.append(message.body)
            if message.sender == "yard_1" and isinstance(message.body, ScriptReport):
                ended.append(message.body.state)
        return bool(ended)

    for number, kind in enumerate(kinds, 1):
        before = simulation.truth().robots["yard_1"]
        world = other_body(world, "yard_1", kind)
        simulation.take_up(Edition(number, world))
        now = simulation.truth().robots["yard_1"]
        assert hypot(now.x_m - before.x_m, now.y_m - before.y_m) < 0.01
        assert dict(simulation.agents) == software, "with all that they have in mind"
        run_s(simulation, 1.0)
        receive()
    assert simulation.run_until(receive, timeout_s=60.0)
    assert ended == [ScriptState.FINISHED]
    told = {sheet.number: sheet.body["kind"] for sheet in sheets if isinstance(sheet.body, dict)}
    assert told == dict(enumerate(("velocity", *kinds)))


def test_a_robot_goes_on_in_its_other_body_after_a_power_failure_during_the_exchange() -> None:
    simulation = simulated()
    simulation.link.send(asked_of("yard_1", ScriptRequest(script=to_the_door("yard_1"))))
    run_s(simulation, 1.5)
    snapshot = WorldSnapshot.model_validate_json(simulation.snapshot().model_dump_json())
    resumed = simulated(snapshot, Edition(1, other_body(FILE, "yard_1", "wheeled")))
    again = WorldSnapshot.model_validate_json(resumed.snapshot().model_dump_json())
    resumed = simulated(again)
    ended: list[ScriptState] = []

    def has_ended() -> bool:
        for message in resumed.link.receive():
            if message.sender == "yard_1" and isinstance(message.body, ScriptReport):
                ended.append(message.body.state)
        return bool(ended)

    assert resumed.run_until(has_ended, timeout_s=60.0)
    assert ended == [ScriptState.FINISHED]


def test_robots_in_other_processes_go_on_as_well() -> None:
    def ended_at(processes: int) -> list[tuple[str, float]]:
        simulation = Simulation(FILE, make_agent=behavioural_agent, seed=3, jitter_m=0.0, processes=processes)
        try:
            for robot, door in (("yard_1", "door_1"), ("yard_2", "door_2")):
                simulation.link.send(asked_of(robot, ScriptRequest(script=to_the_door(robot, door))))
            run_s(simulation, 1.0)
            simulation.take_up(Edition(1, other_body(FILE, "yard_2", "wheeled")))
            ended: list[tuple[str, float]] = []

            def both_ended() -> bool:
                for message in simulation.link.receive():
                    if isinstance(message.body, ScriptReport):
                        ended.append((message.sender, message.sent_at_s))
                return len(ended) == 2

            assert simulation.run_until(both_ended, timeout_s=60.0)
            return ended
        finally:
            simulation.close()

    assert ended_at(2) == ended_at(1)
