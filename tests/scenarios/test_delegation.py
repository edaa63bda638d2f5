"""The uplink is down for the whole mission and a robot cannot do its part: another one does it (MACTA §4, SC00029)."""

from pathlib import Path

from app.domain.lifecycles.mission import MissionState
from app.planning.pool.pool import PlanningWorker
from benchmarks.delegation import with_jammed_jaws
from benchmarks.radio import Ended, carry_out
from robots.wire import Message, PacketReport, Telemetry
from robots.world import LinkSpec, WorldFile, load_world

CUT_S = 180.0
DECIDED_S = 260.0
"""By then the service has heard of the failure, has tried again, and waits for an operator's decision."""


class UplinkDown:
    """The worst instant for each robot: it has begun its script, or the others have theirs and it has none."""

    def __init__(self) -> None:
        self._at_work: set[str] = set()

    def __call__(self, message: Message) -> bool:
        if isinstance(message.body, PacketReport):
            self._at_work.add(message.sender)
            return True
        return isinstance(message.body, Telemetry) and len(self._at_work - {message.sender}) == 2


def store() -> WorldFile:
    return with_jammed_jaws(load_world("sample_store").model_copy(update={"peer_link": LinkSpec()}), "yard_1")


def ended(worker: PlanningWorker, folder: Path, *, delegate: bool, limit_s: float = 400.0) -> Ended:
    return carry_out(
        store(),
        worker,
        folder,
        worst=UplinkDown(),
        out_s=CUT_S,
        delegate=delegate,
        limit_s=limit_s,
    )


def test_an_idle_robot_does_the_leg_and_the_service_learns_it_on_contact(
    worker: PlanningWorker, tmp_path: Path
) -> None:
    mission = ended(worker, tmp_path, delegate=True)
    assert (mission.state, mission.came_true, mission.twice) == (MissionState.COMPLETED, True, []), mission
    facts = set(mission.facts)
    assert {"in(sample_1, bay_7)", "near(yard_1, home_yard_1)", "near(yard_2, home_yard_2)"} <= facts
    assert {f"robot_attribute({name}, gripper, empty)" for name in ("yard_1", "yard_2", "store_2")} <= facts
    assert "vacant(door_1)" in facts
    told = [
        (one["type"], one["robot"], one["to"]) for one in mission.events if one["type"].startswith("leg.")
    ]
    assert told == [("leg.awarded", "yard_1", "yard_2"), ("leg.done", "yard_1", "yard_2")]
    assert set(mission.done_by.values()) == {"yard_2"}
    assert len(mission.done_by) == 3, "yard_1 has driven to the door itself"
    assert not any(one["type"] == "mission.reports_contradict" for one in mission.events)


def test_without_the_grant_the_mission_fails_as_before(worker: PlanningWorker, tmp_path: Path) -> None:
    mission = ended(worker, tmp_path, delegate=False, limit_s=DECIDED_S)
    assert not mission.came_true
    assert mission.state is not MissionState.COMPLETED
    assert not any(one["type"].startswith("leg.") for one in mission.events)
