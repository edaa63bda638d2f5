"""What the service believes of legs that robots in the field have put to each other, and what it shows of them."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import select

from app.agents.agent_models import Reception
from app.api.mission_bodies import MissionBody
from app.domain.world_model.vocabulary import symbolic_all
from app.planning.waiting_goals import WaitingGoals
from app.store import EventRow, MissionRow
from app.store.migrate import migrate
from robots.clock import ManualClock
from robots.wire import (
    DelegationBid,
    DelegationReport,
    DelegationState,
    PacketState,
    ScriptReport,
    ScriptState,
    UpkeepReport,
)
from robots.world import LinkSpec, load_world
from tests.app.missions.mission_services import WORLD, MissionServices, at_home, services
from tests.app.missions.test_reports import Mission
from tests.app.sample_store import Store

STORE = Store(load_world("sample_store").model_copy(update={"peer_link": LinkSpec()}))
BIDS = (DelegationBid(robot="yard_2", cost_s=42.0),)


class Delegated(Mission):
    """yard_1 has driven to the door, cannot take the sample and is not heard any more."""

    def __init__(self, made: MissionServices, clock: ManualClock, *, delegate: bool = True) -> None:
        self.services = made
        self.clock = clock
        self.services.start_world()
        _, self.id = self.services.plans.approve(self.services.plan(), actor="operator", delegate=delegate)
        self.services.life.monitor(self.id)
        self.agree()
        self.report("yard_1", 0, PacketState.RUNNING, 1.0)
        self.report("yard_1", 0, PacketState.FINISHED, 6.0)
        self.report("yard_1", 1, PacketState.RUNNING, 7.0)
        self.report("yard_1", 1, PacketState.RETRIABLE, 37.0)

    def tells(self, state: DelegationState, at_s: float, robot: str = "yard_2") -> bool:
        script = self.script("yard_1")
        leg = next(iter(script.body["delegable"]), {"id": "leg"})
        report = DelegationReport(
            script_id=script.id,
            leg=leg["id"],
            state=state,
            at_s=at_s,
            robot=robot,
            bids=BIDS,
            expected_s=42.0,
            stands=f"home_{robot}",
            aside="home_yard_1",
        )
        return self.services.record(self.message(script, report))

    def ends(
        self, robot: str, at_s: float, state: ScriptState = ScriptState.FINISHED, **done_by: str
    ) -> None:
        script = self.script(robot)
        report = ScriptReport(script_id=script.id, state=state, at_s=at_s, done_by=done_by)
        assert self.services.record(self.message(script, report))

    def stores(self, from_s: float) -> None:
        """store_2 takes the sample from the interchange and stores it."""
        begins_s = (1.0, from_s, from_s + 3.0, from_s + 13.0)
        ends_s = (9.0, from_s + 3.0, from_s + 13.0, from_s + 18.0)
        for packet, (begun_s, ended_s) in enumerate(zip(begins_s, ends_s, strict=True)):
            self.report("store_2", packet, PacketState.RUNNING, begun_s)
            self.report("store_2", packet, PacketState.FINISHED, ended_s)
        self.ends("store_2", from_s + 18.0)

    @property
    def facts(self) -> set[str]:
        with self.services.database.read() as session:
            facts = self.services.core.facts.facts(session, "sample_store")
        return set(map(str, symbolic_all(facts, STORE.base)))

    @property
    def events(self) -> list[tuple[str, str, str]]:
        with self.services.database.read() as session:
            rows = session.scalars(
                select(EventRow).where(EventRow.type.startswith("leg.")).order_by(EventRow.seq)
            )
            return [(row.type, row.data["robot"], row.data["to"]) for row in rows]

    @property
    def done_by(self) -> dict[str, str | None]:
        """As the mission's view shows it."""
        with self.services.database.read() as session:
            row = session.get_one(MissionRow, self.id)
            body = MissionBody.of(row, list(self.services.scripts(self.id)))
        (progress,) = (one for one in body.progress if one.robot == "yard_1")
        return {packet.tag: packet.delegated_to for packet in progress.packets}


@pytest.fixture
def mission(tmp_path: Path) -> Iterator[Delegated]:
    yield from made(tmp_path, delegate=True)


@pytest.fixture
def plain(tmp_path: Path) -> Iterator[Delegated]:
    """Nothing is granted."""
    yield from made(tmp_path, delegate=False)


def made(folder: Path, *, delegate: bool) -> Iterator[Delegated]:
    clock = ManualClock()
    found = services(folder, store=STORE, clock=clock)
    migrate(found.database)
    yield Delegated(found, clock, delegate=delegate)
    found.close()


def test_what_another_robot_has_done_has_its_effects_and_is_shown(mission: Delegated) -> None:
    assert mission.tells(DelegationState.AWARDED, 46.0)
    assert set(mission.done_by.values()) == {None, "yard_2"}
    assert "in(sample_1, door_1)" in mission.facts
    assert mission.tells(DelegationState.DONE, 91.0)
    assert mission.facts >= {
        "in(sample_1, interchange_2)",
        "vacant(door_1)",
        "near(yard_1, home_yard_1)",
        "near(yard_2, home_yard_2)",
        "clear(interchange_2, yard)",
        "robot_attribute(yard_1, gripper, empty)",
        "robot_attribute(yard_2, gripper, empty)",
    }
    mission.ends("yard_1", 91.0)
    mission.stores(84.0)
    mission.services.life.monitor(mission.id)
    found = mission.services.mission(mission.id)
    assert (found.state, found.contradictions) == ("completed", []), found.reason
    assert "in(sample_1, bay_7)" in mission.facts
    assert mission.done_by == {
        "NAVIGATE": None,
        "DOCK": "yard_2",
        "TRANSPORT": "yard_2",
        "RELEASE2": "yard_2",
    }
    assert mission.events == [("leg.awarded", "yard_1", "yard_2"), ("leg.done", "yard_1", "yard_2")]


def test_reports_of_the_others_may_come_first(mission: Delegated) -> None:
    home = UpkeepReport(
        tag="SEEK_CHARGER", state=PacketState.FINISHED, at_s=90.5, perceived=at_home("yard_2")
    )
    message = mission.message(mission.script("yard_1"), home)
    assert mission.services.record(message.model_copy(update={"sender": "yard_2"}))
    mission.stores(84.0)
    done_by = {packet["id"]: "yard_2" for packet in mission.script("yard_1").body["packets"][1:]}
    mission.ends("yard_1", 91.0, **done_by)
    assert "in(sample_1, bay_7)" in mission.facts
    assert mission.done_by["RELEASE2"] == "yard_2"
    assert mission.tells(DelegationState.DONE, 91.0)
    assert mission.tells(DelegationState.AWARDED, 46.0)
    assert mission.facts >= {"in(sample_1, bay_7)", "near(yard_1, home_yard_1)", "near(yard_2, home_yard_2)"}
    mission.services.life.monitor(mission.id)
    found = mission.services.mission(mission.id)
    assert (found.state, found.contradictions) == ("completed", []), found.reason


def test_what_another_has_done_of_a_script_that_then_fails_has_its_effects(mission: Delegated) -> None:
    done_by = {packet["id"]: "yard_2" for packet in mission.script("yard_1").body["packets"][1:]}
    mission.ends("yard_1", 95.0, ScriptState.FAILED, **done_by)
    assert mission.facts >= {"in(sample_1, interchange_2)", "vacant(door_1)"}
    assert mission.tells(DelegationState.DONE, 91.0), "sent before, it arrives later"
    assert mission.facts >= {"in(sample_1, interchange_2)", "near(yard_2, home_yard_2)"}


def test_the_monitor_waits_for_the_other_robot(mission: Delegated) -> None:
    before = mission.services.mission(mission.id).enquire_at_s
    assert before is not None
    assert mission.tells(DelegationState.AWARDED, 60.0)
    after = mission.services.mission(mission.id).enquire_at_s
    assert after is not None
    assert after >= max(before, 60.0 + 42.0)


@pytest.mark.parametrize("state", [DelegationState.FAILED, DelegationState.UNHEARD])
def test_a_leg_that_the_other_could_not_do_is_nobodys(mission: Delegated, state: DelegationState) -> None:
    assert mission.tells(DelegationState.AWARDED, 46.0)
    assert mission.tells(state, 91.0)
    assert set(mission.done_by.values()) == {None}
    assert "in(sample_1, door_1)" in mission.facts


def test_a_robot_that_the_script_does_not_name_is_not_believed_to_have_done_it(mission: Delegated) -> None:
    before = mission.facts
    mission.tells(DelegationState.DONE, 91.0, robot="store_1")
    mission.tells(DelegationState.DONE, 92.0, robot="")
    assert mission.facts == before, "nor where that one stands"
    assert mission.events == []


def test_nothing_is_believed_that_was_not_granted(plain: Delegated) -> None:
    before = plain.facts
    plain.tells(DelegationState.DONE, 91.0)
    assert plain.facts == before
    assert plain.events == []
    assert set(plain.done_by.values()) == {None}


def test_a_report_from_the_future_is_held_back(mission: Delegated) -> None:
    now_s = mission.clock.now_s()
    report = DelegationReport(
        script_id=mission.script("yard_1").id,
        leg=mission.script("yard_1").body["delegable"][0]["id"],
        state=DelegationState.DONE,
        at_s=now_s + 3600.0,
        robot="yard_2",
    )
    message = mission.message(mission.script("yard_1"), report)
    assert mission.services.reports.record(message, WORLD) is Reception.HELD_BACK
    assert "in(sample_1, door_1)" in mission.facts


@pytest.mark.parametrize(
    ("first", "late"),
    [
        ((DelegationState.NOT_TAKEN, 92.0, ""), (DelegationState.AWARDED, 46.0, "yard_2")),
        ((DelegationState.UNHEARD, 92.0, "yard_2"), (DelegationState.AWARDED, 46.0, "yard_2")),
    ],
)
def test_a_late_award_does_not_take_back_what_has_come_of_it(
    mission: Delegated,
    first: tuple[DelegationState, float, str],
    late: tuple[DelegationState, float, str],
) -> None:
    assert mission.tells(*first)
    assert mission.tells(*late)
    assert set(mission.done_by.values()) == {None}
    assert len(mission.events) == 2, "both are shown"


def test_a_late_failure_does_not_take_back_the_next_award(mission: Delegated) -> None:
    assert mission.tells(DelegationState.AWARDED, 92.0)
    assert mission.tells(DelegationState.FAILED, 91.0)
    assert "yard_2" in mission.done_by.values()


def test_the_end_of_a_leg_releases_goals_that_wait_for_what_it_needed(
    mission: Delegated, monkeypatch: pytest.MonkeyPatch
) -> None:
    released: list[str] = []
    monkeypatch.setattr(WaitingGoals, "release", lambda _, __, world: released.append(world))
    assert mission.tells(DelegationState.DONE, 91.0)
    assert released == [WORLD]


def test_the_grant_is_recorded_with_the_approval_and_the_mission(mission: Delegated) -> None:
    with mission.services.database.read() as session:
        assert session.get_one(MissionRow, mission.id).delegate
        approved = session.scalars(select(EventRow).where(EventRow.type == "plan.approved")).one()
        assert approved.data["delegate"] is True
