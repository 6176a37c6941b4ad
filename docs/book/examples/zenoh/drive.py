"""Drives the demo with nothing but zenoh: python3 drive.py ENDPOINT."""

import json
import struct
import sys

import zenoh

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
config.insert_json5("scouting/multicast/enabled", "false")


def position(payload):
    """Of ::demo::state in CDR: a header of 4 bytes, then two doubles."""
    return struct.unpack_from("<dd", payload.to_bytes(), 4)[0]


with zenoh.open(config) as session:
    # A port: its last value, then every new one.
    for reply in session.get("demo/position"):
        print("at", position(reply.ok.payload))
    samples = session.declare_subscriber("demo/position")

    # An activity: a `get` with the inputs in CDR. Replies say how far it is.
    goal = b"\x00\x01\x00\x00" + struct.pack("<d", 0.25)
    replies = session.get(
        "demo/goto", payload=goal, consolidation=zenoh.ConsolidationMode.NONE, timeout=60
    )
    for reply in replies:
        kind = reply.ok.attachment.to_string()
        if kind != "feedback":
            print(kind)

    for sample in samples:
        if position(sample.payload) == 0.25:
            break
    print("at", position(sample.payload))
