"""Past missions for a service, each a copy of one that was really carried out."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx2
from sqlalchemy import select

from app.store import Database, GoalRow, MissionRow, PlanRow, ScriptRow
from benchmarks.capacity import copied

GIVE_UP_S = 180.0


def carry_out(api: httpx2.Client, text: str) -> None:
    """State a goal and wait until its mission has ended."""
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).raise_for_status().json()["id"]
    until(api, f"/v1/goals/{goal}", lambda known: known["state"] == "finished")


def fill(data: Path, missions: int) -> None:
    """Copy the record's only mission until there are `missions`."""
    database = Database(f"sqlite:///{data / 'macta.sqlite'}")
    with database.write() as session:
        goal, plan, mission = (session.scalars(select(one)).one() for one in (GoalRow, PlanRow, MissionRow))
        scripts = session.scalars(select(ScriptRow)).all()
        for number in range(1, missions):
            when = {
                "created_at": f"2026-01-01T{number // 3600:02}:{number // 60 % 60:02}:{number % 60:02}.000Z"
            }
            of: dict[str, Any] = {"goal_id": f"goal-{number}", "plan_id": f"plan-{number}"}
            name = f"mission-{number:x}"
            session.add(copied(goal, id=of["goal_id"], plan_id=of["plan_id"], mission_id=name, **when))
            session.flush()
            session.add(copied(plan, id=of["plan_id"], goal_id=of["goal_id"], **when))
            session.flush()
            session.add(copied(mission, id=name, workflow=name, **of, **when))
            session.flush()
            for script in scripts:
                session.add(
                    copied(script, id=f"{name}:{script.robot}", mission_id=name, plan_id=of["plan_id"])
                )
    database.close()


class Traffic:
    """Causes events as an operator could: of a paused mission and of the world model, in turn."""

    def __init__(self, api: httpx2.Client, world: str) -> None:
        self._api, self._facts, self._turn = api, f"/v1/worlds/{world}/facts", 0
        self._mission = paused(api, "move sample_2 to bay_3")

    def cause(self) -> None:
        """Cause one or two more events."""
        self._turn += 1
        place, policy = ("bay_12", "ask") if self._turn % 4 < 2 else ("bay_11", "never")
        if self._turn % 2:
            lies = {"predicate": "in", "args": ["sample_4", place]}
            self._api.put(self._facts, json={"facts": [lies]}).raise_for_status()
        else:
            path = f"/v1/missions/{self._mission}/recovery"
            self._api.put(path, json={"policy": policy}).raise_for_status()


def paused(api: httpx2.Client, text: str) -> str:
    """Start and pause a mission; its id."""
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).raise_for_status().json()["id"]
    mission = until(api, f"/v1/goals/{goal}", lambda known: known["mission_id"])["mission_id"]
    until(api, f"/v1/missions/{mission}", lambda known: known["state"] == "running")
    api.post(f"/v1/missions/{mission}:pause", json={}).raise_for_status()
    until(api, f"/v1/missions/{mission}", lambda known: known["state"] == "paused")
    return str(mission)


def until(api: httpx2.Client, path: str, holds: Callable[[dict[str, Any]], Any]) -> dict[str, Any]:
    """:raises TimeoutError: if it does not hold in time."""
    give_up = time.monotonic() + GIVE_UP_S
    while not holds(known := api.get(path).raise_for_status().json()):
        if time.monotonic() > give_up:
            raise TimeoutError(f"{path} stays {known}")
        time.sleep(0.1)
    return known
