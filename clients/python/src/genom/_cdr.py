"""Encodes and decodes values of ports as CDR (XCDR1).

The daemon describes the types. Values have the same form in Python as in its JSON, and as over
shared memory.
"""

from __future__ import annotations

import array
import math
import struct
from typing import Any, Callable, Dict, List, Optional, Tuple

from . import _numbers

_NUMBERS = {
    "boolean": "?", "octet": "B", "short": "h", "unsigned short": "H", "long": "i",
    "unsigned long": "I", "long long": "q", "unsigned long long": "Q", "float": "f", "double": "d",
}
# Plain CDR, little endian. Received messages may be big endian.
_HEADER = b"\0\1\0\0"

Write = Callable[[bytearray, Any], None]
Read = Callable[[bytes, int], Tuple[Any, int]]


class Cdr:
    """Encodes and decodes values of one type."""

    def __init__(self, layout: Dict[str, Any], buffers: bool = False) -> None:
        """With ``buffers``, arrays and sequences of numbers are decoded to `memoryview`."""
        self._buffers = buffers
        self._types: List[Dict[str, Any]] = layout["types"]
        # Members of the same numeric kind in a row are read as one.
        codes = ((at, _numbers.CODES.get(one["kind"])) for at, one in enumerate(self._types))
        self._bulky: Dict[int, str] = {at: code for at, code in codes if code is not None}
        self._writers: Dict[int, Write] = {}
        self._readers: Dict[Tuple[int, str], Read] = {}
        self._write = self._writer(0)
        self._read = {order: self._reader(0, order) for order in "<>"}

    def encode(self, value: Any) -> bytes:
        """Encodes a whole value as a message."""
        out = bytearray(_HEADER)
        self._write(out, value)
        return bytes(out)

    def decode(self, message: bytes) -> Any:
        """Decodes a message."""
        if message[:2] not in (b"\0\0", b"\0\1"):
            raise ValueError("the message is no plain CDR")
        return self._read["<" if message[1] else ">"](message[4:], 0)[0]

    def zero(self, at: int = 0) -> Any:
        """The value before anybody has written one: zeros."""
        one = self._types[at]
        kind = one["kind"]
        if kind in ("struct", "exception"):
            return {m["name"]: self.zero(m["type"]) for m in one["members"]}
        if kind == "array":
            return [self.zero(one["element"]) for _ in range(one["length"])]
        if kind == "union":
            switch = self.zero(one["discriminant"])
            member = self._member(one, switch)
            return {"d": switch, "u": {} if member is None else {member["name"]: self.zero(member["type"])}}
        if kind == "enum":
            return one["enumerators"][0]
        named: Dict[str, Any] = {"string": "", "char": "\0", "sequence": [], "optional": None, "boolean": False}
        return named.get(kind, 0)

    def merge(self, old: Any, new: Any, at: int = 0) -> Any:
        """The old value, updated by the new one: members, or elements by index."""
        one = self._types[at]
        kind = one["kind"]
        if kind in ("struct", "exception"):
            types = {m["name"]: m["type"] for m in one["members"]}
            merged = dict(old)
            for name, inner in new.items():
                if name not in types:
                    raise ValueError(f"{one['name']} has no member `{name}`; it has: {', '.join(types)}")
                merged[name] = self.merge(old[name], inner, types[name])
            return merged
        if kind == "array":
            if one["element"] in self._bulky and not isinstance(new, dict):
                numbers = _numbers.kept(new)
                view = _numbers.buffer(numbers)
                if (len(numbers) if view is None else view.nbytes // view.itemsize) == one["length"]:
                    return numbers
                new = _numbers.flat(numbers)
            elif _numbers.buffer(new) is not None:
                new = new.tolist()
            given = new.items() if isinstance(new, dict) else enumerate(new)
            elements = list(old)
            for index, inner in given:
                if not 0 <= int(index) < one["length"]:
                    raise ValueError(f"there is no element {index}, only {one['length']}")
                elements[int(index)] = self.merge(elements[int(index)], inner, one["element"])
            return elements
        if kind == "sequence":
            return _numbers.kept(new)
        if kind == "float" or kind == "double":
            return float("nan") if new is None else new
        return new

    def _member(self, one: Dict[str, Any], switch: Any) -> Any:
        """The member of a union that a discriminant selects."""
        of = self._types[one["discriminant"]]
        if of["kind"] == "enum":
            switch = of["enumerators"].index(_short(switch))
        elif of["kind"] == "char":
            switch = ord(switch)
        default = None
        for member in one["members"]:
            if int(switch) in member["labels"]:
                return member
            if None in member["labels"]:
                default = member
        return default

    def _writer(self, at: int) -> Write:
        if at not in self._writers:
            # A type may contain itself: the inner writer is looked up when it is used.
            self._writers[at] = lambda out, value: self._writers[at](out, value)
            self._writers[at] = self._make_writer(self._types[at])
        return self._writers[at]

    def _make_writer(self, one: Dict[str, Any]) -> Write:
        kind = one["kind"]
        if kind in _NUMBERS:
            return _put(_NUMBERS[kind])
        length = _put("I")
        if kind == "char":
            return lambda out, value: out.extend(value.encode("latin-1")[:1] or b"\0")
        if kind == "enum":
            names = one["enumerators"]
            return lambda out, value: length(out, names.index(_short(value)))
        if kind == "string":
            room = one.get("bound")

            def text(out: bytearray, value: Any) -> None:
                code = value.encode() + b"\0"
                if room is not None and len(code) > room:
                    raise ValueError(f"{value!r} is longer than {room - 1} bytes")
                length(out, len(code))
                out.extend(code)

            return text
        if kind in ("struct", "exception"):
            parts = [(m["name"], self._writer(m["type"])) for m in one["members"]]

            def record(out: bytearray, value: Any) -> None:
                for name, write in parts:
                    write(out, value[name])

            return record
        if kind == "union":
            switch = self._writer(one["discriminant"])
            members = [(m, self._writer(m["type"])) for m in one["members"]]

            def union(out: bytearray, value: Any) -> None:
                switch(out, value["d"])
                chosen = self._member(one, value["d"])
                for member, write in members:
                    length(out, 1 if member is chosen else 0)
                    if member is chosen:
                        write(out, value["u"][member["name"]])

            return union
        element = self._writer(one["element"])
        if kind == "optional":
            element_of = element

            def optional(out: bytearray, value: Any) -> None:
                length(out, 0 if value is None else 1)
                if value is not None:
                    element_of(out, value)

            return optional
        bulk = self._bulky.get(one["element"])
        size = 0 if bulk is None else struct.calcsize("=" + bulk)
        counted, most = kind == "sequence", one.get("bound") if kind == "sequence" else one["length"]

        def items(out: bytearray, value: Any) -> None:
            packed = None if bulk is None else _numbers.packed(value, bulk)
            count = len(value) if packed is None else len(packed) // size
            if (most is not None and count > most) or (not counted and count != most):
                raise ValueError(f"{one['name']} takes {most} elements, {count} were given")
            if counted:
                length(out, count)
            if packed is None:
                for inner in value:
                    element(out, inner)
            elif packed:
                # Alignment counts from the payload, which begins four bytes into the message.
                out.extend(b"\0" * (-(len(out) - 4) % size))
                out.extend(packed)

        return items

    def _reader(self, at: int, order: str) -> Read:
        key = (at, order)
        if key not in self._readers:
            self._readers[key] = lambda data, pos: self._readers[key](data, pos)
            self._readers[key] = self._make_reader(self._types[at], order)
        return self._readers[key]

    def _make_reader(self, one: Dict[str, Any], order: str) -> Read:
        kind = one["kind"]
        if kind in _NUMBERS:
            return _get(_NUMBERS[kind], order)
        length = _get("I", order)
        if kind == "char":
            return lambda data, pos: (chr(data[pos]), pos + 1)
        if kind == "enum":
            names = one["enumerators"]

            def enumeration(data: bytes, pos: int) -> Tuple[Any, int]:
                rank, pos = length(data, pos)
                return names[rank], pos

            return enumeration
        if kind == "string":

            def text(data: bytes, pos: int) -> Tuple[Any, int]:
                count, pos = length(data, pos)
                return data[pos : pos + max(count - 1, 0)].decode("utf-8", "replace"), pos + count

            return text
        if kind in ("struct", "exception"):
            parts = [(m["name"], self._reader(m["type"], order)) for m in one["members"]]

            def record(data: bytes, pos: int) -> Tuple[Any, int]:
                value = {}
                for name, read in parts:
                    value[name], pos = read(data, pos)
                return value, pos

            return record
        if kind == "union":
            switch = self._reader(one["discriminant"], order)
            members = [(m["name"], self._reader(m["type"], order)) for m in one["members"]]

            def union(data: bytes, pos: int) -> Tuple[Any, int]:
                chosen, pos = switch(data, pos)
                inner = {}
                for name, read in members:
                    count, pos = length(data, pos)
                    if count:
                        inner[name], pos = read(data, pos)
                return {"d": chosen, "u": inner}, pos

            return union
        element = self._reader(one["element"], order)
        fixed = one.get("length")
        bulk = _get_all(self._bulky.get(one["element"]), order, self._buffers)

        def items(data: bytes, pos: int) -> Tuple[Any, int]:
            count = fixed
            if count is None:
                count, pos = length(data, pos)
            if count > len(data):
                raise ValueError(f"{count} elements do not fit into the message")
            if bulk is not None and kind != "optional":
                return bulk(data, pos, count)
            values = []
            for _ in range(count):
                value, pos = element(data, pos)
                values.append(value)
            if kind == "optional":
                return (values[0] if values else None), pos
            return values, pos

        return items


def _short(name: Any) -> str:
    return str(name).rsplit("::", 1)[-1]


def _put(code: str) -> Write:
    pack, size = struct.Struct("<" + code).pack, struct.calcsize("<" + code)

    def put(out: bytearray, value: Any) -> None:
        # Alignment counts from the payload, which begins four bytes into the message.
        pad = -(len(out) - 4) % size
        # JSON has no NaN: None stands for it.
        out.extend(b"\0" * pad + pack(math.nan if value is None and code in "fd" else value))

    return put


def _get(code: str, order: str) -> Read:
    unpack, size = struct.Struct(order + code).unpack_from, struct.calcsize("<" + code)

    def get(data: bytes, pos: int) -> Tuple[Any, int]:
        pos += -pos % size
        return unpack(data, pos)[0], pos + size

    return get


def _get_all(
    code: Optional[str], order: str, buffers: bool
) -> "Optional[Callable[[bytes, int, int], Tuple[Any, int]]]":
    """Reads many numbers at once."""
    if code is None:
        return None
    size = struct.calcsize("=" + code)

    def get(data: bytes, pos: int, count: int) -> Tuple[Any, int]:
        pos += -pos % size if count else 0
        end = pos + count * size
        if end > len(data):
            raise ValueError(f"{count} elements do not fit into the message")
        if order == ">" and size > 1:
            values = list(struct.unpack_from(f">{count}{code}", data, pos))
            return (memoryview(array.array(code, values)) if buffers else values), end
        return _numbers.unpacked(data[pos:end], code, buffers), end

    return get
