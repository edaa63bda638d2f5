"""The state behind the stand-in for the service; tests change it and `publish` that they did."""

from typing import Any

from robots.world import load_world

WORLD = "sample_store"


def action(
    number: int, tag: str, robot: str, window: tuple[float, float, float], about: str
) -> dict[str, Any]:
    start_s, takes_s, slack_s = window
    return {
        "id": f"a{number}",
        "tag": tag,
        "arguments": {},
        "agents": [robot],
        "duration_s": takes_s,
        "earliest_start_s": start_s,
        "latest_start_s": start_s + slack_s,
        "earliest_end_s": start_s + takes_s,
        "slack_s": slack_s,
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


class FakeService:
    """Goals, plans and missions with canned answers."""

    def __init__(self) -> None:
        self.world = load_world(WORLD)
        self.time_s = 12.0
        self.version = 1
        self.goals: dict[str, dict[str, Any]] = {}
        self.plans: dict[str, dict[str, Any]] = {}
        self.missions: dict[str, dict[str, Any]] = {}
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
                "tags": {},
                "at_s": 12.0,
            }
            for robot in self.world.robots
        }
        self.events: list[dict[str, Any]] = []
        self.decisions: list[tuple[str, str, str]] = []
        self.stopped: list[tuple[str, str]] = []
        self.asked: list[dict[str, Any]] = []
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
            "robots": {"store_1": "there is no plan without store_1"},
            "makespan": ["0.0 to 40.9 s: yard_1"],
            "waits": [],
        }

    def publish(self, type_: str, subject: str) -> None:
        seq = len(self.events) + 1
        self.events.append({"seq": seq, "time": "", "type": type_, "subject": subject, "data": {}})

    def propose(self, text: str, **changes: Any) -> dict[str, Any]:
        """A goal whose plan is proposed at once."""
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
        self.plans[goal["plan_id"]] = self._plan(f"plan-{number}", goal["id"])
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
        figures = {"distance_m": 14.2, "energy_j": 556.0, "clearances": 0}
        self.plans[goal["plan_id"]] |= {**figures, "label": "shortest time", "comparison": ""}
        other = self._plan(f"{goal['plan_id']}b", goal_id)
        label = {"label": "without yard_1", "comparison": "7.2 s longer", "robots": ["store_1", "yard_2"]}
        self.plans[other["id"]] = {**other, **figures, **label, "makespan_s": 48.1}
        goal["alternatives"] = {"state": "found", "count": 4, "reason": ""}
        self.publish("goal.alternatives_found", goal_id)
        return goal

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
            "deadline_s": None,
            "enquire_at_s": self.time_s + 81.4,
            "ended_at_s": None,
            "progress": [self._progress("yard_1", "running"), self._progress("store_1", "waiting")],
            "created_at": goal["created_at"],
        }
        self.publish("mission.running", mission_id)
        return plan | {"mission_id": mission_id}

    def complete(self, mission_id: str) -> None:
        mission = self.missions[mission_id]
        mission |= {"state": "completed", "ended_at_s": self.time_s + 39.0}
        mission["progress"] = [self._progress("yard_1", "finished"), self._progress("store_1", "finished")]
        self.goals[mission["goal_id"]] |= {"state": "finished", "outcome": "completed"}
        self.publish("mission.completed", mission_id)

    def robots(self) -> list[dict[str, Any]]:
        return [
            {
                "id": name,
                "name": name,
                "world": WORLD,
                "connection": "online",
                "last_heard_s": self.time_s,
                "pose": {key: told[key] for key in ("x_m", "y_m", "heading_rad")},
                "packet": told["packet_tag"],
                "battery": told["battery"],
                "holding": told["holding"],
            }
            for name, told in self.telemetry.items()
        ]

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
