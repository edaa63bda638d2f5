"""Rules on a robot: own packets between a script's, shared actuators, and the sensors that rules need."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from robots.deliberative.actuators import Utterance
from robots.deliberative.commitments import CommitmentState, DropReason
from robots.deliberative.mind import Mind
from robots.deliberative.reader import read_rules, rules_of
from robots.deliberative.terms import Term, Value
from robots.errors import RuleError
from robots.executive.memory import RobotMemory
from robots.physical.body import Pose
from robots.physical.geometry import wrap
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.repertoire import load_repertoire
from robots.social import SocialLevel
from robots.wire import (
    OWN,
    BehaviourScript,
    Control,
    ControlVerb,
    DelegableLeg,
    PacketReport,
    PacketState,
    ScriptState,
)
from tests.robots.executive.test_memory import restart
from tests.robots.executive.test_teleoperation import Operator
from tests.robots.fake_world import STEP_S, FakeWorld
from tests.robots.sensed import PROFILE
from tests.robots.stories import EAST, NORTH, Service, carry, packet, room, run, run_for, script

START = Pose(x_m=1.0, y_m=1.5, heading_rad=EAST)
DEFENDER = Path(__file__).with_name("defender.rules")
HEAD = "AGENT tester;\nACTUATOR activate, say, suspend, resume, retry, giveUp;\n"
ON_REQUEST = """
BELIEF(message(request, ?_, turn)) => COMMIT(activate(TURN_LEFT(angle_rad: 3.14)));
BELIEF(message(request, ?_, stand)) => COMMIT(suspend(look_out));
BELIEF(message(request, ?_, go_on)) => COMMIT(resume());
BELIEF(message(request, ?_, again)) => COMMIT(retry(better));
BELIEF(message(request, ?_, leave)) => COMMIT(giveUp(told_to));
"""


class Rover:
    """A rover with rules in a world, and the service that listens to it."""

    def __init__(
        self,
        *texts: str,
        world: FakeWorld | None = None,
        start: Pose = START,
        home: str | None = None,
        speaks: bool = False,
    ):
        self.world = world or room(noise=0.0)
        self.said: list[Utterance] = []
        self._texts = texts
        society = SocialLevel("fred", self.world.clock) if speaks else None
        link = self.world.add("fred", start, mind=self._mind, home=home, society=society)
        self.service = Service(self.world, link, "fred")

    def _mind(self, profile: RobotProfile) -> Mind:
        files = [rules_of(text, f"file_{number}.rules") for number, text in enumerate(self._texts)]
        self.mind = Mind(profile, load_repertoire(), files, speak=self._hear)
        return self.mind

    def _hear(self, utterance: Utterance) -> None:
        self.said.append(utterance)

    def tell(self, content: Value) -> None:
        said = Utterance(performative="request", other="anna", content=content)
        self.mind.hear(said, self.world.clock.now_s())

    def run_for(self, time_s: float) -> None:
        run_for(self.world, [self.service], time_s)

    def order_delegable(self) -> None:
        """Order a drive that ginger may do in its stead."""
        one = packet("NAVIGATE", ref2="yard")
        leg = DelegableLeg(id="leg_1", packets=(one.id,), robots=("ginger",))
        self.service.order(script("fred", one).model_copy(update={"delegable": (leg,)}))

    def run_out_of_reach(self, time_s: float) -> None:
        """Go on without an answer of the service."""
        for _ in range(round(time_s / STEP_S)):
            self.world.tick()

    def run_until_ended(self) -> ScriptState | None:
        run(self.world, [self.service], lambda: self.service.report is not None)
        return self.service.report.state if self.service.report else None

    @property
    def details(self) -> list[str]:
        return [one.body.detail for one in self.service.heard if isinstance(one.body, PacketReport)]

    @property
    def ended(self) -> Sequence[tuple[str, CommitmentState]]:
        return [(one.name, one.state) for agent in self.mind.agents for one in agent.ended]


def navigating(*texts: str) -> Rover:
    rover = Rover(*texts)
    rover.service.order(script("fred", packet("NAVIGATE", ref2="yard")))
    rover.run_for(2.0)
    return rover


def test_rules_that_do_not_fire_change_nothing() -> None:
    paths = []
    rules = rules_of(HEAD + "BELIEF(message(request, ?_, ?_)) => COMMIT(suspend());", "tester.rules")

    def mind(profile: RobotProfile) -> Mind:
        return Mind(profile, load_repertoire(), [rules])

    for makes_mind in (None, mind):
        world = room(seed=3)
        link = world.add("fred", START, mind=makes_mind)
        service = Service(world, link, "fred")
        service.order(script("fred", packet("NAVIGATE", ref2="yard")))
        path = []
        for _ in range(200):
            run_for(world, [service], STEP_S)
            path.append((world.bodies["fred"].pose, world.bodies["fred"].running))
        paths.append(path)
    assert paths[0] == paths[1]


def test_own_packets_run_between_and_the_scripts_packet_goes_on() -> None:
    rover = navigating(HEAD + ON_REQUEST)
    at = rover.world.bodies["fred"].at
    rover.tell("turn")
    rover.run_for(2.0)
    assert rover.world.bodies["fred"].velocity[0] == 0.0
    assert abs(rover.world.bodies["fred"].at - at) < 0.3
    assert rover.run_until_ended() is ScriptState.FINISHED
    assert rover.service.packets[-1] == ("NAVIGATE", PacketState.FINISHED)
    assert "NAVIGATE stands for TURN_LEFT of tester:4" in rover.details
    assert any(one.startswith("NAVIGATE goes on, TURN_LEFT has finished") for one in rover.details)
    assert rover.ended == [("TURN_LEFT", CommitmentState.FULFILLED)]
    assert rover.service.upkeep == []


def test_own_packets_that_a_mind_finds_no_more_are_cancelled_and_its_script_goes_on() -> None:
    rover = navigating(HEAD + ON_REQUEST)
    rover.tell("turn")
    rover.run_for(0.5)
    mind = rover.world.agents["fred"].hand_over().mind
    assert mind.executive.steering is not None
    assert mind.executive.steering.own is not None
    specs = {tag: spec for tag, spec in load_repertoire().specs.items() if tag != "TURN_LEFT"}
    restart(
        rover.world, rover.service, memory=RobotMemory(mind=mind), repertoire=type(load_repertoire())(specs)
    )
    states = rover.world.agents["fred"].memory().mind.executive.states
    assert states[mind.executive.steering.own.script.id] is ScriptState.CANCELLED
    assert rover.run_until_ended() is ScriptState.FINISHED
    assert rover.service.packets[-1] == ("NAVIGATE", PacketState.FINISHED)


def test_what_own_packets_drive_and_turn_does_not_count_for_the_scripts_packet() -> None:
    rover = Rover(HEAD + ON_REQUEST)
    rover.service.order(script("fred", packet("TURN_LEFT", angle_rad="3.0")))
    rover.run_for(0.5)
    rover.tell("turn")
    assert rover.run_until_ended() is ScriptState.FINISHED
    off_rad = wrap(rover.world.bodies["fred"].pose.heading_rad - 3.0 - 3.14)
    assert abs(off_rad) < 0.15


def test_a_pause_of_the_script_stops_own_packets_and_a_cancel_ends_them() -> None:
    rover = navigating(HEAD + ON_REQUEST)
    rover.tell("turn")
    rover.run_for(0.5)
    rover.service.send(Control(script_id="script-fred", verb=ControlVerb.PAUSE, number=1))
    rover.run_for(0.2)
    heading = rover.world.bodies["fred"].pose.heading_rad
    rover.run_for(2.0)
    assert rover.world.bodies["fred"].pose.heading_rad == heading
    rover.service.send(Control(script_id="script-fred", verb=ControlVerb.CANCEL, number=2))
    rover.run_for(0.5)
    (ended,) = rover.mind.agents[0].ended
    assert (ended.state, ended.reason) == (CommitmentState.DROPPED, DropReason.ORDER)


def test_a_script_of_the_service_ends_packets_of_an_idle_robots_rules() -> None:
    rover = Rover(HEAD + "BELIEF(startup) => COMMIT(activate(WANDER()));")
    rover.run_for(1.0)
    assert [one.tag for one in rover.service.upkeep] == ["WANDER"]
    rover.service.order(script("fred", packet("NAVIGATE", ref2="yard")))
    assert rover.run_until_ended() is ScriptState.FINISHED
    assert rover.mind.agents[0].ended[0].reason is DropReason.ORDER


@pytest.mark.parametrize(
    ("carries", "words"),
    [("", "fred holds rock: only packets of a CARRY statement may move it"), ("CARRY TURN_LEFT;\n", "")],
)
def test_what_is_held_is_moved_by_declared_packets_only(carries: str, words: str) -> None:
    rover = Rover(
        HEAD + carries + "BELIEF(packet(TRANSPORT, running)) => COMMIT(activate(TURN_LEFT(angle_rad: 0.5)));",
        world=room({"rock": 1 + 0.4j}, noise=0.0),
    )
    rover.service.order(carry("fred", "rock", "door", "hatch"))
    assert rover.run_until_ended() is ScriptState.FINISHED
    (ended,) = rover.mind.agents[0].ended
    assert ended.words == words
    assert (ended.state is CommitmentState.FULFILLED) is not bool(words)


def test_a_packet_is_suspended_resumed_begun_again_and_given_up() -> None:
    rover = navigating(HEAD + ON_REQUEST)
    rover.tell("stand")
    rover.run_for(0.3)
    at = rover.world.bodies["fred"].at
    rover.run_for(2.0)
    assert rover.world.bodies["fred"].at == at
    rover.tell("go_on")
    rover.run_for(1.0)
    assert rover.world.bodies["fred"].at != at
    rover.tell("again")
    rover.run_for(0.3)
    states = [state for tag, state in rover.service.packets if tag == "NAVIGATE"]
    assert states[-2:] == [PacketState.INITIALIZING, PacketState.RUNNING]
    rover.tell("leave")
    assert rover.run_until_ended() is ScriptState.FAILED
    assert rover.service.report is not None
    assert "NAVIGATE was given up: told_to" in rover.service.report.detail
    assert {"NAVIGATE is suspended: look_out", "NAVIGATE goes on", "NAVIGATE begins again: better"} <= set(
        rover.details
    )


def test_a_packet_is_begun_again_a_few_times_only() -> None:
    rover = navigating(HEAD + ON_REQUEST)
    for _ in range(4):
        rover.tell("again")
        rover.run_for(0.2)
    assert [one.words for one in rover.mind.agents[0].ended][-1] == "NAVIGATE was begun again 3 times"


def test_rules_do_not_act_on_a_script_that_is_paused() -> None:
    rover = navigating(HEAD + ON_REQUEST)
    rover.service.send(Control(script_id="script-fred", verb=ControlVerb.PAUSE))
    rover.run_for(0.3)
    for content in ("leave", "again", "stand"):
        rover.tell(content)
        rover.run_for(0.3)
        assert rover.mind.agents[0].ended[-1].words == "script script-fred is paused"
    rover.service.send(Control(script_id="script-fred", verb=ControlVerb.RESUME, number=1))
    assert rover.run_until_ended() is ScriptState.FINISHED


@pytest.mark.parametrize("content", ["stand", "again", "leave"])
def test_rules_do_not_act_on_the_drive_of_an_operator(content: str) -> None:
    rover = Rover(HEAD + ON_REQUEST)
    ada = Operator(rover.service)
    ada.drive(1.0, 0.0, 0.3)
    heading_rad = rover.world.bodies["fred"].pose.heading_rad
    rover.tell(content)
    ada.drive(3.0, 0.0, 0.3)
    turned_rad = rover.world.bodies["fred"].pose.heading_rad - heading_rad
    assert turned_rad == pytest.approx(0.9, abs=0.02)
    assert ada.refusal == ""
    (ended,) = rover.mind.agents[0].ended
    assert ended.words == "TELEOPERATE is of no script of the service"


def test_a_packet_whose_time_limit_is_no_number_is_not_run() -> None:
    rover = Rover(
        HEAD
        + "BELIEF(message(request, ?_, turn(?s))) => COMMIT(activate(TURN_LEFT(angle_rad: 1, timeout_s: ?s)));"
    )
    rover.tell(Term("turn", ("soon",)))
    rover.run_for(0.5)
    (ended,) = rover.mind.agents[0].ended
    assert ended.words == "TURN_LEFT: timeout_s = soon is no number of seconds"
    assert rover.service.upkeep == []


def test_a_leg_that_was_given_up_before_it_had_begun_ends_once_another_robot_has_done_it() -> None:
    rover = Rover(HEAD + "BELIEF(doing(NAVIGATE)) => COMMIT(giveUp(never));", speaks=True)
    rover.order_delegable()
    rover.run_out_of_reach(0.2)
    agent = rover.world.agents["fred"]
    assert agent.state_of("script-fred") is ScriptState.ACCEPTED
    assert agent.delegated is not None
    agent.end_delegated("ginger")
    assert rover.run_until_ended() is ScriptState.FINISHED


@pytest.mark.parametrize("before", ["stand", "turn"])
def test_what_is_put_to_others_is_suspended_no_longer_and_no_own_packet_keeps_the_robot(before: str) -> None:
    rover = Rover(HEAD + ON_REQUEST, speaks=True)
    rover.order_delegable()
    rover.run_out_of_reach(2.0)
    for content in (before, "leave"):
        rover.tell(content)
        rover.run_out_of_reach(0.5)
    agent = rover.world.agents["fred"]
    assert agent.delegated is not None
    aside = packet("NAVIGATE", ref2="door")
    assert agent.make_way(BehaviourScript(id="aside", mission_id=OWN, robot="fred", packets=(aside,))) is None
    at = rover.world.bodies["fred"].at
    rover.run_out_of_reach(3.0)
    assert abs(rover.world.bodies["fred"].at - at) > 0.3
    rover.run_for(0.1)
    assert not any(one.startswith("NAVIGATE goes on") for one in rover.details)


def test_the_sensors_that_rules_need_run_without_a_script_and_stop_when_they_are_needed_no_longer() -> None:
    rover = Rover(
        HEAD + "PERCEPTOR full IS not(of: empty());\nBELIEF(on_watch);\n"
        "BELIEF(on_watch) & BELIEF(full) => COMMIT(say(inform, anna, full));\n"
        "BELIEF(message(request, ?_, rest)) => COMMIT(retractBelief(on_watch));"
    )
    rover.run_for(0.2)
    assert rover.world.bodies["fred"].running == {"gripper"}
    body = rover.world.bodies["fred"]
    rover.world.samples["rock"] = body.jaws
    body.set_gripper(closed=True)
    rover.run_for(0.2)
    assert [said.content for said in rover.said] == ["full"]
    rover.tell("rest")
    rover.run_for(0.3)
    assert rover.world.bodies["fred"].running == frozenset()


def test_an_agent_of_higher_rank_takes_the_body_and_one_of_lower_rank_waits() -> None:
    first = "AGENT first;\nACTUATOR activate;\n"
    first += "BELIEF(message(?_, ?_, turn)) => COMMIT(activate(TURN_LEFT(angle_rad: 1)));"
    second = "AGENT second;\nACTUATOR activate;\nBELIEF(startup) => COMMIT(activate(WANDER()));\n"
    second += "BELIEF(failed(WANDER)) => COMMIT(activate(STEP()));"
    rover = Rover(first, second)
    rover.run_for(1.0)
    rover.tell("turn")
    rover.run_for(0.5)
    wander = rover.mind.agents[1].ended[0]
    assert (wander.state, wander.reason) == (CommitmentState.DROPPED, DropReason.REPLACED)
    assert [one.name for one in rover.mind.agents[1].commitments] == ["STEP"]
    rover.run_for(10.0)
    assert rover.ended == [
        ("TURN_LEFT", CommitmentState.FULFILLED),
        ("WANDER", CommitmentState.DROPPED),
        ("STEP", CommitmentState.FULFILLED),
    ]


def field() -> FakeWorld:
    """A pitch, its centre at the origin."""
    corners = [-5 - 4j, 5 - 4j, 5 + 4j, -5 + 4j]
    walls = list(zip(corners, corners[1:] + corners[:1], strict=True))
    beacons = {"post": BeaconSpec(x_m=0, y_m=-3.6, approach_rad=(NORTH,))}
    return FakeWorld(walls=walls, beacons=beacons, samples={"ball": 1.5 + 1j}, noise=0.0)


def test_the_defender_of_sra_figure_5_drives_home_on_request() -> None:
    rover = Rover(DEFENDER.read_text(), world=field(), start=Pose(x_m=0, y_m=0, heading_rad=EAST))
    rover.tell("reset")
    rover.run_for(1.0)
    assert rover.world.bodies["fred"].at == 0
    rover.tell(Term("cover_role", ("left_defender",)))
    rover.run_for(0.2)
    rover.tell("reset")
    rover.run_for(25.0)
    assert abs(rover.world.bodies["fred"].at - (-3 - 1.5j)) < 0.3
    assert [(one.performative, one.other, one.content) for one in rover.said] == [("agree", "anna", "reset")]
    rover.tell(Term("cover_role", ("attacker",)))
    rover.run_for(0.2)
    rover.tell("reset")
    rover.run_for(30.0)
    assert abs(rover.world.bodies["fred"].at - 2) < 0.3


def test_the_defender_goes_to_the_ball_until_it_is_close_and_then_faces_it() -> None:
    rover = Rover(DEFENDER.read_text(), world=field(), start=Pose(x_m=-1.5, y_m=1, heading_rad=EAST))
    rover.tell("track")
    ended = rover.mind.agents[0].ended
    assert run(rover.world, [rover.service], lambda: bool(ended), limit_s=20)
    assert (ended[0].name, ended[0].reason) == ("MOVE_TO", DropReason.REPLACED)
    assert [one.name for one in rover.mind.agents[0].commitments] == ["FACE_OBJECT"]
    assert 0.9 < abs(rover.world.bodies["fred"].at - rover.world.samples["ball"]) < 1.05


def test_rules_that_the_robot_cannot_follow_are_refused_by_name() -> None:
    def refusal(*texts: str, profile: RobotProfile = PROFILE, **told: dict[str, frozenset[str]]) -> str:
        files = [rules_of(text, f"file_{number}.rules") for number, text in enumerate(texts)]
        with pytest.raises(RuleError) as raised:
            Mind(profile, load_repertoire(), files, **told)
        return str(raised.value)

    seeing = HEAD + "PERCEPTOR full IS not(of: empty());\nBELIEF(full) => COMMIT(suspend());"
    blind = RobotProfile(name="me", start=PROFILE.start, beacons={}, sensors=frozenset())
    assert refusal(seeing, profile=blind) == "me has no gripper, which rules tester need"
    allowed = {"tester": frozenset({"say"})}
    assert "tester may not use activate, giveUp, resume, retry, suspend; its actuators: say" in refusal(
        HEAD, competence=allowed
    )
    assert "a role needs the file of an agent beside it" in refusal("ROLE guard;")


def test_new_rules_replace_the_old_ones_and_keep_what_was_adopted() -> None:
    rover = Rover(HEAD + "BELIEF(startup) => COMMIT(SEQ(adoptBelief(guards), activate(WANDER())));")
    rover.run_for(0.5)
    old = rover.mind.agents[0]
    now_s = rover.world.clock.now_s()
    with pytest.raises(RuleError, match="unknown action or plan wave"):
        rover.mind.load([rules_of(HEAD + "BELIEF(startup) => COMMIT(wave());", "new.rules")], now_s)
    assert rover.mind.agents == [old]
    text = HEAD + "BELIEF(message(?_, ?_, ask)) & BELIEF(guards) => COMMIT(say(inform, anna, guards));\n"
    text += "BELIEF(message(?_, ?_, now)) => COMMIT(adoptBelief(guards));"
    rover.mind.load([rules_of(text, "new.rules")], now_s)
    assert [one.reason for one in old.ended] == [DropReason.RULES]
    rover.tell("ask")
    rover.run_for(0.2)
    assert [said.content for said in rover.said] == ["guards"]


def test_rules_are_read_from_a_file() -> None:
    assert read_rules(DEFENDER).name == "defender"
    with pytest.raises(RuleError, match="cannot be read"):
        read_rules(DEFENDER.with_name("nothing.rules"))


def test_plans_compete_by_the_robot_s_own_ways_and_its_mind_tells_the_choice() -> None:
    rules = """
BELIEF(message(request, ?_, rest)) => COMMIT(rest());
PLAN rest() COST way(yard) { activate(MOVE_TO(object: yard)) }
PLAN rest() COST way(door) { activate(MOVE_TO(object: door)) }
PLAN rest() COST way(nowhere) { activate(STOP) }
"""
    rover = Rover(HEAD + rules)
    rover.tell("rest")
    rover.run_for(1.0)
    (told,) = rover.mind.told()
    (made,) = [one for one in told.commitments if one.name == "rest"]
    assert made.state == "active"
    assert made.words.startswith("rest of line 6 costs 0.")
    assert "rest of line 5 costs" in made.words
    assert made.words.endswith("rest of line 7 has no known cost")


def test_what_was_said_is_told_whether_rules_take_it_or_not() -> None:
    rover = Rover(
        "AGENT guard;\nBELIEF(message(request, ?_, cover(?what))) => COMMIT(adoptBelief(covers(?what)));"
    )
    rover.run_for(1.0)
    for content in (Term("cover", ("bay 3",)), "rest"):
        rover.tell(content)
    told = rover.mind.told_messages
    assert [(one.performative, one.sender, one.content) for one in told] == [
        ("request", "anna", 'cover("bay 3")'),
        ("request", "anna", "rest"),
    ]
    assert told[0].at_s == pytest.approx(1.0, abs=0.1)
    rover.world.clock.advance(500.0)
    rover.tell("rest")
    assert rover.mind.told_messages[-1].at_s == rover.world.clock.now_s()


def agent_of(name: str, *plans: str) -> str:
    """An agent that carries out the plan of its name at startup, and again whenever it is told to."""
    return f"""AGENT {name};
ACTUATOR activate;
BELIEF(startup) => COMMIT({name}_task());
BELIEF(message(request, ?_, {name})) => COMMIT({name}_task());
{" ".join(plans)}
"""


def begun_in(rover: Rover) -> list[str]:
    """The packets that the robot's own scripts have begun, in order."""
    running = [one.tag for one in rover.service.upkeep if one.state is PacketState.RUNNING]
    return [tag for number, tag in enumerate(running) if number == 0 or running[number - 1] != tag]


def test_of_plans_of_several_agents_that_want_the_robot_the_cheapest_goes_first() -> None:
    rover = Rover(
        agent_of("dear", "PLAN dear_task() COST 8 { activate(TURN_LEFT(angle_rad: 1)) }"),
        agent_of("cheap", "PLAN cheap_task() COST 3 { activate(STEP()) }"),
        agent_of("middle", "PLAN middle_task() COST 3 + 2 { activate(TURN_RIGHT(angle_rad: 1)) }"),
    )
    rover.run_for(0.5)
    (waits,) = rover.mind.agents[0].commitments
    assert waits.words.endswith("waits at 8 for cheap_task of cheap:3, which costs 3")
    rover.run_for(20.0)
    assert begun_in(rover) == ["STEP", "TURN_RIGHT", "TURN_LEFT"]
    assert {state for _, state in rover.ended} == {CommitmentState.FULFILLED}


def test_a_plan_with_a_cost_keeps_the_robot_to_the_end_of_its_packets_from_cheaper_ones() -> None:
    two = "PLAN long_task() COST 9 { activate(TURN_LEFT(angle_rad: 1)); activate(TURN_RIGHT(angle_rad: 1)) }"
    rover = Rover(
        agent_of("cheap", "PLAN cheap_task() COST 3 { activate(STEP()) }"),
        agent_of("long", two),
    )
    rover.run_for(15.0)
    assert begun_in(rover) == ["STEP", "TURN_LEFT", "TURN_RIGHT"]
    rover.tell("long")
    rover.run_for(0.5)
    rover.tell("cheap")
    rover.run_for(15.0)
    assert begun_in(rover)[3:] == ["TURN_LEFT", "TURN_RIGHT", "STEP"]
    assert {state for _, state in rover.ended} == {CommitmentState.FULFILLED}


def test_what_states_no_cost_takes_the_robot_by_rank() -> None:
    rover = Rover(
        "AGENT first;\nACTUATOR activate;\nBELIEF(message(?_, ?_, turn)) => COMMIT(activate(TURN_LEFT(angle_rad: 1)));",
        agent_of("second", "PLAN second_task() COST 1 { activate(WANDER()) }"),
    )
    rover.run_for(0.5)
    rover.tell("turn")
    rover.run_for(0.5)
    (wander,) = rover.mind.agents[1].ended
    assert (wander.state, wander.reason) == (CommitmentState.DROPPED, DropReason.REPLACED)


def test_a_cost_may_be_how_long_such_packets_have_lasted() -> None:
    rover = Rover(
        "AGENT taught;\nACTUATOR activate;\n"
        "BELIEF(message(?_, ?_, try)) => COMMIT(SEQ(activate(TURN_LEFT(angle_rad: 3)), activate(STEP())));\n"
        "BELIEF(message(?_, ?_, choose)) => COMMIT(choose());\n"
        "PLAN choose() COST lasts(TURN_LEFT) { activate(TURN_LEFT(angle_rad: 3)) }\n"
        "PLAN choose() COST 1 + lasts(STEP) { activate(STEP()) }\n"
    )
    rover.tell("choose")
    rover.run_for(0.3)
    (before,) = rover.mind.agents[0].commitments
    assert before.words.startswith("choose of line 5 costs 30; choose of line 6 costs 31")
    rover.run_for(10.0)
    rover.tell("try")
    rover.run_for(10.0)
    rover.tell("choose")
    rover.run_for(0.3)
    (after,) = rover.mind.agents[0].commitments
    assert after.words.startswith("choose of line 6 costs")


def test_a_plan_that_has_waited_for_the_robot_is_chosen_again_by_what_holds_then() -> None:
    rover = Rover(
        agent_of("busy", "PLAN busy_task() COST 1 { activate(TURN_LEFT(angle_rad: 3)) }"),
        """AGENT late;
ACTUATOR activate;
BELIEF(message(request, ?_, wet)) => COMMIT(adoptBelief(wet));
BELIEF(startup) => COMMIT(go());
PLAN go() WHEN !BELIEF(wet) COST 5 { activate(STEP()) }
PLAN go() COST 7 { activate(TURN_RIGHT(angle_rad: 1)) }
""",
    )
    rover.run_for(0.5)
    (waits,) = rover.mind.agents[1].commitments
    assert waits.words.startswith("go of line 5 costs 5")
    rover.tell("wet")
    rover.run_for(0.5)
    assert waits.words == "go of line 6 costs 7; go of line 5 does not apply"
    rover.run_for(15.0)
    assert begun_in(rover) == ["TURN_LEFT", "TURN_RIGHT"]
