"""The state behind the stand-in for the service; tests change it and `publish` that they did."""

import re
from collections.abc import Sequence
from functools import cached_property
from typing import Any

from app.api.page_views import PageViews
from app.domain.world_model.layout import layout_of
from robots.world import load_world

WORLD = "sample_store"
PLACES = re.compile(r"(?:home|door|interchange|bay)_\w+")


def action(
    number: int, tag: str, robot: str, window: tuple[float, float, float], about: str
) -> dict[str, Any]:
    start_s, takes_s, slack_s = window
    return {
        "id": f"a{number}",
        "tag": tag,
        "arguments": {f"ref{number}": word for number, word in enumerate(PLACES.findall(about), start=1)},
        "agents": [robot],
        "duration_s": takes_s,
        "earliest_start_s": start_s,
        "latest_start_s": start_s + slack_s,
        "earliest_end_s": start_s + takes_s,
        "slack_s": slack_s,
        "critical": slack_s == 0,
        "preconditions": [{"predicate": "can", "args": [robot, tag]}],
        "intended_effects": [],
        "description": about,
    }


ACTIONS = [
    action(1, "NAVIGATE", "yard_1", (0, 4.2, 0), "yard_1 goes from home_yard_1 to door_1"),
    action(2, "DOCK", "yard_1", (4.2, 5, 0), "yard_1 drives up to sample_1 at door_1 and grips it"),
    action(3, "TRANSPORT", "yard_1", (9.2, 8.1, 0), "yard_1 carries sample_1 from door_1 to interchange_1"),
    action(4, "RELEASE2", "yard_1", (17.3, 6, 0), "yard_1 deposits sample_1 at interchange_1"),
    action(5, "NAVIGATE", "store_1", (0, 11.4, 11.9), "store_1 goes from home_store_1 to interchange_1"),
    action(6, "DOCK", "store_1", (23.3, 5, 0), "store_1 drives up to sample_1 at interchange_1 and grips it"),
    action(7, "TRANSPORT", "store_1", (28.3, 6.6, 0), "store_1 carries sample_1 from interchange_1 to bay_1"),
    action(8, "RELEASE2", "store_1", (34.9, 6, 0), "store_1 deposits sample_1 at bay_1"),
]
REPAIRED = [
    action(1, "NAVIGATE", "yard_2", (0, 6, 0), "yard_2 goes from home_yard_2 to door_1"),
    action(2, "DOCK", "yard_2", (6, 5, 0), "yard_2 drives up to sample_1 at door_1 and grips it"),
    action(3, "TRANSPORT", "yard_2", (11, 8.1, 0), "yard_2 carries sample_1 from door_1 to interchange_1"),
    action(4, "RELEASE2", "yard_2", (19.1, 6, 0), "yard_2 deposits sample_1 at interchange_1"),
    action(5, "NAVIGATE", "store_1", (0, 6.4, 18.7), "store_1 goes on to interchange_1"),
    action(6, "DOCK", "store_1", (25.1, 5, 0), "store_1 drives up to sample_1 at interchange_1 and grips it"),
    action(7, "TRANSPORT", "store_1", (30.1, 6.6, 0), "store_1 carries sample_1 from interchange_1 to bay_1"),
    action(8, "RELEASE2", "store_1", (36.7, 6, 0), "store_1 deposits sample_1 at bay_1"),
]
"""The rest of `ACTIONS` five seconds after their start, yard_2 in the place of yard_1."""
DIFFERENCE = {
    "kept": {f"a{number}": f"a{number}" for number in (5, 6, 7, 8)},
    "reassigned": {"a2": "a2", "a3": "a3"},
    "dropped": ["a4"],
    "added": ["a1", "a4"],
    "shifted": {"a6": 6.8, "a7": 6.8, "a8": 6.8},
    "later_s": 6.8,
    "elapsed_s": 5.0,
    "words": ["4 of 8 actions kept, ends 7 s later", "dropped: yard_1 deposits", "new: yard_2 deposits"],
}
LINKS = [
    ("initial", "in", ["sample_1", "door_1"], "a2"),
    ("a1", "near", ["yard_1", "door_1"], "a2"),
    ("a2", "in", ["sample_1", "yard_1"], "a3"),
    ("a3", "near", ["yard_1", "interchange_1"], "a4"),
    ("a4", "in", ["sample_1", "interchange_1"], "a6"),
    ("a5", "near", ["store_1", "interchange_1"], "a6"),
    ("a6", "in", ["sample_1", "store_1"], "a7"),
    ("a7", "near", ["store_1", "bay_1"], "a8"),
    ("a8", "in", ["sample_1", "bay_1"], "goal"),
]


IMAGE = (
    "data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGNgYPhfDwAChAGA60e6kgAAAABJRU5ErkJggg=="
)
"""One pixel."""


class FakeService:
    """Goals, plans and missions with canned answers."""

    conversations: Sequence[dict[str, Any]] = ()
    """Of the service with the selected robot."""

    def __init__(self) -> None:
        self.show_world(WORLD)
        self.worlds = [WORLD]
        self.starting: set[str] = set()
        """Their names; those beside `world` are built alike, and nobody is in them."""
        self.time_s = 12.0
        self.version = 1
        self.goals: dict[str, dict[str, Any]] = {}
        self.plans: dict[str, dict[str, Any]] = {}
        self.missions: dict[str, dict[str, Any]] = {}
        self.results: list[dict[str, Any]] = []
        self.unknown: list[dict[str, Any]] = []
        self.holds: list[dict[str, Any]] = []
        self.events: list[dict[str, Any]] = []
        self.decisions: list[tuple[str, str, str]] = []
        self.stopped: list[tuple[str, str]] = []
        self.asked: list[dict[str, Any]] = []
        self.declared: list[tuple[str, str]] = []
        self.set_points: list[tuple[str, dict[str, Any]]] = []
        self.released: list[tuple[str, str]] = []
        self.undrivable: dict[str, str] = {}
        self.last_heard_s = 0.1
        self.edition = 0
        self.numbers: list[dict[str, Any]] = []
        self.numbers_version = 0
        self.asked_numbers = 0
        self.factsheets: list[dict[str, Any]] = []
        self.changes: list[dict[str, Any]] = []
        """Editions of the world, newest first."""
        self.tuning: dict[str, Any] = {"version": 0, "delivery": "untouched", "tuning": {}, "set_out": {}}
        self.rules: dict[str, Any] = {
            "version": 0,
            "files": {},
            "delivery": "untouched",
            "detail": "",
            "comment": "",
            "decided_by": None,
        }
        self.recorded_minds: dict[str, list[dict[str, Any]]] = {}
        self.said: list[dict[str, Any]] = []
        """What the robots of the mission have said."""
        self.sensor: dict[str, Any] = {"sensor": "ultrasonic", "source": "real"}
        self.role: dict[str, Any] = {
            "version": 0,
            "role": None,
            "tags": None,
            "home": None,
            "rules": None,
            "delivery": "untouched",
            "detail": "",
            "decided_by": None,
        }
        self.mind: dict[str, Any] = {"at_s": 12.0, "agents": [], "conversations": []}
        self.trace: dict[str, Any] = {"at_s": 12.0, "stretches": [], "conditions": []}
        self.tuning["packets"] = {"NAVIGATE": {"translate/advance": {"r.gain": 1.0, "r.limit": 1.0}}}
        self.connection: dict[str, str] = {}
        self.hearing: dict[str, dict[str, Any]] = {}
        """What differs of a robot's link from one that is heard all the time."""
        self.lost: set[str] = set()
        self.out_of_service: dict[str, str] = {}
        """By robot, the reason."""
        self.view: str | None = None
        self.views = PageViews()
        self.refusal = ""
        """What stands against every order on a mission, if anything does."""
        self.stopping = False
        self.explanation = {
            "plan_id": "plan-1",
            "actions": [
                {
                    "action": "a1",
                    "goals": [],
                    "chain": [],
                    "because": ["a1 NAVIGATE brings about that yard_1 is near door_1: needed by a2 DOCK"],
                    "robots": {"yard_1": "yard_2 instead of yard_1: +7.2 s"},
                    "order": [],
                }
            ],
            "constraints": [
                {
                    "constraint": "avoiding bay_3",
                    "at_least_s": 0.0,
                    "at_most_s": 0.0,
                    "words": "it costs no time: no plan without it is shorter",
                }
            ],
            "robots": {"store_1": "there is no plan without store_1"},
            "makespan": ["0.0 to 40.9 s: yard_1"],
            "waits": [],
        }

    def show_world(self, name: str) -> None:
        """Have this world file's contents in the world `WORLD`."""
        self.world = load_world(name)
        self.facts = [{"predicate": "in", "args": [s.name, s.at]} for s in self.world.samples]
        self.telemetry = {
            robot.name: {
                "x_m": robot.start[0],
                "y_m": robot.start[1],
                "heading_rad": robot.start[2] * 3.14159265 / 180,
                "ranges_m": [None, 1.2] * (robot.whiskers // 2),
                "holding": None,
                "battery": 0.97,
                "packet_tag": None,
                "packet_state": None,
                "patterns": {},
                "resultants": {},
                "sensors": ["ultrasonic"],
                "tags": {},
                "at_s": 12.0,
            }
            for robot in self.world.robots
        }
        self.states = {
            one.name: {"open": "opened"}.get(one.state_at_start, one.state_at_start)
            for one in self.world.peripherals
        }
        """Of doors, hatches and lifts."""
        quiet = {"ranges_m": [], "sensors": [], "battery": None, "packet_tag": None, "packet_state": None}
        for one in self.world.peripherals:
            x_m, y_m = one.centre
            still = {"heading_rad": 0.0, "holding": None, "patterns": {}, "resultants": {}, "tags": {}}
            self.telemetry[one.name] = {"x_m": x_m, "y_m": y_m, **still, **quiet, "at_s": 12.0}

    def publish(self, type_: str, subject: str, **data: Any) -> None:
        """Tell of an event; the data of missions' names their goal, wherever that has changed too."""
        seq = len(self.events) + 1
        self.events.append({"seq": seq, "time": "", "type": type_, "subject": subject, "data": data})

    def check(self, text: str) -> dict[str, Any]:
        """What a sentence would be taken for: this service understands `move SAMPLE to PLACE` and no more."""
        match text.split():
            case ["move", sample, "to", place]:
                return {
                    "goals": [{"predicate": "in", "args": [sample, place]}],
                    "issue": None,
                    "completions": [],
                }
            case ["park", "every", "robot", "with", robot]:
                return {
                    "goals": [{"predicate": "near", "args": [robot, f"home_{robot}"]}],
                    "readings": [{"said": "every robot", "means": ["yard_1", "yard_2"]}],
                    "constraints": {
                        "robots": [robot],
                        "without": [],
                        "avoid": [],
                        "keep_empty": [],
                        "after": [],
                    },
                    "issue": None,
                    "completions": [],
                }
            case ["park", robot, "preferably", "without", other, "and", "charged"]:
                nothing: dict[str, Any] = {"robots": [], "without": [], "avoid": [], "keep_empty": []}
                return {
                    "goals": [{"predicate": "near", "args": [robot, "home"]}],
                    "constraints": {
                        **nothing,
                        "after": [],
                        "preferences": [
                            {**nothing, "without": [other], "at_least": {}, "cost_s": 20},
                            {**nothing, "at_least": {"battery": 0.4}, "cost_s": 60},
                        ],
                    },
                    "preferences": [
                        {
                            "preference": f"preferably without {other}",
                            "cost_s": 20,
                            "conflict": f"near({robot}, home) needs {other}",
                        },
                        {
                            "preference": "preferably only with robots of battery >= 0.4",
                            "cost_s": 60,
                            "conflict": "",
                        },
                    ],
                    "issue": None,
                    "completions": [],
                }
            case ["move", sample]:
                asked, choices = f"move {sample} where to?", [f"{text} to bay_{number}" for number in (1, 3)]
            case _:
                asked, choices = "move which sample?", ["move sample_1", "move sample_2"]
        return {"goals": [], "issue": {"code": "needed", "detail": asked}, "completions": choices}

    def propose(self, text: str, *, tender: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
        """A goal whose plan is proposed at once. :param tender: of the plan."""
        number = len(self.goals) + 1
        goal = {
            "id": f"goal-{number}",
            "world": WORLD,
            "text": text,
            "goal": [{"predicate": "in", "args": ["sample_1", "bay_1"]}],
            "state": "planned",
            "reason": None,
            "plan_id": f"plan-{number}",
            "mission_id": None,
            "outcome": None,
            "created_at": f"2026-11-21T12:00:{number:02}Z",
        }
        self.goals[goal["id"]] = goal | changes
        self.plans[goal["plan_id"]] = self._plan(f"plan-{number}", goal["id"]) | {"tender": tender}
        self.publish("goal.planned", goal["id"])
        return self.goals[goal["id"]]

    def plan_on(self, goal_id: str, **progress: Any) -> None:
        """The goal is still being planned; this is how far it is."""
        told = {"engine": "macta", "elapsed_s": 1.5, "makespan_s": None, "lower_bound_s": None}
        goal = self.goals[goal_id]
        goal |= {"state": "planning", "planning": told | progress, "plan_id": None}
        self.publish("goal.progress", goal_id)

    def stop(self, goal_id: str, verb: str) -> dict[str, Any]:
        """End the planning: take the best plan, or withdraw the goal."""
        goal = self.goals[goal_id]
        self.stopped.append((goal_id, verb))
        goal |= {"planning": None, "plan_id": goal_id.replace("goal", "plan")}
        goal |= {"state": "planned"} if verb == "stop" else {"state": "withdrawn", "outcome": "cancelled"}
        self.publish("goal.planned", goal_id)
        return goal

    def find_alternatives(self, goal_id: str) -> dict[str, Any]:
        """Another plan beside the proposed one."""
        goal = self.goals[goal_id]
        lanes: dict[str, list[tuple[float, float, str]]] = {}
        for act in ACTIONS:
            spell = (act["earliest_start_s"], act["earliest_end_s"], act["tag"])
            lanes.setdefault(act["agents"][0], []).append(spell)
        figures = {"distance_m": 14.2, "energy_j": 556.0, "clearances": 0, "lanes": lanes}
        self.plans[goal["plan_id"]] |= {**figures, "label": "shortest time", "comparison": ""}
        other = self._plan(f"{goal['plan_id']}b", goal_id)
        label = {"label": "without yard_1", "comparison": "7.2 s longer", "robots": ["store_1", "yard_2"]}
        longer = {"makespan_s": 48.1, "distance_m": 12.9}
        lanes = {"store_1": lanes["store_1"], "yard_2": [(0, 11.4, "NAVIGATE"), *lanes["yard_1"][1:]]}
        self.plans[other["id"]] = {**other, **figures, **label, **longer, "lanes": lanes}
        goal["alternatives"] = {"state": "found", "count": 4, "reason": ""}
        self.publish("goal.alternatives_found", goal_id)
        return goal

    def edit(self, plan_id: str, edits: list[dict[str, Any]]) -> dict[str, Any]:
        """The plan is being planned with a change."""
        self.asked.extend(edits)
        goal = self.goals[self.plans[plan_id]["goal_id"]]
        goal["alternatives"] = {"state": "seeking", "count": 1, "reason": "", "edited": plan_id}
        self.publish("goal.alternatives_sought", goal["id"], edited=plan_id)
        return goal

    def edited(self, goal_id: str, *, reason: str = "") -> None:
        """The planning of the change has ended: with a plan, or with a reason why there is none."""
        goal = self.goals[goal_id]
        goal["alternatives"] |= {"state": "failed" if reason else "found", "reason": reason}
        if not reason:
            self.find_alternatives(goal_id)
            other = self.plans[f"{goal['plan_id']}b"]
            difference = {"words": ["7 of 8 actions kept, ends 7 s later"], "elapsed_s": 0.0}
            other["label"] = "yard_2 for in(sample_1, bay_1)"
            other["repairs"] = {"plan_id": goal["plan_id"], "course": "edited", "difference": difference}
        self.publish("goal.alternatives_failed" if reason else "goal.alternatives_found", goal_id)

    def approve(self, plan_id: str) -> dict[str, Any]:
        plan = self.plans[plan_id]
        mission_id = plan_id.replace("plan", "mission")
        plan["state"] = "approved"
        goal = self.goals[plan["goal_id"]]
        goal |= {"state": "committed", "mission_id": mission_id}
        self.missions[mission_id] = {
            "id": mission_id,
            "goal_id": goal["id"],
            "plan_id": plan_id,
            "world": WORLD,
            "state": "running",
            "reason": None,
            "failure": None,
            "estimate_s": 40.9,
            "original_estimate_s": 40.9,
            "started_at_s": self.time_s,
            "revised_at_s": None,
            "deadline_s": None,
            "enquire_at_s": self.time_s + 81.4,
            "ended_at_s": None,
            "progress": [self._progress("yard_1", "running"), self._progress("store_1", "waiting")],
            "recovery": {"policy": "ask", "step": None, "attempts": []},
            "created_at": goal["created_at"],
        }
        self.publish("plan.approved", plan_id, goal=goal["id"])
        self.publish("mission.running", mission_id)
        return plan | {"mission_id": mission_id}

    def complete(self, mission_id: str) -> None:
        mission = self.missions[mission_id]
        mission |= {"state": "completed", "ended_at_s": self.time_s + 39.0}
        mission["progress"] = [self._progress("yard_1", "finished"), self._progress("store_1", "finished")]
        self.goals[mission["goal_id"]] |= {"state": "finished", "outcome": "completed"}
        self.publish("mission.completed", mission_id, goal=mission["goal_id"])

    def bring(self, mission_id: str, kind: str, name: str, **more: Any) -> None:
        """A packet of yard_1 has brought a result of bay_1."""
        result = {
            "id": f"result-{len(self.results) + 1}",
            "mission_id": mission_id,
            "robot": "yard_1",
            "packet_id": "a1",
            "kind": kind,
            "name": name,
            "of": "bay_1",
            "at_s": self.missions[mission_id]["started_at_s"] + 15,
            "created_at": "2026-07-01T12:03:00.000Z",
            "value": None,
            "unit": "",
            **more,
        }
        self.results.append(result)
        self.missions[mission_id]["results"] = len(self.results)
        self.publish("packet.result", mission_id, result=result["id"])

    def say(self, mission_id: str, sender: str, robot: str, content: str, said_s: float, **more: Any) -> None:
        """A robot of the mission tells another something, which confirms it."""
        told = {
            "sender": sender,
            "robot": robot,
            "performative": "inform",
            "content": content,
            "protocol": "macta-inform",
            "conversation": f"talk-{len(self.said) + 1}",
            "sent_at_s": said_s,
            "at_s": said_s + 0.2,
            "attempt": 1,
            "answer": "confirm",
            "answer_content": content,
            **more,
        }
        self.said.append(told)
        self.publish("speech.heard", mission_id, **told)

    def replay(self, mission_id: str) -> dict[str, Any]:
        """The recording of 40 s in which yard_1 drives 4 m to the east and delivers sample_1 at half time."""
        mission = self.missions[mission_id]
        began = {**mission, "state": "running", "progress": []}
        change = {"type": "world.facts_changed", "subject": WORLD, "data": {}}
        lying = {sample.name: sample.at for sample in self.world.samples}
        start_s = mission["started_at_s"]
        return {
            "world": {"layout": layout_of(self.world), "facts": self.facts},
            "robots": {
                "yard_1": [[start_s, 1.0, 2.0, 0.0, None, None], [start_s + 40, 5.0, 2.0, 0.0, None, None]]
            },
            "missions": [
                {"at_s": start_s, "mission": began},
                {"at_s": start_s + 39, "mission": mission},
            ],
            "goal": self.goals[mission["goal_id"]],
            "plans": {},
            "scripts": {},
            "results": [{**one, "image": IMAGE} if one["kind"] == "image" else one for one in self.results],
            "telemetry": {
                "yard_1": [{"at_s": start_s, "battery": 0.8}, {"at_s": start_s + 20, "battery": 0.6}]
            },
            "minds": self.recorded_minds,
            "samples": [
                {"at_s": start_s, "lying": lying},
                {"at_s": start_s + 10, "lying": lying | {"sample_1": "yard_1"}},
                {"at_s": start_s + 20, "lying": lying | {"sample_1": "interchange_1"}},
            ],
            "events": [
                {
                    "at_s": start_s - 5,
                    "type": "plan.approved",
                    "subject": mission["plan_id"],
                    "data": {"actor": "administrator"},
                },
                {"at_s": start_s + 10, **change},
                {"at_s": start_s + 20, **change},
                *(
                    {"at_s": one["at_s"], "type": "speech.heard", "subject": mission_id, "data": one}
                    for one in self.said
                ),
                {"at_s": start_s + 39, "type": "mission.completed", "subject": mission_id, "data": {}},
            ],
        }

    def tune(self, tuning: dict[str, Any]) -> None:
        packets = {"NAVIGATE": {"translate/advance": {"r.gain": 1.0, "r.limit": 1.0}}}
        for pattern, values in tuning.get("NAVIGATE", {}).items():
            packets["NAVIGATE"][pattern] |= values
        version = self.tuning["version"] + 1
        self.tuning |= {
            "tuning": tuning,
            "packets": packets,
            "version": version,
            "delivery": "pending",
        }

    def rule(self, files: dict[str, str], comment: str = "") -> None:
        """Another operator, or this one, sends rules."""
        version = self.rules["version"] + 1
        sent = {"files": files, "comment": comment, "delivery": "pending", "decided_by": "operator"}
        self.rules = self.rules | sent | {"version": version}
        self.publish("rules.set", "yard_1", version=version)

    def play(self, role: str | None, **given: Any) -> None:
        """Another operator, or this one, gives a role or ends it."""
        version = self.role["version"] + 1
        told = {"role": role, "delivery": "pending", "decided_by": "operator", "version": version}
        self.role = {**self.role, "tags": None, "home": None, "rules": None, **given, **told}
        self.publish("role.set" if role else "role.cleared", "yard_1", version=version)

    @cached_property
    def embodiment(self) -> dict[str, Any]:
        """Of the selected robot."""
        body = {"kind": "velocity"}
        return {"kind": "simulated", "body": body, "lease_until_s": None, "attempts": []}

    def embody(self, name: str, kind: str, *, state: str = "requested") -> dict[str, Any]:
        """The mind is moved into another body; `state`: how far the move is."""
        has_it = state == "embodied"
        move = {"state": state, "reason": "", "body": {"kind": kind}, "ended_at": "now" if has_it else None}
        self.embodiment["attempts"] = [move]
        if has_it:
            self.embodiment["body"] = {"kind": kind}
            self.embodiment["kind"] = "virtual" if kind == "avatar" else "simulated"
        self.publish(f"embodiment.{state}", name, state=state)
        return self.embodiment

    @cached_property
    def breakpoints(self) -> dict[str, Any]:
        """Of the selected robot, and where its world stands."""
        return {"rules": [], "refusal": "", "of_others": 0, "halts": [], "left_s": None, "ended": ""}

    @cached_property
    def dialogues(self) -> list[dict[str, Any]]:
        """Of all robots, the newest first."""
        return []

    def take_word(self, robot: str, said: dict[str, Any]) -> dict[str, Any]:
        """What "face the sample" asks, and what its answer proposes."""
        known = next((one for one in self.dialogues if one["id"] == said["dialogue"]), None)
        line = {"by": "administrator", "performative": "request", "content": "", "words": said["text"]}
        if known is None:
            known = {"id": f"dialogue-{len(self.dialogues)}", "robot": robot, "reason": "", "lines": []}
            self.dialogues.insert(0, known)
            question = {"detail": "which one?", "choices": ["sample_2", "sample_3"]}
            known |= {"state": "asking", "text": said["text"], "script": [], "question": question}
        else:
            packet = {
                "tag": "FACE_OBJECT",
                "arguments": {"object": said["text"]},
                "expected_duration_s": 20.0,
            }
            known |= {"state": "proposed", "script": [packet], "question": None}
        known["lines"] = [*known["lines"], line]
        self.publish(f"dialogue.{known['state']}", robot)
        return known

    def decide(self, robot: str, dialogue: str, state: str) -> dict[str, Any]:
        """A dialogue is approved or withdrawn."""
        known = next(one for one in self.dialogues if one["id"] == dialogue)
        known["state"] = state
        self.publish(f"dialogue.{state}", robot)
        return known

    def navigate(self, robot: str, mission: str) -> None:
        """The robot is at NAVIGATE in the mission, a second long, and half way."""
        told = {"packet_tag": "NAVIGATE", "packet_state": "running", "goal_m": 2.5}
        self.telemetry[robot] |= told | {"resultants": {"translate": [0.5, 0.4], "rotate": [0.0, 0.2]}}
        self.hearing[robot] = {"mission_id": mission}
        ticks = [
            {
                "at_s": 11 + tick / 20,
                "patterns": [[tick / 20, 0.8]],
                "resultants": [[tick / 20, 0.8]],
                "linear_m_s": 0.2,
                "angular_rad_s": 0.0,
            }
            for tick in range(20)
        ]
        advance = {"name": "translate/advance", "level": "task"}
        stretch = {"packet_id": "a1", "patterns": [advance], "dofs": ["translate"], "ticks": ticks}
        near = {"when": "after", "words": "is 1.70 m off the approach point of door_1", "holds": False}
        empty = {"when": "before", "words": "holds nothing, jaws open", "holds": True}
        self.trace = {"at_s": 12.0, "stretches": [stretch], "conditions": [empty, near]}

    def announce(self, robot: str) -> None:
        """A robot that is in no world tells what it is."""
        sheet = {"repertoire": ["NAVIGATE"], "speed_m_s": 0.4}
        self.factsheets.append(
            {
                "robot": robot,
                "state": "announced",
                "reason": "no world has it",
                "at_s": self.time_s,
                "sheet": sheet,
            }
        )

    def declare(self, name: str, verb: str, reason: str = "") -> None:
        match verb:
            case "take_out_of_service":
                self.out_of_service[name] = reason
            case "bring_back":
                del self.out_of_service[name]
            case _:
                self.declared.append((name, verb))
                self.lost.symmetric_difference_update({name})

    def ask_about_repair(self, mission_id: str) -> None:
        """The mission's yard robot has failed, and a repaired plan waits for a decision."""
        mission = self.missions[mission_id]
        plan = self._plan(f"{mission['plan_id']}-repaired", mission["goal_id"])
        plan |= {"actions": REPAIRED, "makespan_s": 42.7, "robots": ["store_1", "yard_2"]}
        plan["repairs"] = {"plan_id": mission["plan_id"], "course": "mended", "difference": DIFFERENCE}
        self.plans[plan["id"]] = plan
        self.goals[mission["goal_id"]]["plan_id"] = plan["id"]
        attempt = {
            "number": 1,
            "failure": "robot",
            "reason": "yard_1: the gripper does not close",
            "measure": "replan",
            "without": ["DOCK by yard_1"],
            "outcome": "proposed",
            "detail": "4 of 8 actions kept",
            "plan_id": plan["id"],
        }
        mission |= {"state": "recovering", "failure": "robot", "reason": attempt["reason"]}
        mission["recovery"] |= {"step": "deciding", "attempts": [attempt]}
        self.publish("plan.proposed", plan["id"], goal=mission["goal_id"])
        self.publish("mission.repair_proposed", mission_id)

    def robots(self) -> list[dict[str, Any]]:
        return [self._agent(name) | {"kind": "robot"} for name in self.telemetry if name not in self.states]

    def peripherals(self) -> list[dict[str, Any]]:
        """Doors, hatches and lifts."""
        kinds = {one.name: one.kind.value for one in self.world.peripherals}
        return [self._agent(name) | {"kind": kinds[name], "state": self.states[name]} for name in self.states]

    def _agent(self, name: str) -> dict[str, Any]:
        told = self.telemetry[name]
        return {
            "id": name,
            "name": name,
            "world": WORLD,
            "connection": self.connection.get(name, "online"),
            "lost": {"since_s": 0.0} if name in self.lost else None,
            "out_of_service": {"reason": self.out_of_service[name], "taken_by": "administrator"}
            if name in self.out_of_service
            else None,
            "last_heard_s": 0.2,
            "heard_at_s": self.time_s - 0.2,
            "silent": False,
            "next_contact_s": 0.0,
            "mission_id": None,
            "driven_by": None,
            "repertoire": ["NAVIGATE", "DOCK"],
            "reach": ["door_1", "interchange_1"],
            "pose": {key: told[key] for key in ("x_m", "y_m", "heading_rad")},
            "packet": told["packet_tag"],
            "packet_state": told["packet_state"],
            "battery": told["battery"],
            "holding": told["holding"],
        } | self.hearing.get(name, {})

    def _plan(self, plan_id: str, goal_id: str) -> dict[str, Any]:
        return {
            "id": plan_id,
            "goal_id": goal_id,
            "state": "proposed",
            "actions": ACTIONS,
            "causal_links": [
                {"producer": producer, "fact": {"predicate": predicate, "args": args}, "consumer": consumer}
                for producer, predicate, args, consumer in LINKS
            ],
            "orderings": [],
            "makespan_s": 40.9,
            "engine": "fast-downward",
            "planning_s": 0.31,
            "robots": ["store_1", "yard_1"],
            "objects": {"sample_1": "object", "bay_1": "location", "interchange_1": "location"},
            "recruitment": {
                "yard_1": "nearest of two that reach door_1",
                "store_1": "the only one in aisle_1",
            },
            "comment": None,
        }

    def _progress(self, robot: str, state: str) -> dict[str, Any]:
        done = state == "finished"
        packets = [
            {
                "id": act["id"],
                "tag": act["tag"],
                "description": act["description"],
                "state": state if done or index == 0 else "waiting",
                "started_at_s": act["earliest_start_s"] + self.time_s if done or index == 0 else None,
                "finished_at_s": act["earliest_end_s"] + self.time_s if done else None,
                "expected_start_s": act["earliest_start_s"],
                "expected_duration_s": act["duration_s"],
            }
            for index, act in enumerate(act for act in ACTIONS if act["agents"] == [robot])
        ]
        return {"robot": robot, "script_id": f"script-{robot}", "state": state, "packets": packets}
