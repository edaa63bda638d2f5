"""A random operator: states goals, decides on plans, has missions paused, planned again and cancelled."""

import random
import uuid
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import httpx2

from app.cli.trials.observer import ENDED, Observer
from app.cli.trials.random_goals import PASSING, drawn_sentence
from app.domain.goal_language.verbs import Verbs
from robots.world import WorldFile

MAX_OPEN = 8
DEADLINE_S = 100_000.0
"""Never missed: the check is that the deadline does not move."""
NONSENSE = (
    "move sample_99 to bay_1",
    "move {sample} to the moon",
    "move {sample} to {sample}",
    "dance",
    "move {sample} to {home}",
)
ACTS = {
    "state": 10,
    "compete": 2,
    "talk nonsense": 1,
    "decide": 8,
    "pause": 2,
    "resume": 3,
    "replan": 1,
    "cancel a mission": 1,
    "cancel a goal": 1,
    "submit again": 2,
    "read": 3,
}
"""Acts with their weights."""
READS = ("/v1/goals", "/v1/plans", "/v1/missions", "/v1/robots", "/v1/executors", "/readyz")


@dataclass(slots=True, kw_only=True)
class SubmittedGoal:
    """A submitted goal. `goal_id` is None until the submission is answered."""

    key: str
    body: Mapping[str, Any]
    goal_id: str | None = None


@dataclass(slots=True, kw_only=True)
class RandomOperator:
    """Acts on the API, one act at a time. Answers outside the allowed statuses are complaints.

    :param verbs: those of its sentences; None: samples are moved.
    """

    world: WorldFile
    seed: int
    observer: Observer
    verbs: Verbs | None = None
    submitted: list[SubmittedGoal] = field(default_factory=list)
    unanswered: list[SubmittedGoal] = field(default_factory=list)
    """Submissions without an answer: only their repetition shows whether they were accepted."""
    done: Counter[str] = field(default_factory=Counter)
    complaints: list[str] = field(default_factory=list)
    _rng: random.Random = field(init=False)

    def __post_init__(self) -> None:
        self._rng = random.Random(self.seed)

    @property
    def open(self) -> Sequence[str]:
        """The goals that are not known to have ended."""
        known = self.observer.goals
        ids = [one.goal_id for one in self.submitted if one.goal_id is not None]
        return [one for one in ids if one not in known or known[one]["state"] not in ENDED]

    def act(self, api: httpx2.Client) -> None:
        """Perform one random act.

        :raises httpx2.TransportError: if the service ends meanwhile.
        """
        self.catch_up(api)
        match self._rng.choices(list(ACTS), list(ACTS.values()))[0]:
            case "state" if len(self.open) < MAX_OPEN:
                self._state(api, self._errand())
            case "compete" if len(self.open) < MAX_OPEN:
                for text in self._competing():
                    self._state(api, text)
            case "talk nonsense":
                self._submit_nonsense(api)
            case "decide":
                self._decide(api)
            case "pause" | "resume" | "cancel a mission" as order:
                self._order(api, order.split()[0])
            case "replan":
                self._replan(api)
            case "cancel a goal":
                self._cancel_goal(api)
            case "submit again":
                self._submit_again(api)
            case "read":
                self._ask(api, "GET", self._rng.choice(READS), may=(200,))

    def settle(self, api: httpx2.Client) -> None:
        """Take the decisions that let every goal end.

        :raises httpx2.TransportError: if the service ends meanwhile.
        """
        self.catch_up(api)
        for goal_id in self.open:
            goal = self.observer.goals.get(goal_id)
            if goal is None:
                continue
            if goal["state"] == "planned":
                self._decide_on(api, goal["plan_id"], "approve")
            elif goal["state"] == "committed":
                self._settle_mission(api, goal["mission_id"])

    def catch_up(self, api: httpx2.Client) -> None:
        """Repeat unanswered submissions; by its idempotency key an accepted one is the same goal."""
        while self.unanswered:
            self._submit(api, self.unanswered[-1])
            self.unanswered.pop()

    def _errand(self) -> str:
        if self.verbs is not None:
            return drawn_sentence(self.world, self.verbs, self._rng)
        if self._rng.random() < 0.3 and len(self.world.samples) > 1:
            one, other = self._rng.sample([sample.name for sample in self.world.samples], 2)
            return f"move {one} to {self._place()} and move {other} to {self._place()}"
        return f"move {self._sample()} to {self._place()}"

    def _competing(self) -> tuple[str, str]:
        """Two goals that may be about the same thing."""
        if self.verbs is not None:
            return self._errand(), self._errand()
        sample = self._sample()
        return f"move {sample} to {self._place()}", f"move {sample} to {self._place()}"

    def _sample(self) -> str:
        """A sample's name, where there are some."""
        samples = [sample.name for sample in self.world.samples]
        return self._rng.choice(samples or [robot.name for robot in self.world.robots])

    def _place(self) -> str:
        return self._rng.choice([one.name for one in self.world.locations if one.kind not in PASSING])

    def _state(self, api: httpx2.Client, text: str) -> None:
        body = {
            "world": self.world.name,
            "text": text,
            "auto_approve": self._rng.random() < 0.6,
            "priority": self._rng.randint(-2, 2),
            "deadline_s": self._rng.choice([None, DEADLINE_S]),
            "recovery": self._rng.choice([None, "auto", "ask", "never"]),
        }
        goal = SubmittedGoal(key=uuid.UUID(int=self._rng.getrandbits(128)).hex, body=body)
        self.unanswered.append(goal)
        self._submit(api, goal)
        self.unanswered.remove(goal)

    def _submit(self, api: httpx2.Client, goal: SubmittedGoal) -> None:
        """Submit the goal; a refusal is allowed, because places may be occupied."""
        answer = self._ask(api, "POST", "/v1/goals", goal.body, may=(202, 409, 422, 429), key=goal.key)
        if answer.status_code != 202:
            self.done["goals refused"] += 1
            if goal.goal_id is not None:
                self.complaints.append(f"{goal.goal_id} was accepted, and refused later: {answer.text}")
            return
        goal_id = answer.json()["id"]
        if goal.goal_id is None:
            goal.goal_id = goal_id
            self.submitted.append(goal)
            self.done["goals taken"] += 1
        elif goal.goal_id != goal_id:
            self.complaints.append(f"{goal.goal_id}, submitted again, became {goal_id}")

    def _submit_again(self, api: httpx2.Client) -> None:
        if self.submitted:
            self._submit(api, self._rng.choice(self.submitted[-20:]))

    def _submit_nonsense(self, api: httpx2.Client) -> None:
        home = next((one.name for one in self.world.locations if one.kind == "home"), "nowhere")
        text = self._rng.choice(NONSENSE).format(sample=self._sample(), home=home)
        body = {"world": self.world.name, "text": text}
        self._ask(api, "POST", "/v1/goals", body, may=(409, 422), key=uuid.uuid4().hex)
        self.done["nonsense refused"] += 1

    def _decide(self, api: httpx2.Client) -> None:
        proposed = self._ask(api, "GET", "/v1/plans?state=proposed", may=(200,)).json()["items"]
        if proposed:
            verb = self._rng.choices(["approve", "reject"], [85, 15])[0]
            self._decide_on(api, self._rng.choice(proposed)["id"], verb)

    def _decide_on(self, api: httpx2.Client, plan_id: str, verb: str) -> None:
        self._order_to(api, f"/v1/plans/{plan_id}:{verb}", f"plans: {verb}")

    def _order(self, api: httpx2.Client, verb: str) -> None:
        if missions := self._missions():
            self._order_to(api, f"/v1/missions/{self._rng.choice(missions)}:{verb}", f"missions: {verb}")

    def _missions(self) -> list[str]:
        return [goal["mission_id"] for goal in self.observer.open if goal["mission_id"]]

    def _replan(self, api: httpx2.Client) -> None:
        """Have a mission planned again, half the time for a goal that waits, too, which may not be able to join it."""
        missions = self._missions()
        if not missions:
            return
        waiting = [goal["id"] for goal in self.observer.open if goal["state"] == "waiting"]
        joining = [self._rng.choice(waiting)] if waiting and self._rng.random() < 0.5 else []
        name = "missions: replan with a goal" if joining else "missions: replan"
        path = f"/v1/missions/{self._rng.choice(missions)}:replan"
        self._order_to(api, path, name, {"goals": joining}, may=(202, 409, 422) if joining else (202, 409))

    def _cancel_goal(self, api: httpx2.Client) -> None:
        if self.open:
            self._order_to(api, f"/v1/goals/{self._rng.choice(self.open)}:cancel", "goals: cancel")

    def _settle_mission(self, api: httpx2.Client, mission_id: str) -> None:
        mission = self._ask(api, "GET", f"/v1/missions/{mission_id}", may=(200,)).json()
        if mission["state"] == "paused":
            self._order_to(api, f"/v1/missions/{mission_id}:resume", "missions: resume")
        elif mission["recovery"]["step"] == "deciding":
            self._decide_on(api, mission["recovery"]["attempts"][-1]["plan_id"], "approve")
        elif mission["recovery"]["step"] == "stuck":
            self._order_to(api, f"/v1/missions/{mission_id}:cancel", "missions: cancel")

    def _order_to(
        self,
        api: httpx2.Client,
        path: str,
        name: str,
        body: Mapping[str, Any] | None = None,
        *,
        may: Sequence[int] = (202, 409),
    ) -> None:
        """Send an order, which may come too late (409)."""
        answer = self._ask(api, "POST", path, body, may=may)
        self.done[name if answer.status_code == 202 else "orders that came too late"] += 1

    def _ask(
        self,
        api: httpx2.Client,
        method: str,
        path: str,
        body: Mapping[str, Any] | None = None,
        *,
        may: Sequence[int],
        key: str | None = None,
    ) -> httpx2.Response:
        headers = {"idempotency-key": key} if key is not None else {}
        answer = api.request(method, path, json=body, headers=headers)
        if answer.status_code not in may:
            self.complaints.append(f"{method} {path}: {answer.status_code} {answer.text[:500]}")
        return answer
