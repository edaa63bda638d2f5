"""Recordings: what is written is read again, whatever became of the process; the oldest give way."""

import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from app.agents.robot_board import RobotView
from app.domain.errors import NotFound
from app.recordings import RecordingStore, replay_of
from app.recordings.mcap_writer import CHUNK_BYTES, EVENTS, MISSION, PLAN, WORLD
from app.recordings.mission_recording import MissionRecording
from robots.wire import MindReport, Telemetry, ToldAgent, ToldBelief

MB = 1_000_000


def said(at_s: float, x_m: float, **more: object) -> Telemetry:
    return Telemetry.model_validate({"at_s": at_s, "x_m": x_m, "y_m": 2.0, "heading_rad": 3.0, **more})


@pytest.fixture
def store(tmp_path: Path) -> RecordingStore:
    return RecordingStore(tmp_path, budget_bytes=MB)


def record(
    store: RecordingStore, mission_id: str = "mission-1", *, from_s: float = 0.0, count: int = 50
) -> Path:
    with store.new_part(mission_id) as writer:
        writer.write_json(WORLD, {"id": "store", "layout": {}}, from_s)
        writer.write_json(PLAN, {"id": "plan-1"}, from_s)
        writer.write_json(MISSION, {"id": mission_id, "state": "running"}, from_s)
        for tick in range(count):
            writer.write_robots(
                {"yard_1": said(from_s + tick / 10, tick / 100, packet_tag="NAVIGATE")}, whole={"yard_1"}
            )
        writer.write_json(EVENTS, {"type": "mission.completed", "subject": mission_id}, from_s + count / 10)
    return writer.path


def test_what_was_recorded_is_replayed(store: RecordingStore) -> None:
    record(store)
    replay = replay_of(store.entries("mission-1"))
    assert replay.world == {"id": "store", "layout": {}}
    assert list(replay.plans) == ["plan-1"]
    assert [one["mission"]["state"] for one in replay.missions] == ["running"]
    assert replay.events == [{"at_s": 5.0, "type": "mission.completed", "subject": "mission-1"}]
    rows = replay.robots["yard_1"]
    assert rows[0] == [0.0, 0.0, 2.0, 3.0, None, "NAVIGATE"]
    assert [row[0] for row in rows] == sorted(row[0] for row in rows)
    assert len(rows) == 25  # every 0.2 s of what came every 0.1 s


def test_any_reader_of_the_foxglove_schemas_finds_the_robots(store: RecordingStore) -> None:
    record(store)
    with store.merged_file("mission-1") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary is not None
        kinds = {
            channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()
        }
        assert kinds["/tf"] == "foxglove.FrameTransforms"
        assert kinds["/poses/yard_1"] == "foxglove.PoseInFrame"
        told = [message for _, _, _, message in reader.iter_decoded_messages(topics=["/tf"])]
    last = told[-1].transforms[0]
    assert (last.parent_frame_id, last.child_frame_id) == ("world", "yard_1")
    assert last.translation.x == pytest.approx(0.49)
    assert (last.rotation.z, last.rotation.w) == pytest.approx((0.9975, 0.0707), abs=1e-3)


def test_log_times_never_go_back_and_frames_hang_together(store: RecordingStore) -> None:
    with store.new_part("mission-1") as writer:
        for tick in range(20):
            writer.write_robots(
                {"yard_1": said(tick / 10, 1.0), "store_1": said(tick / 10, 9.0)}, whole={"yard_1"}
            )
            holder = "yard_1" if tick < 10 else "bay_1"
            writer.write_samples({"sample_1": holder}, {"bay_1": (7.0, 3.0)}, tick / 10)
    with store.merged_file("mission-1") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        topics = ["/tf", "/poses/yard_1"]
        told = [(one.topic, entry, body) for _, one, entry, body in reader.iter_decoded_messages(topics)]
    assert {topic for topic, _, _ in told} == set(topics)
    for topic in topics:
        times = [entry.log_time for other, entry, _ in told if other == topic]
        assert times == sorted(times), topic
    frames = [one for topic, _, decoded in told if topic == "/tf" for one in decoded.transforms]
    for topic, entry, decoded in told:
        for one in decoded.transforms if topic == "/tf" else [decoded] if topic.startswith("/poses") else []:
            assert one.timestamp.ToNanoseconds() == pytest.approx(entry.log_time, abs=1000)
    assert {one.parent_frame_id for one in frames} <= {"world"} | {one.child_frame_id for one in frames}
    samples = [one for one in frames if one.child_frame_id == "sample_1"]
    assert (samples[0].parent_frame_id, samples[0].translation.x) == ("yard_1", pytest.approx(0.34))
    assert (samples[-1].parent_frame_id, samples[-1].translation.x) == ("world", 7.0)


def test_of_a_robot_that_has_no_part_only_its_moves_are_kept(store: RecordingStore) -> None:
    with store.new_part("mission-1") as writer:
        recording = MissionRecording("mission-1", writer, "store", robots=frozenset({"yard_1"}))
        for tick in range(50):
            at_s = tick / 10
            moves = at_s < 2.0
            heard = {"yard_1": said(at_s, 1.0), "store_1": said(at_s, at_s if moves else 2.0), "far": None}
            recording.write_robots({name: view(name, one) for name, one in heard.items()})
    replay = replay_of(store.entries("mission-1"))
    assert len(replay.robots["yard_1"]) == 25
    assert [row[0] for row in replay.robots["store_1"]] == [0.0, 1.0, 2.0]
    assert list(replay.telemetry) == ["yard_1"]
    assert [one["battery"] for one in replay.telemetry["yard_1"]] == [1.0] * 5


def view(name: str, telemetry: Telemetry | None) -> RobotView:
    return RobotView(name=name, world="store", telemetry=telemetry)


def test_a_recording_that_was_cut_off_ends_where_it_was_and_goes_on_in_another_part(
    store: RecordingStore,
) -> None:
    path = record(store, count=2000)
    whole = len(replay_of(store.entries("mission-1")).robots["yard_1"])
    assert whole == 1000
    os.truncate(path, path.stat().st_size // 2)
    kept = len(replay_of(store.entries("mission-1")).robots["yard_1"])
    assert 0.2 * whole < kept < 0.8 * whole
    record(store, from_s=300.0)
    replay = replay_of(store.entries("mission-1"))
    assert len(replay.robots["yard_1"]) == kept + 25
    with store.merged_file("mission-1") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_end_time == 305 * 10**9


def test_each_result_is_replayed_once_and_with_its_own_image(store: RecordingStore) -> None:
    """Also of two images that one camera took at the same time, as far as is known."""
    shared = {"robot": "yard_1", "name": "camera", "media_type": "image/png"}
    for _ in range(2):  # a process that was killed wrote the results, but not the events that tell of them
        with store.new_part("mission-1") as writer:
            writer.write_result({"id": "result-1", **shared}, b"first", 1.0)
            writer.write_result({"id": "result-2", **shared}, b"second", 1.0)
            writer.write_result({"id": "result-3", "robot": "yard_1", "name": "light_lx"}, None, 1.0)
    results = replay_of(store.entries("mission-1")).results
    assert [(one["id"], one.get("image")) for one in results] == [
        ("result-1", "data:image/png;base64,Zmlyc3Q="),
        ("result-2", "data:image/png;base64,c2Vjb25k"),
        ("result-3", None),
    ]


def test_recordings_are_measured_once_so_much_was_written_that_they_may_be_too_much(
    store: RecordingStore,
) -> None:
    assert store.is_measurement_due, "what an earlier process left"
    store.delete_oldest()
    assert not store.is_measurement_due
    with store.new_part("mission-1") as writer:
        while not store.is_measurement_due:
            writer.write_json(EVENTS, {"data": os.urandom(1000).hex()}, 0.0)
        written = writer.path.stat().st_size
    assert MB / 100 <= written < MB / 100 + 3 * CHUNK_BYTES


def test_ten_downloads_at_once_are_whole_and_leave_nothing_behind(store: RecordingStore) -> None:
    folder = record(store, count=500).parent
    kept = sorted(folder.parent.rglob("*"))
    together = Barrier(10)

    def download(_: int) -> int:
        together.wait()
        with store.merged_file("mission-1") as stream:
            summary = make_reader(stream).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        return summary.statistics.message_count

    with ThreadPoolExecutor(10) as pool:
        (count,) = set(pool.map(download, range(10)))
    assert count > 500
    assert sorted(folder.parent.rglob("*")) == kept


def test_a_download_goes_on_while_its_recording_is_deleted(store: RecordingStore) -> None:
    record(store)
    entries = store.entries("mission-1")
    with store.merged_file("mission-1") as stream:
        shutil.rmtree(record(store).parent)
        assert make_reader(stream).get_summary() is not None
    assert list(entries) == []


def test_the_oldest_recordings_give_way_but_not_those_that_are_made(store: RecordingStore) -> None:
    for number in range(4):
        path = record(store, f"mission-{number}", count=5)
        os.truncate(path, 400_000)
        os.utime(path, (number, number))
    assert store.delete_oldest(keep=frozenset({"mission-0"})) == ["mission-1"]
    assert [one.mission_id for one in store.recordings()] == ["mission-3", "mission-2", "mission-0"]


@pytest.mark.parametrize("name", ["mission-9", "..", "../..", "", "a/b", "*", "\0", "石" * 120])
def test_there_is_no_recording_of_what_was_not_recorded(store: RecordingStore, name: str) -> None:
    record(store)
    with pytest.raises(NotFound, match="no recording"):
        list(store.entries(name))


def test_a_mind_is_recorded_when_it_has_changed(store: RecordingStore) -> None:
    recording = MissionRecording("mission-1", store.new_part("mission-1"), "store")
    on_duty = ToldBelief(term="on_duty", value=True, origin="adopted", since_s=2.0)
    for at_s, beliefs in ((1.0, ()), (2.0, (on_duty,)), (3.0, (on_duty,)), (4.0, ())):
        report = MindReport(at_s=at_s, agents=(ToldAgent(name="guard", beliefs=beliefs),))
        recording.write_mind("yard_1", report)
    recording.writer.close()
    rows = replay_of(store.entries("mission-1")).minds["yard_1"]
    assert [row["at_s"] for row in rows] == [1.0, 2.0, 4.0]
    assert rows[1]["agents"][0]["beliefs"][0]["term"] == "on_duty"
