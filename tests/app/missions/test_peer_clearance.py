"""Robots that sense nothing of each other's work go on while the service cannot be reached: they clear each other."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from app.agents.agent_models import Reception
from robots.wire import PacketReport, PacketState, Performative, SpeechReport
from robots.world import LinkSpec
from tests.app.missions.radioed_fleet import RadioedFleet
from tests.app.missions.test_couplings import ALL_BLIND, Runs, begun_and_ended_s, store_with
from tests.app.sample_store import Store


def speaking() -> Store:
    return Store(store_with(**ALL_BLIND).world.model_copy(update={"peer_link": LinkSpec()}))


@pytest.fixture
def runs(tmp_path: Path) -> Iterator[Runs]:
    made = Runs(tmp_path, speaking())
    yield made
    made.services.close()


def dock_and_release(fleet: RadioedFleet) -> tuple[str, str]:
    """The action that waits, and the one that it waits for."""
    store_2, yard_1 = fleet.robots["store_2"].script, fleet.robots["yard_1"].script
    assert store_2 is not None
    assert yard_1 is not None
    return (
        next(one.id for one in store_2.packets if one.tag == "DOCK"),
        next(one.id for one in yard_1.packets if one.tag == "RELEASE2"),
    )


def test_with_the_uplink_cut_for_the_whole_mission_it_completes_and_the_service_learns_everything(
    runs: Runs,
) -> None:
    for seed in range(20):
        fleet = runs.fleet(seed, peers=True, is_cut=True)
        assert fleet.run() == "completed", (seed, fleet.reasons)
        fleet.go_on(120.0)
        begun_s, ended_s = begun_and_ended_s(fleet)
        assert begun_s >= ended_s
        mission = runs.services.mission(runs.mission_id)
        assert mission.contradictions == [], seed
        dock, release = dock_and_release(fleet)
        store_2, _ = runs.services.scripts(runs.mission_id)
        assert store_2.packets[dock]["cleared_by"] == {release: ["yard_1"]}
        (said,) = [
            one for one in runs.services.missions.conversation(runs.mission_id) if one["answer"] == "confirm"
        ]
        assert (said["sender"], said["robot"], said["performative"]) == ("yard_1", "store_2", "inform")
        assert said["content"] == f"ended({store_2.id}, {release})"
        assert ended_s <= said["sent_at_s"] <= said["at_s"] <= begun_s


def test_without_speech_a_cut_uplink_keeps_the_waiting_robot_where_it_is(runs: Runs) -> None:
    fleet = runs.fleet(0, is_cut=True)
    fleet.run()
    begun_s, ended_s = begun_and_ended_s(fleet)
    assert begun_s > ended_s + 400.0


def test_whoever_clears_first_the_robot_starts_after_the_others_end(runs: Runs) -> None:
    by_peer = 0
    for seed in range(10):
        fleet = runs.fleet(seed, peers=True)
        assert fleet.run() == "completed", (seed, fleet.reasons)
        begun_s, ended_s = begun_and_ended_s(fleet)
        assert begun_s >= ended_s, seed
        assert runs.services.mission(runs.mission_id).contradictions == []
        assert not any("contradict" in reason or "clearance, but" in reason for reason in fleet.reasons)
        by_peer += bool(fleet.robots["store_2"].said_by)
    print(f"{by_peer} of 10 were told by the other robot")
    assert by_peer > 6


def test_a_robot_that_does_not_wait_is_found_out_as_before(runs: Runs) -> None:
    for seed in range(3):
        fleet = runs.fleet(seed, peers=True, disobedient=("store_2",))
        state = fleet.run()
        begun_s, ended_s = begun_and_ended_s(fleet)
        if begun_s < ended_s:
            assert state in ("failed", "partially_completed"), seed
            assert runs.services.mission(runs.mission_id).contradictions


class Said:
    """store_2 has its script and says to have begun to dock; yard_1 has reported nothing."""

    def __init__(self, runs: Runs) -> None:
        self.fleet = runs.fleet(0, peers=True)
        self.services = runs.services
        self.services.life.monitor(runs.mission_id)
        self.mission_id = runs.mission_id
        self.clock = runs.clock
        self.store_2, self.yard_1 = self.services.scripts(runs.mission_id)
        self.dock = next(one["id"] for one in self.store_2.body["packets"] if one["tag"] == "DOCK")
        self.release = next(one["id"] for one in self.yard_1.body["packets"] if one["tag"] == "RELEASE2")
        runs.clock.advance(100.0)

    def begins(self, cleared_by: dict[str, tuple[str, ...]]) -> Reception:
        report = PacketReport(
            script_id=self.store_2.id,
            packet_id=self.dock,
            state=PacketState.RUNNING,
            at_s=self.clock.now_s(),
            cleared_by=cleared_by,
        )
        return self.fleet.hear("store_2", report)

    def ends(self, at_s: float) -> None:
        report = PacketReport(
            script_id=self.yard_1.id, packet_id=self.release, state=PacketState.FINISHED, at_s=at_s
        )
        assert self.fleet.hear("yard_1", report) is Reception.RECORDED


@pytest.mark.parametrize(
    ("who", "reception"),
    [("yard_1", Reception.RECORDED), ("yard_2", Reception.HELD_BACK), (None, Reception.HELD_BACK)],
)
def test_a_robot_is_believed_that_begins_by_the_word_of_the_one_that_its_script_names(
    runs: Runs, who: str | None, reception: Reception
) -> None:
    said = Said(runs)
    assert said.begins({said.release: (who,)} if who else {}) is reception


def test_the_word_of_a_robot_does_not_end_its_action_in_the_record_which_its_own_report_does(
    runs: Runs,
) -> None:
    said = Said(runs)
    said.begins({said.release: ("yard_1",)})
    assert said.services.mission(said.mission_id).contradictions == []
    _, yard_1 = said.services.scripts(said.mission_id)
    assert said.release not in yard_1.packets
    said.ends(said.clock.now_s() - 1.0)
    assert said.services.mission(said.mission_id).contradictions == []


def test_a_robot_that_reports_to_have_ended_later_than_it_has_said_is_found_out(runs: Runs) -> None:
    said = Said(runs)
    said.begins({said.release: ("yard_1",)})
    said.clock.advance(30.0)
    said.ends(said.clock.now_s())
    (one,) = said.services.mission(said.mission_id).contradictions
    assert (one["later"]["robot"], one["earlier"]["robot"]) == ("store_2", "yard_1")


def test_a_conversation_that_is_reported_twice_is_shown_once(runs: Runs) -> None:
    said = Said(runs)
    for _ in range(2):
        report = SpeechReport(
            script_id=said.store_2.id,
            sender="yard_1",
            performative=Performative.INFORM,
            content=f"ended({said.store_2.id}, {said.release})",
            conversation_id="c-1",
            sent_at_s=1.0,
            at_s=2.0,
            answer=Performative.CONFIRM,
        )
        assert said.fleet.hear("store_2", report) is Reception.RECORDED
    assert len(said.services.missions.conversation(said.mission_id)) == 1


def test_robots_that_do_not_speak_get_scripts_without_it(tmp_path: Path) -> None:
    silent = speaking().world
    robots = tuple(
        one.model_copy(update={"speaks": ()}) if one.name == "yard_1" else one for one in silent.robots
    )
    runs = Runs(tmp_path, Store(silent.model_copy(update={"robots": robots})))
    runs.fleet(0)
    runs.services.life.monitor(runs.mission_id)
    packets = [one for script in runs.services.scripts(runs.mission_id) for one in script.body["packets"]]
    assert any(one["after"] for one in packets)
    assert not any(one["told_by"] or one["tells"] for one in packets)
    runs.services.close()
