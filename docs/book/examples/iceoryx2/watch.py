"""Watches the demo move with nothing but iceoryx2: python3 watch.py PREFIX ROOT."""

import ctypes
import sys
import time

import iceoryx2 as iox2


class State(ctypes.Structure):
    """The type ::demo::state of the description, in its C layout."""

    _fields_ = [("position", ctypes.c_double), ("velocity", ctypes.c_double)]

    @staticmethod
    def type_name():
        return "demo::state"


prefix, root = sys.argv[1:]
config = iox2.config.default()
config.global_cfg.prefix = iox2.FileName.new(prefix)
config.global_cfg.root_path = iox2.Path.new(root)
node = iox2.NodeBuilder.new().config(config).create(iox2.ServiceType.Ipc)

name = iox2.ServiceName.new("demo/position")
port = node.service_builder(name).publish_subscribe(State).open()
reader = port.subscriber_builder().create()
print("watching", flush=True)
while True:
    sample = reader.receive()
    if sample is None:
        time.sleep(0.001)  # shared memory wakes nobody
    elif sample.payload().contents.position == 0.25:
        print("arrived")
        break
