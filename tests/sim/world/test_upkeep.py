"""A rover whose battery is low drives home by itself, is charged there, and takes a script again."""

import pytest

from robots.repertoire import load_repertoire, load_self_level
from robots.wire import BehaviourScript, Message, Performative, ScriptRequest, Telemetry, UpkeepReport
from robots.world import WorldFile, load_world
from robots.world.rule_files import shipped_rules
from sim.bodies.battery import CHARGE_BELOW, CHARGED
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.robots.stories import packet, script


def store(battery: float, body: str = "velocity", *rules: str) -> WorldFile:
    """The sample store with yard_1 alone, that begins by door_2, far from home."""
    data = load_world("sample_store").model_dump(mode="json")
    yard_1 = next(robot for robot in data["robots"] if robot["name"] == "yard_1")
    files = shipped_rules()
    texts = {name: files[name].read_text(encoding="utf-8") for name in rules}
    yard_1.update(start=[5.0, 1.0, 0.0], battery=battery, body=body, rules=texts)
    data["robots"] = [yard_1]
    return WorldFile.model_validate(data)


class Operator:
    """The service's end of a simulation's link, for yard_1."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.heard: list[Message] = []

    def order(self, order: BehaviourScript) -> Message:
        message = Message(
            performative=Performative.REQUEST,
            sender="service",
            receiver="yard_1",
            sent_at_s=self.simulation.clock.now_s(),
            body=ScriptRequest(script=order),
        )
        self.simulation.link.send(message)
        return message

    def listen(self) -> list[Message]:
        self.heard += [one for one in self.simulation.link.receive() if one.sender == "yard_1"]
        return self.heard

    def telemetry(self) -> Telemetry:
        return next(one.body for one in reversed(self.listen()) if isinstance(one.body, Telemetry))

    def answer(self, request: Message) -> Performative | None:
        return next((one.performative for one in self.listen() if one.in_reply_to == request.id), None)

    def upkeep(self) -> list[str]:
        reports = {one.id: one.body for one in self.listen() if isinstance(one.body, UpkeepReport)}
        return [f"{one.tag} {one.state}" for one in reports.values()]


def test_the_levels_fit_the_charger() -> None:
    levels = load_self_level()
    assert levels.low <= CHARGE_BELOW
    assert load_repertoire().specs["CHARGE"].defaults()["to"] < CHARGED


@pytest.mark.parametrize(
    ("body", "rules"), [("velocity", []), ("wheeled", []), ("avatar", []), ("velocity", ["charging"])]
)
def test_a_weak_rover_refuses_drives_home_charges_and_then_takes_the_script(
    body: str, rules: list[str]
) -> None:
    simulation = Simulation(store(0.199, body, *rules), make_agent=behavioural_agent, seed=3)
    operator = Operator(simulation)
    order = script("yard_1", packet("NAVIGATE", ref2="door_2"))
    refused = operator.order(order)
    assert simulation.run_until(lambda: "CHARGE running" in operator.upkeep(), timeout_s=90)
    assert operator.answer(refused) is Performative.REFUSE
    assert simulation.run_until(lambda: operator.telemetry().battery > 0.2, timeout_s=60)
    assert operator.telemetry().charging
    accepted = operator.order(order.model_copy(update={"id": "another"}))
    assert simulation.run_until(lambda: not operator.telemetry().charging, timeout_s=5)
    assert operator.answer(accepted) is Performative.AGREE
    assert operator.telemetry().packet_tag == "NAVIGATE"


def test_a_rover_with_an_empty_battery_stands_still_and_says_so() -> None:
    simulation = Simulation(store(0.0), make_agent=behavioural_agent, seed=3)
    operator = Operator(simulation)
    before = simulation.truth().robots["yard_1"]
    simulation.run_until(lambda: False, timeout_s=10)
    after = simulation.truth().robots["yard_1"]
    assert (after.x_m, after.y_m) == (before.x_m, before.y_m)
    assert operator.telemetry().battery == 0.0
    assert operator.telemetry().packet_tag == "SEEK_CHARGER"


@pytest.mark.parametrize("start", [(5.0, 1.0, 0.0), (0.8, 1.8, 90.0)])
def test_a_rover_recharges_as_its_script_says_and_then_goes_on(start: tuple[float, float, float]) -> None:
    """From afar, and from where it is believed to be near its charger but is not in its reach."""
    data = store(0.4).model_dump(mode="json")
    data["robots"][0].update(start=start, battery_wh=2.0)
    simulation = Simulation(WorldFile.model_validate(data), make_agent=behavioural_agent, seed=3)
    operator = Operator(simulation)
    charge = packet("RECHARGE", robot="yard_1", rel="near", ref="home_yard_1", to="0.600")
    order = script("yard_1", charge, packet("NAVIGATE", ref2="door_2"))
    accepted = operator.order(order)

    def tag() -> str | None:
        telemetry = [one.body for one in operator.listen() if isinstance(one.body, Telemetry)]
        return telemetry[-1].packet_tag if telemetry else None

    assert simulation.run_until(lambda: tag() == "NAVIGATE", timeout_s=120)
    assert operator.answer(accepted) is Performative.AGREE
    assert 0.58 < operator.telemetry().battery < 0.62
    assert simulation.truth().batteries["yard_1"] == pytest.approx(operator.telemetry().battery, abs=0.01)


def test_a_rover_at_its_charger_is_charged_without_being_asked() -> None:
    data = store(0.5).model_dump(mode="json")
    data["robots"][0].update(start=(0.6 + 0.7, 1.8, 180.0))
    simulation = Simulation(WorldFile.model_validate(data), make_agent=behavioural_agent, seed=3)
    simulation.run_until(lambda: False, timeout_s=5)
    assert simulation.truth().batteries["yard_1"] > 0.5


def test_a_charger_charges_one_rover_at_a_time_and_the_next_once_it_is_left() -> None:
    """Two stand in its reach; it goes on with the one that it has begun with, whoever is named first."""
    data = load_world("sample_store").model_dump(mode="json")
    shared = {
        "name": "charger_1",
        "kind": "charger",
        "at": [4.0, 1.8],
        "approach_deg": [0, 180],
        "capacity": 0,
    }
    data["locations"].append(shared)
    pair = [robot for robot in data["robots"] if robot["compartment"] == "yard"]
    for robot, x_m in zip(pair, (3.3, 4.7), strict=True):
        robot.update(start=(x_m, 1.8, 180.0), home=None, battery=0.5, battery_wh=2.0)
    data["robots"] = pair
    simulation = Simulation(
        WorldFile.model_validate(data), make_agent=behavioural_agent, seed=3, jitter_m=0.0
    )

    def charging() -> list[str]:
        return [name for name, body in simulation.bodies.items() if body.battery.charging]

    simulation.run_until(lambda: False, timeout_s=5)
    assert charging() == ["yard_1"]
    batteries = simulation.truth().batteries
    assert batteries["yard_1"] > 0.5 > batteries["yard_2"]
    operator = Operator(simulation)
    operator.order(script("yard_1", packet("NAVIGATE", ref2="door_1")))
    assert simulation.run_until(lambda: charging() == ["yard_2"], timeout_s=10)
    simulation.bodies["yard_1"].battery.left_j /= 2
    operator.order(script("yard_1", packet("RECHARGE", robot="yard_1", rel="near", ref="charger_1")))
    simulation.run_until(lambda: False, timeout_s=20)
    assert charging() == ["yard_2"]
