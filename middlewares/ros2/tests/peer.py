"""A DDS peer of another make: reads and writes the topic /demo/position as a ROS 2 node would.

Arguments: the domain, and `read` or `write`. One line out for each thing done.
"""

import os
import sys
from dataclasses import dataclass

DOMAIN = int(sys.argv[1])
os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain>
  <General>
    <Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>11</MaxAutoParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
</Domain></CycloneDDS>"""

from cyclonedds.core import Policy, Qos, ReadCondition, SampleState, ViewState, InstanceState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, sequence, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class State(IdlStruct, typename="demo::msg::dds_::State_"):
    count: uint64
    values: array[float64, 7]


@dataclass
class Short(IdlStruct, typename="demo::msg::dds_::State_"):
    """Goes by the name of a state, and ends too early."""

    count: uint64


def state(n):
    return State(count=n, values=[float(n + i) for i in range(7)])


def say(line):
    print(line, flush=True)


PLAIN = Policy.DataRepresentation(use_cdrv0_representation=True)
QOS = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.History.KeepLast(100),
    PLAIN,
)

participant = DomainParticipant(DOMAIN)


def read():
    topic = Topic(participant, "rt/demo/position", State)
    reader = DataReader(participant, topic, qos=QOS)
    any_state = SampleState.Any | ViewState.Any | InstanceState.Any
    waitset = WaitSet(participant)
    waitset.attach(ReadCondition(reader, any_state))
    while True:
        waitset.wait(duration(seconds=60))
        for sample in reader.take(N=100):
            if not isinstance(sample, State):
                continue
            assert sample.values == state(sample.count).values, sample
            say(f"sample {sample.count}")


def write():
    kinds = {"put": State, "short": Short}
    writers = {}
    for line in sys.stdin:
        verb, n = line.split()
        if verb not in writers:
            writers.clear()
            topic = Topic(participant, "rt/demo/position", kinds[verb])
            writers[verb] = DataWriter(participant, topic, qos=QOS)
            while not writers[verb].get_matched_subscriptions():
                pass_time()
        writers[verb].write(state(int(n)) if verb == "put" else Short(count=int(n)))
        say("done")


def pass_time():
    # Nothing tells of a match but asking.
    import time

    time.sleep(0.001)


{"read": read, "write": write}[sys.argv[2]]()
