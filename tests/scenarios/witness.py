"""A client that comes through whatever befalls a service, and notes what it is told."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import httpx2

from app.cli.trials.observer import Observer

WORLD = "sample_store"
DEADLINE_S = 5000.0


@dataclass
class Witness:
    """States goals under idempotency keys until they are accepted, and notes what it is told of them.

    :param goals: by idempotency key, the sentence.
    :param by_hand: keys of the goals whose plans it approves itself; the others are approved automatically.
    """

    goals: Mapping[str, str]
    by_hand: frozenset[str] = frozenset()
    accepted: dict[str, str] = field(default_factory=dict)
    """Goals' ids by their keys."""
    decided: dict[str, str] = field(default_factory=dict)
    """The missions that the plans it approved were said to have, by plan."""
    observer: Observer = field(default_factory=lambda: Observer(WORLD))

    @property
    def final(self) -> list[dict[str, Any]]:
        """The goals as they were seen last."""
        return list(self.observer.goals.values())

    @property
    def over(self) -> bool:
        return len(self.final) == len(self.goals) and not self.observer.open

    def state_goals(self, api: httpx2.Client) -> None:
        """All of them, those that are accepted once more."""
        for key, text in self.goals.items():
            automatic = key not in self.by_hand
            body = {"world": WORLD, "text": text, "auto_approve": automatic, "deadline_s": DEADLINE_S}
            answer = api.post("/v1/goals", json=body, headers={"idempotency-key": key})
            answer.raise_for_status()
            goal_id = answer.json()["id"]
            assert self.accepted.setdefault(key, goal_id) == goal_id

    def look(self, api: httpx2.Client, clock: str = WORLD) -> None:
        """Note how everything stands, and decide what waits for it.

        :param clock: which clock is read here: replicas follow the world's each with one of its own.
        """
        self.observer.read(api, self.accepted.values(), clock=clock)
        for key, goal_id in self.accepted.items():
            goal = self.observer.goals[goal_id]
            if key in self.by_hand and goal["state"] == "planned":
                self._approve(api, goal["plan_id"])

    def _approve(self, api: httpx2.Client, plan: str) -> None:
        answer = api.post(f"/v1/plans/{plan}:approve")
        if answer.status_code == 409:  # overtaken by another mission; another plan will be proposed
            return
        answer.raise_for_status()
        mission = answer.json()["mission_id"]
        assert self.decided.setdefault(plan, mission) == mission
