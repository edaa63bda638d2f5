"""A robot that is not Macta's, on plain paho-mqtt, made by docs/robots.md alone. It "drives" by waiting."""
import json, sys, time  # noqa: E401, I001

from paho.mqtt.client import CallbackAPIVersion, Client, MQTTProtocolVersion
from paho.mqtt.properties import PacketTypes, Properties

HOST, PORT, WORLD, NAME, SHEET, PLACES = *sys.argv[1:5], *map(json.loads, sys.argv[5:])
TOPIC, here, job, kept, answers = f"macta/v1/{WORLD}/{NAME}", SHEET["start"][:2], {}, {}, {}
world = {"run": "", "time_s": 0.0, "rate": 0.0, "heard_s": 0.0}

def now_s():  # the world's time, rather late than early
    return world["time_s"] + 0.9 * world["rate"] * (time.monotonic() - world["heard_s"])

def say(kind, performative="inform", reply=None, channel="state", **body):
    said = {"id": f"{NAME}-{time.time_ns()}", "performative": performative, "sender": NAME, "receiver": "service",
            "sent_at_s": now_s(), "in_reply_to": reply, "body": {"kind": kind, "at_s": now_s(), **body}}
    properties = Properties(PacketTypes.PUBLISH)
    properties.UserProperty = [("run", world["run"])]
    sent = f"{TOPIC}/{channel}", json.dumps(said), 1, channel == "factsheet", properties
    (answers if reply else kept)[reply or said["id"]] = sent  # for requests that are repeated, until its receipt
    client.publish(*sent)

def hear(client, data, arrived):
    said, run = json.loads(arrived.payload), world["run"]
    if arrived.topic.endswith("/world"):
        world.update(said, heard_s=time.monotonic())
        if world["run"] != run:
            say("factsheet", channel="factsheet", **SHEET) if not run else sys.exit("the world began again")
    elif ("run", run) in arrived.properties.UserProperty:
        answer(said["body"], said["id"], said["in_reply_to"], **said["body"].get("script", {}))

def answer(body, asked, reply, id=None, packets=(), **_):
    script, kind, performative = id or body.get("script_id"), "acknowledgement", "agree"
    if body["kind"] in ("receipt", "factsheet_answer", "not_understood"):
        return kept.pop(reply, None)
    if asked in answers:  # a request is followed once
        return client.publish(*answers[asked])
    if packets and not job and {packet["tag"] for packet in packets} <= {*SHEET["repertoire"]}:
        job.update(id=id, packets=packets, cleared=[], end_s=0.0, state="finished")
    elif script == job.get("id") and (body["kind"] == "clearance" or body.get("verb") == "cancel"):
        job.update(cleared=[*job["cleared"], *body.get("ended", ())], state=("finished", "cancelled")["verb" in body])
    else:
        kind, performative = ("refusal", "refuse") if script else ("not_understood", "not-understood")
    say(kind, performative, asked, script_id=script, reason=f"busy, or not able to follow a {body['kind']}")

def wait(until):
    while not until() and job.get("state") != "cancelled":
        client.loop(time.sleep(0.1) or 0.1)
        pose = {"kind": "telemetry", "at_s": now_s(), "x_m": here[0], "y_m": here[1], "heading_rad": 0.0}
        [client.publish(*one) for one in ((f"{TOPIC}/visualization", json.dumps(pose)), *kept.values())]

client = Client(CallbackAPIVersion.VERSION2, protocol=MQTTProtocolVersion.MQTTv5)
client.on_message = hear
client.will_set(f"{TOPIC}/connection", '{"state": "connection_broken"}', 1, retain=True)
client.connect(HOST, int(PORT))
client.subscribe([(f"{TOPIC}/order", 1), (f"{TOPIC}/instantActions", 1), (f"macta/v1/{WORLD}/world", 1)])
client.publish(f"{TOPIC}/connection", '{"state": "online"}', 1, retain=True)
while True:
    wait(lambda: job)
    for packet, state in ((packet, state) for packet in job["packets"] for state in ("running", "finished")):
        wait(lambda after=packet["after"]: {*after} <= {*job["cleared"]} and now_s() >= job["end_s"])
        if job["state"] == "cancelled":
            break
        here[:] = PLACES.get(packet["arguments"].get("ref2"), here) if state == "finished" else here
        say("packet_report", script_id=job["id"], packet_id=packet["id"], state=state)
        job["end_s"] = now_s() + packet["expected_duration_s"] if state == "running" else 0.0
    say("script_report", {"cancelled": "failure"}.get(job["state"], "inform"), script_id=job["id"], state=job["state"])
    job.clear()
