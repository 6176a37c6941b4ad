"""Reads packages with ROS's own parser, and messages with an independent library of CDR.

Argument: the folder of the packages. Prints as JSON the hashes of all messages
and of those of ROS itself; then answers each
line (JSON: a type and the bytes of a message) with the value, and with the value encoded anew,
big endian.
"""

import json
import sys
from dataclasses import fields
from pathlib import Path
from xml.etree import ElementTree

import numpy
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosidl_adapter.parser import parse_action_file, parse_message_file, parse_service_file

root = Path(sys.argv[1])
store = get_typestore(Stores.EMPTY)
readers = {"msg": parse_message_file, "srv": parse_service_file, "action": parse_action_file}
interfaces = {}
for package in sorted(root.iterdir()):
    assert ElementTree.parse(package / "package.xml").find("name").text == package.name
    listed = (package / "CMakeLists.txt").read_text()
    for folder, read in readers.items():
        for path in sorted((package / folder).glob("*")):
            name = f"{package.name}/{folder}/{path.stem}"
            interfaces[name] = read(package.name, str(path))
            assert f'"{folder}/{path.name}"' in listed, f"{name} is not built"
            parts = path.read_text().split("---\n")
            suffixes = {"msg": [""], "srv": ["_Request", "_Response"]}
            for suffix, text in zip(
                suffixes.get(folder, ["_Goal", "_Result", "_Feedback"]), parts, strict=True
            ):
                store.register(get_types_from_msg(text, f"{package.name}/msg/{path.stem}{suffix}"))

messages = [name for name in interfaces if "/msg/" in name]
hashes = {name: store.hash_rihs01(name) for name in messages}
jazzy = get_typestore(Stores.ROS2_JAZZY)
standard = {name: jazzy.hash_rihs01(name) for name in jazzy.fielddefs}
# ROS's own hash treats the `char` in these as uint8, that of rosbags does not.
del standard["service_msgs/msg/ServiceEventInfo"], standard["std_msgs/msg/Char"]
print(
    json.dumps({"interfaces": sorted(interfaces), "hashes": hashes, "standard": standard}),
    flush=True,
)


def plain(value):
    """A message as what JSON knows."""
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [plain(one) for one in value]
    if hasattr(value, "__msgtype__"):
        # Fields are lower case, constants upper case.
        names = [field.name for field in fields(value) if field.name.islower()]
        names.remove("__msgtype__")
        return {name: plain(getattr(value, name)) for name in names}
    return value


for line in sys.stdin:
    asked = json.loads(line)
    value = store.deserialize_cdr(bytes.fromhex(asked["cdr"]), asked["type"])
    again = bytes(store.serialize_cdr(value, asked["type"], little_endian=False))
    print(json.dumps({"value": plain(value), "cdr": again.hex()}), flush=True)
