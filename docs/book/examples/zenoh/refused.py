"""A service that refuses: python3 refused.py ENDPOINT."""

import json
import struct
import sys

import zenoh

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
config.insert_json5("scouting/multicast/enabled", "false")

with zenoh.open(config) as session:
    speed = b"\x00\x01\x00\x00" + struct.pack("<d", 99.0)
    for reply in session.get("demo/set_speed", payload=speed):
        error = json.loads(reply.err.payload.to_bytes())
        print(error["exception"], "at most", error["detail"]["upper"])
