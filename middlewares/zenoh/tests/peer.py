"""A zenoh peer that is not genomd: uses ports and services as the crate documentation describes.

Started by python_peer.rs with an endpoint and an action. Prints one line for each thing it sees.
"""

import json
import sys
import time
from dataclasses import dataclass

import zenoh
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, uint64


@dataclass
class State(IdlStruct, typename="demo::state"):
    count: uint64
    values: array[float64, 7]


def state(count):
    return State(count=count, values=[float(count + i) for i in range(7)]).serialize()


def number(payload):
    read = State.deserialize(payload.to_bytes())
    assert list(read.values) == [float(read.count + i) for i in range(7)], read
    return read.count


def say(*words):
    print(*words, flush=True)


def read(session):
    def arrives(sample):
        say("sample", number(sample.payload), sample.encoding, len(sample.attachment.to_bytes()))

    subscriber = session.declare_subscriber("demo/position", arrives)
    # The reply comes after the other side knows of the subscription.
    for reply in session.get("demo/position"):
        say("last", number(reply.ok.payload))
    sys.stdin.readline()
    subscriber.undeclare()


def write(session):
    publisher = session.declare_publisher("demo/position")
    while not publisher.matching_status.matching:
        time.sleep(0.001)
    for line in sys.stdin:
        words = line.split()
        if words[0] == "put":
            publisher.put(state(int(words[1])))
        elif words[0] == "broken":
            publisher.put(state(1)[: int(words[1])])
        elif words[0] == "other":
            publisher.put(state(1), encoding="application/cdr;demo::other;digest=0")
        say("done")


def ask(session, key, payload=None):
    for reply in session.get(
        key, payload=payload, consolidation=zenoh.ConsolidationMode.NONE, timeout=60
    ):
        if reply.ok is None:
            say("error", json.dumps(json.loads(reply.err.payload.to_bytes()), sort_keys=True))
            continue
        kind = reply.ok.attachment.to_string() if reply.ok.attachment else "-"
        if kind == "result":
            say(kind, number(reply.ok.payload), reply.ok.encoding)
        else:
            say(kind, reply.ok.payload.to_string())


def call(session):
    ask(session, "demo/add", state(5))
    ask(session, "demo/add", state(100))
    ask(session, "demo/add", state(5)[:20])
    for reply in session.get("demo/**", timeout=10):
        say("a wild card is no request", reply.ok)
    say("end")


def run(session):
    handler = session.get(
        "demo/goto", payload=state(7), consolidation=zenoh.ConsolidationMode.NONE, timeout=60
    )
    for reply in handler:
        if reply.ok is None:
            say("error", json.loads(reply.err.payload.to_bytes())["exception"])
            continue
        kind = reply.ok.attachment.to_string()
        text = reply.ok.payload.to_string() if kind != "result" else number(reply.ok.payload)
        say(kind, text)
        if text == "::demo::main":
            ask(session, "demo/goto/cancel", "7")
    ask(session, "demo/goto/cancel", "seven")
    say("end")


def serve(session):
    def answer(query):
        wanted = number(query.payload)
        if wanted == 100:
            query.reply_err(json.dumps({"exception": "::demo::TOO_FAR_AWAY", "detail": {"d": 1}}))
        elif wanted == 101:
            query.reply_err("out of order")
        elif wanted == 102:
            query.reply(query.key_expr, state(1)[:9])
        else:
            query.reply(query.key_expr, state(wanted + 1000))

    queryable = session.declare_queryable("demo/add", answer)
    say("ready")
    sys.stdin.readline()
    queryable.undeclare()


def main():
    endpoint, what = sys.argv[1:]
    config = zenoh.Config()
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("listen/endpoints", "[]")
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        {"read": read, "write": write, "call": call, "run": run, "serve": serve}[what](session)


main()
