"""What `ros2_many.py` has a program read that is no genomd: topics of components, and /diagnostics.

Arguments: the domain; `dds` or `zenoh`; the router's endpoint; the components whose positions are read.
Prints what came until the standard input ended, and within 30 s more at most what was missing.
"""

import os
import struct
import sys
import threading
import time

DOMAIN, RMW, ROUTER, FEW = int(sys.argv[1]), sys.argv[2], sys.argv[3], sys.argv[4:]
BEGIN = time.monotonic()
positions, statuses, arrays, sizes = {}, {}, [], []


class Cdr:
    """Little-endian, version 1."""

    def __init__(self, body):
        self.body, self.at = body, 0

    def number(self):
        self.at = (self.at + 3) // 4 * 4
        self.at += 4
        return struct.unpack_from("<I", self.body, self.at - 4)[0]

    def octet(self):
        self.at += 1
        return self.body[self.at - 1]

    def text(self):
        length = self.number()
        self.at += length
        return self.body[self.at - length : self.at - 1].decode()


def heard(names, size):
    now = time.monotonic() - BEGIN
    arrays.append((now, len(names)))
    sizes.append(size)
    for name in names:
        statuses.setdefault(name, []).append(now)


def over_zenoh():
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["{ROUTER}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)

    def diagnosed(sample):
        body = bytes(sample.payload)
        cdr = Cdr(body[4:])
        cdr.number(), cdr.number(), cdr.text()
        names = []
        for _ in range(cdr.number()):
            cdr.octet()
            names.append(cdr.text())
            cdr.text(), cdr.text()
            for _ in range(cdr.number()):
                cdr.text(), cdr.text()
        heard(names, len(body))

    def moved(sample):
        positions.setdefault(str(sample.key_expr).split("/")[1], []).append(bytes(sample.payload))

    subscribers = [session.declare_subscriber(f"{DOMAIN}/diagnostics/**", diagnosed)]
    for name in FEW:
        subscribers.append(session.declare_subscriber(f"{DOMAIN}/{name}/position/**", moved))
    return session, subscribers


def over_dds():
    os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain>
      <General>
        <Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
        <AllowMulticast>false</AllowMulticast>
      </General>
      <Discovery>
        <ParticipantIndex>auto</ParticipantIndex>
        <MaxAutoParticipantIndex>110</MaxAutoParticipantIndex>
        <Peers><Peer address="127.0.0.1"/></Peers>
      </Discovery>
    </Domain></CycloneDDS>"""
    from dataclasses import dataclass

    from cyclonedds.core import Listener, Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import IdlStruct
    from cyclonedds.idl.types import float64, int32, sequence, uint8, uint32
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    def typename(name):
        return {"typename": name}

    @dataclass
    class State(IdlStruct, typename="demo::msg::dds_::State_"):
        position: float64
        velocity: float64

    @dataclass
    class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
        key: str
        value: str

    @dataclass
    class Status(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
        level: uint8
        name: str
        message: str
        hardware_id: str
        values: sequence[KeyValue]

    @dataclass
    class Array(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
        sec: int32
        nanosec: uint32
        frame_id: str
        status: sequence[Status]

    class Taken(Listener):
        def __init__(self, take):
            super().__init__()
            self.take = take

        def on_data_available(self, reader):
            for sample in reader.take(N=1000):
                if not hasattr(sample, "sample_info") or sample.sample_info.valid_data:
                    self.take(sample)

    def qos(depth, *more):
        return Qos(
            Policy.Reliability.Reliable(duration(seconds=1)),
            Policy.History.KeepLast(depth),
            Policy.DataRepresentation(use_cdrv0_representation=True),
            *more,
        )

    participant = DomainParticipant(DOMAIN)
    topic = Topic(participant, "rt/diagnostics", Array)

    def diagnosed(sample):
        size = sum(
            len(one.name) + len(one.message) + sum(len(v.key) + len(v.value) for v in one.values)
            for one in sample.status
        )
        heard([one.name for one in sample.status], size)

    readers = [DataReader(participant, topic, qos(10), listener=Taken(diagnosed))]
    for name in FEW:

        def moved(sample, name=name):
            positions.setdefault(name, []).append(sample)

        topic = Topic(participant, f"rt/{name}/position", State)
        readers.append(DataReader(participant, topic, qos(100), listener=Taken(moved)))
    return participant, readers


kept = over_dds() if RMW == "dds" else over_zenoh()
ended = threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
ended.wait()
end = time.monotonic() + 30
while len(positions) < len(FEW) and time.monotonic() < end:
    time.sleep(0.1)
counts = {name: len(positions.get(name, [])) for name in FEW}
print(f"  peer: samples of {counts}")
span = arrays[-1][0] - arrays[0][0] if arrays else 0
if span > 0:
    rounds = sorted(len(times) for times in statuses.values())
    tasks = sum(": cell " not in name for name in statuses)
    print(
        f"  peer: /diagnostics, {span:.1f} s: {len(arrays)} messages ({len(arrays) / span:.1f} a second),"
        f" up to {max(count for _, count in arrays)} statuses and {max(sizes)} bytes each;"
        f" names: {tasks} of tasks, {len(statuses) - tasks} of cells;"
        f" each told {rounds[0]} to {rounds[-1]} times, median {rounds[len(rounds) // 2]}"
    )
else:
    print("  peer: nothing on /diagnostics")
sys.stdout.flush()
# Closing a session may wait for long.
os._exit(0)
