"""A foreign DDS peer that reads and writes the topic /demo/position as a ROS 2 node would.

Arguments: the domain; `read`, `write`, `call` or `mirror`; then QoS that differs from the default:
`best_effort`, `transient_local`. Prints one line for each action.
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
from cyclonedds.idl.types import array, float64, int16, int64, uint8, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class State(IdlStruct, typename="demo::msg::dds_::State_"):
    count: uint64
    values: array[float64, 7]


@dataclass
class Cut(IdlStruct, typename="demo::msg::dds_::State_"):
    """Has the name of the state type, but lacks its last members."""

    count: uint64


@dataclass
class Request(IdlStruct, typename="demo::srv::dds_::Goto_Request_"):
    """Begins with the header that rmw_cyclonedds puts before the fields."""

    client: uint64
    number: int64
    count: uint64
    values: array[float64, 7]


@dataclass
class Response(IdlStruct, typename="demo::srv::dds_::Goto_Response_"):
    client: uint64
    number: int64
    genom_exception: str
    genom_detail: str
    count: uint64
    values: array[float64, 7]


def state(n):
    return State(count=n, values=[float(n + i) for i in range(7)])


def say(line):
    print(line, flush=True)


PLAIN = Policy.DataRepresentation(use_cdrv0_representation=True)
QOS = Qos(
    Policy.Reliability.BestEffort
    if "best_effort" in sys.argv
    else Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.Durability.TransientLocal
    if "transient_local" in sys.argv
    else Policy.Durability.Volatile,
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
    # `early`: writes without waiting for a reader.
    kinds = {"put": State, "early": State, "short": Cut}
    writers = {}
    for line in sys.stdin:
        verb, n = line.split()
        if verb not in writers:
            writers.clear()
            topic = Topic(participant, "rt/demo/position", kinds[verb])
            writers[verb] = DataWriter(participant, topic, qos=QOS)
            while verb != "early" and not writers[verb].get_matched_subscriptions():
                pass_time()
        writers[verb].write(Cut(count=int(n)) if verb == "short" else state(int(n)))
        say("done")


def call():
    requests = DataWriter(participant, Topic(participant, "rq/demo/gotoRequest", Request), qos=QOS)
    replies = DataReader(participant, Topic(participant, "rr/demo/gotoReply", Response), qos=QOS)
    while not (requests.get_matched_subscriptions() and replies.get_matched_publications()):
        pass_time()
    any_state = SampleState.Any | ViewState.Any | InstanceState.Any
    waitset = WaitSet(participant)
    waitset.attach(ReadCondition(replies, any_state))
    for number, line in enumerate(sys.stdin):
        n = int(line)
        requests.write(Request(client=77, number=number, **vars(state(n))))
        answered = False
        while not answered:
            waitset.wait(duration(seconds=60))
            for reply in replies.take(N=10):
                if isinstance(reply, Response) and (reply.client, reply.number) == (77, number):
                    answered = True
                    if reply.genom_exception:
                        say(f"{reply.genom_exception} {reply.genom_detail}")
                    else:
                        assert reply.values == state(reply.count).values, reply
                        say(f"reply {reply.count}")


@dataclass
class Octet(IdlStruct, typename="demo::msg::dds_::Octet_"):
    it: uint8


@dataclass
class Truth(IdlStruct, typename="demo::msg::dds_::Truth_"):
    it: bool


@dataclass
class Short(IdlStruct, typename="demo::msg::dds_::Short_"):
    it: int16


@dataclass
class Triple(IdlStruct, typename="demo::msg::dds_::Triple_"):
    it: array[uint8, 3]


def mirror():
    """Copies /demo/NAME to /mirror/NAME, for types smaller than 4 bytes."""
    any_state = SampleState.Any | ViewState.Any | InstanceState.Any
    waitset, ends = WaitSet(participant), []
    for kind in Octet, Truth, Short, Triple:
        name = kind.__name__.lower()
        reader = DataReader(participant, Topic(participant, f"rt/demo/{name}", kind), qos=QOS)
        writer = DataWriter(participant, Topic(participant, f"rt/mirror/{name}", kind), qos=QOS)
        while not writer.get_matched_subscriptions():
            pass_time()
        waitset.attach(ReadCondition(reader, any_state))
        ends.append((kind, reader, writer))
    while True:
        waitset.wait(duration(seconds=60))
        for kind, reader, writer in ends:
            for sample in reader.take(N=100):
                if isinstance(sample, kind):
                    say(f"{kind.__name__} {sample.it}")
                    writer.write(sample)


def pass_time():
    # Matches are not signalled, so they must be polled.
    import time

    time.sleep(0.001)


{"read": read, "write": write, "call": call, "mirror": mirror}[sys.argv[2]]()
