"""A mind leaves the simulation for the robot's own program, and comes back: nothing is lost or done twice, whichever of
the two is killed at whichever step.
"""

from collections import Counter

import pytest

from benchmarks.embodiments import REAL, MovingRunner, run
from benchmarks.real_robot import RealRobot
from robots.executive.hand_over import Pieces, pieces_of
from robots.wire import (
    Message,
    MindOrder,
    MindOrderReport,
    MindTransfer,
    MindTransferReport,
    MindVerb,
    PacketState,
    Performative,
    Program,
    RuleSet,
    ScriptState,
)
from robots.world import load_world
from sim.world.agent import HasRules
from tests.sim.world.test_changed_world import to_the_door

FILE = load_world("sample_store")
ROBOT = "yard_1"
STEPS = ("asked", "at rest", "transfer asked", "taken", "exchanged", "going on asked", "gone on")
BACK = ("asked", "at rest", "exchanged", "going on asked", "gone on")
"""The document comes into the simulation with the edition."""


class Crossing:
    """yard_1 is on its way to a door; the test is the service, and kills a program at a step."""

    def __init__(self) -> None:
        self.runner = MovingRunner(FILE, seed=3, real=[ROBOT])
        self._killed = ""
        self._who = ""
        self._fence = 0

    def begin(self, place: str = "door_1") -> None:
        self.runner.send([to_the_door(ROBOT, place)])
        self.run(1.0)

    def kill(self, who: str, *, at: str) -> None:
        """Kill one of the two programs at this step of the next move."""
        self._who = who
        self._killed = at

    @property
    def real(self) -> RealRobot:
        return self.runner.reals[ROBOT]

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 20)):
            self.runner.step()

    def move(self, kind: str) -> None:
        """Move the mind, as the service does."""
        self._fence += 1
        goes_out = kind == REAL
        there, here = (Program.OWN, Program.WORLD) if goes_out else (Program.WORLD, Program.OWN)
        text = self.rest(here)
        self._step("at rest")
        if goes_out:
            self.runner.bring(ROBOT)
            for piece in pieces_of(text):
                order = MindTransfer(fence=self._fence, mind=piece)
                assert self.ask("transfer", order, killed="transfer asked").reason == ""
            self._step("taken")
        self.runner.exchange(ROBOT, kind, {} if goes_out else {ROBOT: text})
        self._step("exchanged")
        order = MindOrder(verb=MindVerb.GO_ON, fence=self._fence, to=there)
        assert self.ask("go_on", order, killed="going on asked").reason == ""
        self._step("gone on")

    def rest(self, here: Program, *, fence: int | None = None) -> str:
        """The document of the mind, which rests."""
        self._fence = fence or self._fence
        pieces = Pieces()
        while True:
            order = MindOrder(verb=MindVerb.REST, fence=self._fence, to=here, piece=0)
            answer = self.ask("rest", order, killed="asked")
            assert isinstance(answer, MindOrderReport)
            assert answer.reason == ""
            assert answer.mind is not None
            if (text := pieces.put(answer.mind)) is not None:
                return text

    def ask(
        self, step: str, order: MindOrder | MindTransfer, *, killed: str = ""
    ) -> MindOrderReport | MindTransferReport:
        for _ in range(10):
            self.runner.tell(ROBOT, Performative.REQUEST, order)
            self.runner.step()
            self._step(killed)
            for _ in range(20):
                self.runner.step()
                if (answer := self.runner.answers.pop((ROBOT, step, self._fence), None)) is not None:
                    return answer
        raise AssertionError(f"{step} is not answered")

    def _step(self, name: str) -> None:
        if self._killed != name:
            return
        self._killed = ""
        if self._who == "world":
            self.runner.restart()
        else:
            self.real.kill()

    def finish(self) -> None:
        """The script comes to its end, with each report once."""
        for _ in range(60 * 20):
            self.runner.step()
            if self.runner.ended:
                break
        (ended,) = self.runner.ended.values()
        assert ended.state is ScriptState.FINISHED, ended
        states = Counter(report.state for report in self.runner.reports)
        assert (states[PacketState.FINISHED], states[PacketState.FAILED]) == (1, 0)
        assert self.runner.refused == {}


@pytest.mark.parametrize("who", ["world", "robot"])
@pytest.mark.parametrize("killed", STEPS)
def test_the_script_comes_to_its_end_once_in_the_real_body_whoever_is_killed(killed: str, who: str) -> None:
    crossing = Crossing()
    with crossing.runner:
        crossing.begin()
        crossing.kill(who, at=killed)
        crossing.move(REAL)
        assert crossing.runner.kind_of(ROBOT) == REAL
        crossing.finish()


@pytest.mark.parametrize("who", ["world", "robot"])
@pytest.mark.parametrize("killed", BACK)
def test_the_script_comes_to_its_end_once_back_in_the_simulation_whoever_is_killed(
    killed: str, who: str
) -> None:
    crossing = Crossing()
    with crossing.runner:
        crossing.begin()
        crossing.move(REAL)
        crossing.run(0.5)
        crossing.kill(who, at=killed)
        crossing.move("wheeled")
        assert crossing.runner.kind_of(ROBOT) == "wheeled"
        crossing.finish()


CLERK = """AGENT clerk;
ACTUATOR activate;
BELIEF(startup) => COMMIT(adoptBelief(begun));
BELIEF(begun) => COMMIT(SEQ(DELAY(4), adoptBelief(done)));
BELIEF(done) => COMMIT(retractBelief(begun));
"""


@pytest.mark.parametrize(
    ("killed", "who"), [("", ""), ("at rest", "world"), ("taken", "robot"), ("exchanged", "robot")]
)
def test_beliefs_and_commitments_go_on_where_they_were(killed: str, who: str) -> None:
    crossing = Crossing()
    with crossing.runner:
        crossing.runner.tell(ROBOT, Performative.REQUEST, RuleSet(version=3, files={"clerk": CLERK}))
        crossing.run(2.0)
        crossing.kill(who, at=killed)
        crossing.move(REAL)
        crossing.run(0.1)
        assert minds_eye(crossing) == ({"begun"}, ["active"], 2)
        crossing.run(2.0)
        assert minds_eye(crossing) == ({"done"}, [], 3), "what has passed of the delay counts"


def minds_eye(crossing: Crossing) -> tuple[set[str], list[str], int]:
    """What the agent in the real robot has adopted as beliefs, its commitments' states, and how many it has made."""
    (agent,) = crossing.real.program.agent.halt_report().agents
    rules = crossing.real.program.agent.hand_over().mind.rules
    assert rules is not None
    assert rules.agents is not None
    assert rules.version == 3
    adopted = {one.term for one in agent.beliefs if one.origin == "adopted"}
    live = [one.state for one in agent.commitments if one.ended_s is None]
    return adopted, live, rules.agents["clerk"].count


TURNER = """AGENT turner;
ACTUATOR activate;
BELIEF(packet(NAVIGATE, running)) => COMMIT(SEQ(activate(TURN_LEFT()), adoptBelief(turned)));
"""


def test_the_other_robots_go_on_with_their_commitments_when_one_leaves_the_simulation() -> None:
    crossing = Crossing()
    with crossing.runner:
        for rules, name in ((CLERK, "clerk"), (TURNER, "turner")):
            robot = "yard_2" if name == "clerk" else ROBOT
            crossing.runner.tell(robot, Performative.REQUEST, RuleSet(version=3, files={name: rules}))
        crossing.run(2.0)
        crossing.runner.send([to_the_door(ROBOT)])
        crossing.run(0.5)
        before = told(crossing, ROBOT), told(crossing, "yard_2")
        assert before == (([], ["active"]), (["begun"], ["active"]))
        crossing.runner.exchange("store_2", REAL, {})
        crossing.run(0.1)
        assert (told(crossing, ROBOT), told(crossing, "yard_2")) == before
        crossing.run(2.0)
        assert told(crossing, "yard_2") == (["done"], []), "what has passed of the delay counts"
        crossing.finish()
        assert told(crossing, ROBOT) == (["turned"], [])
        remarks = [one.detail for one in crossing.runner.reports if one.state is PacketState.RUNNING]
        stood, went_on = [one for one in remarks if "TURN_LEFT" in one]
        assert stood == "NAVIGATE stands for TURN_LEFT of turner:3"
        assert went_on.startswith("NAVIGATE goes on, TURN_LEFT has finished")


def told(crossing: Crossing, robot: str) -> tuple[list[str], list[str]]:
    """What a simulated robot's agent has adopted as beliefs, and the states of its commitments."""
    agent = crossing.runner.simulation.agents[robot]
    assert isinstance(agent, HasRules)
    (one,) = agent.halt_report().agents
    adopted = [belief.term for belief in one.beliefs if belief.origin == "adopted"]
    return adopted, [made.state for made in one.commitments if made.ended_s is None]


def test_only_the_program_that_has_the_mind_speaks_and_acts() -> None:
    crossing = Crossing()
    with crossing.runner:
        crossing.begin()
        said = [crossing.real.tick({}, {}) for _ in range(40)]
        assert said == [[]] * 40
        crossing.move(REAL)
        stood = crossing.real.body.at
        crossing.run(1.0)
        assert abs(crossing.real.body.at - stood) > 0.1
        late = MindOrder(verb=MindVerb.GO_ON, fence=1, to=Program.WORLD)
        crossing.move("velocity")
        stood = crossing.real.body.at
        crossing.runner.tell(ROBOT, Performative.REQUEST, late.model_copy(update={"to": Program.OWN}))
        crossing.run(1.0)
        assert crossing.real.body.at == stood
        answer = crossing.runner.answers[ROBOT, "go_on", 1]
        assert answer.reason == "fencing number 1 is over, 2 is in force"
        crossing.finish()


def test_a_mind_that_returns_goes_on_in_the_program_that_it_was_in() -> None:
    crossing = Crossing()
    with crossing.runner:
        crossing.begin("door_2")
        crossing.run(4.0)
        text = crossing.rest(Program.WORLD, fence=1)
        before = crossing.runner.simulation.truth().robots[ROBOT]
        crossing.run(2.0)
        after = crossing.runner.simulation.truth().robots[ROBOT]
        assert abs(complex(after.x_m - before.x_m, after.y_m - before.y_m)) < 0.001
        far = crossing.ask("transfer", MindTransfer(fence=1, mind=pieces_of(text)[0]))
        assert "yard_1 stands" in far.reason
        assert "where script yard_1-script has come to; drive it there first" in far.reason
        order = MindOrder(verb=MindVerb.GO_ON, fence=1, to=Program.WORLD)
        assert crossing.ask("go_on", order).reason == ""
        crossing.finish()


def test_a_program_takes_no_mind_that_it_cannot_carry_on() -> None:
    crossing = Crossing()
    with crossing.runner:
        crossing.begin()
        text = crossing.rest(Program.WORLD, fence=1)
        crossing.runner.bring(ROBOT)

        def reason(changed: str) -> str:
            report = MindTransferReport(fence=1, digest="", number=0)
            for piece in pieces_of(changed, size=4000):
                report = crossing.ask("transfer", MindTransfer(fence=1, mind=piece))  # type: ignore[assignment]
            return report.reason

        other = text.replace('"version":1', '"version":2')
        assert reason(other) == "the mind's document is of version 2; this program takes version 1"
        assert "the mind's document cannot be read: mind: " in reason(
            '{"version": 1, "robot": "yard_1", "fence": 1, "at_s": 0}'
        )
        assert reason("no document").startswith("the mind's document is no JSON")
        assert "LIFT" in reason(text.replace('"NAVIGATE"', '"LIFT"'))
        assert (
            reason(text.replace('"robot":"yard_1"', '"robot":"yard_2"', 1))
            == "it is the mind of yard_2, this is yard_1"
        )
        body = crossing.real.body
        crossing.runner.simulation.put("sample_4", (body.jaws.real, body.jaws.imag))
        crossing.run(0.1)
        body.set_gripper(closed=True)
        crossing.run(0.2)
        assert reason(text) == "yard_1 holds sample_4 in this body; have it put down first"
        body.set_gripper(closed=False)
        crossing.run(0.2)
        assert reason(text) == ""
        assert reason(text) == "", "it has it already"


def test_a_program_that_has_lost_the_mind_says_so_and_goes_on_once_it_has_it_again() -> None:
    crossing = Crossing()
    with crossing.runner:
        crossing.begin()
        text = crossing.rest(Program.WORLD, fence=1)
        crossing.runner.bring(ROBOT)
        transfer = MindTransfer(fence=1, mind=pieces_of(text)[0])
        assert crossing.ask("transfer", transfer).reason == ""
        crossing.real.disk.text = ""
        crossing.real.kill()
        order = Message(
            id="the same each time",
            performative=Performative.REQUEST,
            sender="service",
            receiver=ROBOT,
            sent_at_s=0.0,
            body=MindOrder(verb=MindVerb.GO_ON, fence=1, to=Program.OWN),
        )
        crossing.real.deliver(order)
        crossing.run(0.1)
        lost = crossing.runner.answers[ROBOT, "go_on", 1]
        assert lost.reason == "no mind was handed over under fencing number 1"
        crossing.runner.exchange(ROBOT, REAL, {})
        assert crossing.ask("transfer", transfer).reason == ""
        crossing.real.deliver(order)
        crossing.run(0.1)
        assert crossing.runner.answers[ROBOT, "go_on", 1].reason == ""
        crossing.finish()


def test_the_main_job_comes_true_while_minds_move_to_real_robots_and_programs_are_killed() -> None:
    ended = run(1.0, 4, real=True)
    assert ended.succeeded, ended
    assert ended.crossings > 1
    assert set(ended.failures) == {"world", "robot", "service"}
