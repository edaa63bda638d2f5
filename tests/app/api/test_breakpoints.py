"""An operator stops a simulated world at a robot's rules, steps through it, and lets it go on."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.agents.running_world import RunningWorld
from app.cli import breakpoints as command
from app.composition import Service
from app.domain.errors import Invalid
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.clock import ManualClock
from robots.executive.breakpoints import Debugging, Halt, HeldFiring
from robots.world import WorldFile
from sim.process.debugger import Debugger
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam

BREAKPOINTS = "/v1/robots/yard_1/breakpoints"
GUARD = "AGENT guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"


class Minds:
    """Robots that meet their breakpoints while `fires`."""

    def __init__(self) -> None:
        self.rules: Mapping[str, frozenset[str]] = {}
        self.fires = False

    def break_at(self, rules: Mapping[str, frozenset[str]]) -> None:
        self.rules = rules

    def halts(self, robots: frozenset[str] = frozenset()) -> Sequence[Halt]:
        met = dict(self.rules) if self.fires else {}
        names = sorted({*met, *robots})
        return [Halt(robot=name, at_s=7.5, firings=fired(met.get(name, ())), agents=()) for name in names]


def fired(rules: Sequence[str] | frozenset[str]) -> Sequence[HeldFiring]:
    return [HeldFiring(agent="guard", rule=one, does="DOCK", bindings={"what": "rock"}) for one in rules]


class Simulation:
    """The team's clock with a debugger. Implements `app.agents.running_world.Debuggable`."""

    def __init__(self, team: FakeTeam) -> None:
        self._team = team
        self._minds = Minds()
        self._debugger = Debugger(self._minds, ManualClock())
        self.is_gone = False

    def now_s(self) -> float:
        return self._team.clock.now_s()

    def fire(self) -> None:
        self._minds.fires = True
        self._debugger.stepped()
        self._minds.fires = False

    def break_at(self, robot: str, rules: frozenset[str]) -> Debugging:
        self._debugger.break_at(robot, rules)
        return self.debugging()

    def go_on(self, *, one_cycle: bool) -> Debugging:
        if one_cycle:
            self._debugger.stand_again()
        else:
            self._debugger.go_on()
        return self.debugging()

    def debugging(self) -> Debugging:
        if self.is_gone:
            raise RuntimeError("its process is gone")
        return self._debugger.state()


@pytest.fixture
def simulation(team: FakeTeam) -> Simulation:
    return Simulation(team)


@pytest.fixture
def api(
    tmp_path: Path, world_file: WorldFile, team: FakeTeam, simulation: Simulation, worker: PlanningWorker
) -> Iterator[TestClient]:
    world = RunningWorld(file=world_file, link=team.link, clock=simulation, rate=None, run=team.run)
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None)
    with Service(settings, [world], worker=worker) as service, TestClient(service.api) as api:
        api.headers["authorization"] = f"Bearer {TOKEN}"
        api.put("/v1/robots/yard_1/rules", json={"files": {"guard": GUARD}})
        yield api


def put(api: TestClient, *rules: str) -> dict[str, Any]:
    answer = api.put(BREAKPOINTS, json={"rules": rules})
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


def test_the_world_stands_where_a_rule_fires_is_stepped_and_goes_on(
    api: TestClient, simulation: Simulation
) -> None:
    known = put(api, "guard:2")
    assert (known["rules"], known["halts"], known["left_s"]) == (["guard:2"], [], None)
    simulation.fire()
    other = api.get("/v1/robots/store_1/breakpoints").json()
    assert (other["rules"], other["of_others"]) == ([], 1)
    (halt,) = other["halts"]
    assert (halt["robot"], halt["at_s"], other["left_s"]) == ("yard_1", 7.5, 600.0)
    (firing,) = halt["firings"]
    assert firing == {"agent": "guard", "rule": "guard:2", "does": "DOCK", "bindings": {"what": "rock"}}
    (halt,) = api.post(f"{BREAKPOINTS}:step").json()["halts"]
    assert (halt["robot"], halt["firings"]) == ("yard_1", [])
    assert api.post(f"{BREAKPOINTS}:continue").json()["halts"] == []
    again = api.post(f"{BREAKPOINTS}:continue")
    assert (again.status_code, again.json()["detail"]) == (
        409,
        "sample_store does not stand at a breakpoint",
    )
    simulation.fire()
    assert put(api)["halts"] == [], "a world without breakpoints goes on"


def test_robots_of_a_world_that_stands_are_said_to_stand_and_not_to_be_offline(
    api: TestClient, simulation: Simulation
) -> None:
    def seen() -> tuple[str, bool]:
        robot = api.get("/v1/robots/store_1").json()
        return robot["connection"], robot["world_stands"]

    put(api, "guard:2")
    assert seen() == ("offline", False), "it has told nothing yet"
    simulation.fire()
    assert seen() == ("online", True)
    for what in ("mind", "trace"):
        mute = api.get(f"/v1/robots/store_1/{what}")
        assert (mute.status_code, mute.json()["type"].rpartition(":")[2]) == (409, "world-stands")
        assert "store_1 answers nothing until it goes on" in mute.json()["detail"]
    simulation.is_gone = True
    assert seen() == ("offline", False), "nobody knows where it stands"
    simulation.is_gone = False
    api.post(f"{BREAKPOINTS}:continue").raise_for_status()
    assert seen() == ("offline", False)


def test_a_breakpoint_where_no_rule_begins_is_refused_with_where_they_do(api: TestClient) -> None:
    answer = api.put(BREAKPOINTS, json={"rules": ["guard:3"]})
    assert answer.status_code == 422
    assert "no rule of yard_1 begins at guard:3; its rules begin at guard:2" in answer.json()["detail"]


def test_a_simulation_that_has_gone_is_said_to_be_away(api: TestClient, simulation: Simulation) -> None:
    simulation.is_gone = True
    answer = api.get(BREAKPOINTS)
    assert answer.status_code == 503
    assert "does not answer: its process is gone" in answer.json()["detail"]


def test_the_command_line_says_where_the_world_stands(api: TestClient, simulation: Simulation) -> None:
    assert command.set_breakpoints(api, "yard_1", []) == "yard_1 has no breakpoints\nsample_store runs"
    command.set_breakpoints(api, "yard_1", ["guard:2"])
    simulation.fire()
    stands = command.set_breakpoints(api, "yard_1", [])
    assert "yard_1 stands at 7.50 s" in stands
    assert "guard: guard:2 fires: DOCK, ?what = rock" in stands
    assert "sample_store goes on by itself in 600 s" in stands
    assert command.go_on(api, "yard_1", one_cycle=False).endswith("sample_store runs")
    with pytest.raises(Invalid, match="does not stand at a breakpoint"):
        command.go_on(api, "yard_1", one_cycle=True)
    assert command.set_breakpoints(api, "yard_1", [], clear=True).startswith("yard_1 has no breakpoints")


def test_a_world_that_no_simulation_of_the_service_runs_is_refused_with_the_reason(
    tmp_path: Path, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> None:
    """Beside it, one in which a robot has software of its own: its clock must not stand."""
    document = world_file.model_dump(mode="json")
    document["robots"][1]["external"] = True
    for file, reason in (
        (world_file, "no simulation of sample_store runs in this process"),
        (WorldFile.model_validate(document), "software of their own (yard_2)"),
    ):
        world = RunningWorld(file=file, link=team.link, clock=team.clock, rate=None, run=team.run)
        settings = Settings(data=tmp_path / reason[:8], token=TOKEN, database_url=None)
        with Service(settings, [world], worker=worker) as service, TestClient(service.api) as api:
            api.headers["authorization"] = f"Bearer {TOKEN}"
            assert reason in api.get(BREAKPOINTS).json()["refusal"]
            refused = api.put(BREAKPOINTS, json={"rules": []})
            assert refused.status_code == 409
            assert reason in refused.json()["detail"]
