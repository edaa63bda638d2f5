"""A door that is not Macta's, on plain paho-mqtt. It "moves" by waiting, or not at all if it is told WHY not."""
import json, sys, time  # noqa: E401, I001
from paho.mqtt import properties, subscribe

HOST, PORT, WORLD, NAME, DOOR, WHY = *sys.argv[1:5], json.loads(sys.argv[5]), "".join(sys.argv[6:])
TOPIC, CLOCK, ENDS, job, sent = f"macta/v1/{WORLD}/{NAME}", f"macta/v1/{WORLD}/world", {"finished": "inform"}, {}, {}
world = json.loads(subscribe.simple(CLOCK, hostname=HOST, port=int(PORT)).payload)
run = properties.Properties(properties.PacketTypes.PUBLISH)
run.UserProperty = ("run", world["run"])

def say(kind, performative="inform", reply=None, channel="state", **body):
    said = {"id": f"{NAME}-{time.time_ns()}", "performative": performative, "sender": NAME, "receiver": "service",
            "sent_at_s": world["time_s"], "in_reply_to": reply, "body": {"kind": kind, "at_s": world["time_s"], **body}}
    return sent.setdefault(reply or said["id"], (f"{TOPIC}/{channel}", json.dumps(said), 1, kind == "factsheet", run))

def hear(client, data, arrived):
    said = json.loads(arrived.payload)
    if arrived.topic == CLOCK:  # once a second: its clock
        world.update(said) if said["run"] == world["run"] else sys.exit("the world began again")
        if job.get("steps") and world["time_s"] >= job["end_s"] and {*job["steps"][0][0]["after"]} <= {*job["cleared"]}:
            packet, state = job["steps"].pop(0)
            say("packet_report", script_id=job["id"], packet_id=packet["id"], state=state)
            job["end_s"] = world["time_s"] + packet["expected_duration_s"] * (state == "running")
        if job and not job["steps"]:
            say("script_report", ENDS.get(job["state"], "failure"), script_id=job["id"], state=job["state"], detail=WHY)
            job.clear()
        pose = {"at_s": said["time_s"], "x_m": DOOR["start"][0], "y_m": DOOR["start"][1], "heading_rad": 0.0}
        own = (f"{TOPIC}/connection", '{"state": "online"}', 1, True), (f"{TOPIC}/visualization", json.dumps(pose))
        [client.publish(*one) for one in (*own, *(sent[id] for id in sent if id.startswith(NAME)))]
    elif not sent.pop(said["in_reply_to"], said["in_reply_to"]) and arrived.properties.UserProperty == run.UserProperty:
        client.publish(*answer(said["id"], **said["body"]))

def answer(asked, kind, script=None, script_id=None, ended=(), verb=None, **_):
    if kind == "script_request" and not job and asked not in sent:
        steps = [] if WHY else [(packet, state) for packet in script["packets"] for state in ("running", "finished")]
        job.update(id=script["id"], state="failed" if WHY else "finished", steps=steps, cleared=(), end_s=0.0)
    elif script_id == job.get("id") and (kind == "clearance" or verb == "cancel"):
        job.update(cleared=ended, state="cancelled" if verb else job["state"], steps=[] if verb else job["steps"])
    elif asked not in sent:
        return say("not_understood", "not-understood", asked, reason=f"busy, or no {kind} is known")
    return say("acknowledgement", "agree", asked, script_id=job.get("id"))

say("factsheet", channel="factsheet", number=1, repertoire=["OPEN", "CLOSE"], peripheral=DOOR)
subscribe.callback(hear, [CLOCK, f"{TOPIC}/order", f"{TOPIC}/instantActions"], 1, None, HOST, int(PORT), protocol=5,
    clean_session=None, will={"topic": f"{TOPIC}/connection", "payload": '{"state": "connection_broken"}', "retain": 1})
