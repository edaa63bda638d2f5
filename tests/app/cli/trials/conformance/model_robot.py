"""A robot that keeps every rule of the contract but those that it is told to break, in time that is stepped."""

import json
from collections.abc import Sequence
from typing import Any

from app.cli.trials.conformance.rules import Rule
from robots.link.mqtt.session import Publication

TOPIC = "macta/v1/check/fred/"
RESEND_S = 1.0
KNOWN = ("script_request", "control", "clearance", "status_query", "receipt", "factsheet_answer")


class ModelRobot:
    """Implements the check's `Broker` with itself at the other end: a call of `receive` steps the time.

    It is the check's `Relay`, too.
    """

    address = "127.0.0.1:1884"

    def __init__(self, breaks: Rule | None = None, *, connections: int = 1) -> None:
        """:param connections: through the relay."""
        self._breaks = breaks
        self._connections = connections
        self._is_cut = False
        self._now_s = 0.0
        self._out: list[Publication] = []
        self._sent = 0
        self._answers: dict[str, bytes] = {}
        self._kept: dict[str, list[Any]] = {}
        self._ended: dict[str, str] = {}
        self._job: dict[str, Any] = {}
        self._telemetry_s = 0.0
        if breaks is not Rule.CONNECTION:
            self._say_bare("connection", {"state": "online"}, retain=True)
        if breaks is not Rule.ANNOUNCES:
            sheet = {"repertoire": ["NAVIGATE"], "speed_m_s": 1.0, "turn_rad_s": 1.0}
            self._say("inform", {"kind": "factsheet", **sheet}, channel="factsheet")

    def now_s(self) -> float:
        return self._now_s

    def cut(self) -> int:
        """What is on its way arrives, then the broker tells of its last will."""
        if self._connections and self._breaks is not Rule.LAST_WILL:
            self._say_bare("connection", {"state": "connection_broken"}, retain=True)
        self._is_cut = self._connections > 0
        return self._connections

    def restore(self) -> None:
        """It is connected at once."""
        if self._is_cut:
            self._is_cut = False
            self._say_bare("connection", {"state": "online"}, retain=True)

    def publish(self, publication: Publication) -> None:
        """The check says something."""
        if self._is_cut:
            return
        said = json.loads(publication.payload)
        is_ours = publication.run == "run-of-the-check" or self._breaks is Rule.OTHER_RUNS
        if is_ours:
            self._hear(said, said["body"])

    def receive(self, timeout_s: float) -> Sequence[Publication]:
        self._now_s += timeout_s
        if self._is_cut:
            arrived, self._out = self._out, []
            if self._breaks is not Rule.RECONNECTS:
                self._work(timeout_s)
            self._out = []
            return arrived
        self._work(timeout_s)
        if self._now_s - self._telemetry_s >= 0.5:
            self._telemetry_s = self._now_s
            pose = {"kind": "telemetry", "at_s": self._now_s, "x_m": 0, "y_m": 0, "heading_rad": 0}
            if self._breaks is Rule.TELEMETRY:
                pose["x_m"] = "far"
            self._say_bare("visualization", pose)
        for kept in self._kept.values():
            if self._now_s - kept[0] >= RESEND_S and self._breaks is not Rule.RECEIPTS:
                kept[0] = self._now_s
                self._out.append(kept[1])
        arrived, self._out = self._out, []
        return arrived

    def _say_bare(self, channel: str, payload: dict[str, Any], *, retain: bool = False) -> None:
        self._out.append(
            Publication(
                topic=TOPIC + channel,
                payload=json.dumps(payload).encode(),
                qos=0 if channel == "visualization" and self._breaks is not Rule.QOS else 1,
                retain=retain and self._breaks is not Rule.RETAINED,
            )
        )

    def _say(
        self, performative: str, body: dict[str, Any], reply: str | None = None, channel: str = "state"
    ) -> None:
        self._sent += 1
        wrong = self._breaks is Rule.WELL_FORMED and body["kind"] == "status_report"
        said = {
            "id": f"fred-{self._sent}",
            "performative": performative,
            "sender": "ginger" if wrong else "fred",
            "receiver": "service",
            "sent_at_s": self._now_s,
            "in_reply_to": reply,
            "body": body,
        }
        publication = Publication(
            topic=TOPIC + channel,
            payload=json.dumps(said).encode(),
            run="run-of-the-check",
            retain=channel == "factsheet",
        )
        if reply is None:
            self._kept[f"fred-{self._sent}"] = [self._now_s, publication]
        else:
            self._answers[reply] = publication.payload
        self._out.append(publication)

    def _hear(self, said: dict[str, Any], body: dict[str, Any]) -> None:
        kind = body["kind"]
        asked = said["id"]
        if kind == "receipt":
            self._kept.pop(said["in_reply_to"], None)
        elif self._breaks is Rule.UNKNOWN_FIELDS and "of_tomorrow" in body:
            return
        elif kind not in KNOWN:
            if self._breaks is not Rule.UNKNOWN_KINDS:
                self._say(
                    "not-understood", {"kind": "not_understood", "reason": f"unknown kind {kind}"}, asked
                )
        elif asked in self._answers:
            if self._breaks is Rule.ONCE and kind == "script_request":
                self._job["step"] = 0
                self._job["left_s"] = None
            self._out.append(
                Publication(topic=TOPIC + "state", payload=self._answers[asked], run="run-of-the-check")
            )
        elif kind == "status_query":
            if self._breaks is not Rule.STATUS:
                self._say("inform", self._status(body["script_id"]), asked)
        elif kind != "factsheet_answer":
            self._answer(said, body)

    def _status(self, script: str) -> dict[str, Any]:
        state = "running" if self._job.get("id") == script else self._ended.get(script)
        return {"kind": "status_report", "script_id": script, "state": state, "at_s": self._now_s}

    def _answer(self, said: dict[str, Any], body: dict[str, Any]) -> None:
        script = body["script"]["id"] if "script" in body else body["script_id"]
        ended_before = set(self._ended)
        reason = self._obey(script, body)
        if reason is None:
            if not (self._breaks is Rule.ACKNOWLEDGES and body["kind"] == "script_request"):
                self._say("agree", {"kind": "acknowledgement", "script_id": script}, said["id"])
        else:
            self._say("refuse", {"kind": "refusal", "script_id": script, "reason": reason}, said["id"])
        for one in self._ended.keys() - ended_before:
            if self._breaks is not Rule.CANCELS:
                self._say("failure", {**self._about(one), "kind": "script_report", "state": "cancelled"})

    def _about(self, script: str) -> dict[str, Any]:
        return {"script_id": script, "at_s": self._now_s}

    def _obey(self, script: str, body: dict[str, Any]) -> str | None:
        """Do what is asked; why not, if that cannot be done."""
        if body["kind"] == "script_request":
            return self._take(body["script"])
        if body.get("verb") == "cancel" and script not in (self._job.get("id"), *self._ended):
            self._ended[script] = "cancelled"
            return None
        if script != self._job.get("id"):
            return "not the current script"
        if body["kind"] == "clearance":
            if self._breaks is not Rule.CLEARANCE:
                self._job["cleared"] |= set(body["ended"])
            return None
        return self._follow(script, body["verb"], body["number"])

    def _follow(self, script: str, verb: str, number: int) -> str | None:
        """Follow an order on the current script; why not, if that cannot be done."""
        if verb == "cancel":
            self._ended[script] = "cancelled"
            self._job = {}
            return None
        if number < self._job["order"] and self._breaks is not Rule.ORDER_NUMBERS:
            return "overtaken"
        self._job["order"] = max(self._job["order"], number)
        stays = self._breaks is (Rule.PAUSES if verb == "pause" else Rule.RESUMES)
        if not stays:
            self._job["paused"] = verb == "pause"
            self._report("paused" if verb == "pause" else "running")
        return None

    def _take(self, script: dict[str, Any]) -> str | None:
        if script["id"] in self._ended and self._breaks is not Rule.STALE:
            return "stale"
        tags = {packet["tag"] for packet in script["packets"]}
        if tags - {"NAVIGATE"} and self._breaks is not Rule.REFUSES:
            return "no such packet"
        self._job = {
            **script,
            "step": 0,
            "left_s": None,
            "cleared": set(),
            "paused": False,
            "order": 0,
        }
        return None

    def _report(self, state: str) -> None:
        packet = self._job["packets"][self._job["step"]]
        body = {"kind": "packet_report", "packet_id": packet["id"], "state": state}
        self._say("inform", {**self._about(self._job["id"]), **body})

    def _work(self, step_s: float) -> None:
        job = self._job
        if not job or job["paused"] or job["packets"][job["step"]]["tag"] != "NAVIGATE":
            return
        packet = job["packets"][job["step"]]
        if job["left_s"] is None:
            if set(packet["after"]) <= job["cleared"] or self._breaks is Rule.CLEARANCE:
                job["left_s"] = packet["expected_duration_s"]
                if self._breaks is not Rule.IN_ORDER or job["step"] == 0:
                    self._report("running")
            return
        job["left_s"] -= step_s
        if job["left_s"] > 0:
            return
        self._report("finished")
        job["step"] += 1
        job["left_s"] = None
        if job["step"] == len(job["packets"]):
            self._ended[job["id"]] = "finished"
            self._say("inform", {**self._about(job["id"]), "kind": "script_report", "state": "finished"})
            self._job = {}
