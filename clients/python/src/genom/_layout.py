"""Types of ports as ctypes, for values in shared memory.

The daemon gives the offset of everything, and the types made by ctypes are checked against it.
"""

from __future__ import annotations

import ctypes
from typing import Any, Callable, Dict, List, Optional, Tuple

from . import _numbers

_BASIC: Dict[str, Tuple[Any, str]] = {
    "boolean": (ctypes.c_bool, "bool"),
    "char": (ctypes.c_int8, "i8"),
    "octet": (ctypes.c_uint8, "u8"),
    "short": (ctypes.c_int16, "i16"),
    "unsigned short": (ctypes.c_uint16, "u16"),
    "long": (ctypes.c_int32, "i32"),
    "unsigned long": (ctypes.c_uint32, "u32"),
    "long long": (ctypes.c_int64, "i64"),
    "unsigned long long": (ctypes.c_uint64, "u64"),
    "float": (ctypes.c_float, "f32"),
    "double": (ctypes.c_double, "f64"),
}

Get = Callable[[int], Any]
Put = Callable[[int, Any], None]


class Codec:
    """Reads and writes values of one type at an address."""

    def __init__(self, layout: Dict[str, Any], buffers: bool = False) -> None:
        """With ``buffers``, arrays and sequences of numbers are read as `memoryview`."""
        self._buffers = buffers
        self._types: List[Dict[str, Any]] = layout["types"]
        self._ctypes: Dict[int, Any] = {}
        self._ends: Dict[int, Tuple[Get, Put]] = {}
        top = self._ctype(0)
        name = self._type_name(0)
        body: Dict[str, Any] = {"type_name": staticmethod(lambda: name)}
        if not issubclass(top, ctypes.Array):
            top = type(name, (top,), body)
        else:
            # Subclassing an array type requires these attributes to be given again.
            body["_type_"], body["_length_"] = top._type_, top._length_
            top = type(name, (ctypes.Array,), body)
        self.type = top
        self.get, self.put = self._end(0)

    def _type_name(self, at: int) -> str:
        """Name of the type in shared memory, as the backend forms it."""
        one = self._types[at]
        kind = one["kind"]
        if kind in _BASIC:
            return _BASIC[kind][1]
        if kind == "string":
            return f"[i8; {one['bound']}]"
        if kind == "array":
            return f"[{self._type_name(one['element'])}; {one['length']}]"
        return str(one.get("full_name", one["name"]))[2:] if "full_name" in one else _bare(one["name"])

    def _ctype(self, at: int) -> Any:
        made = self._ctypes.get(at)
        if made is None:
            one = self._types[at]
            made = self._make(one)
            size, align = ctypes.sizeof(made), ctypes.alignment(made)
            if (size, align) != (one["size"], one["align"]):
                raise TypeError(
                    f"{one['name']} has {one['size']} bytes aligned to {one['align']} in the "
                    f"daemon, {size} aligned to {align} here"
                )
            self._ctypes[at] = made
        return made

    def _make(self, one: Dict[str, Any]) -> Any:
        kind = one["kind"]
        if kind in _BASIC:
            return _BASIC[kind][0]
        if kind == "enum":
            return ctypes.c_uint32
        if kind == "string":
            return ctypes.c_char * one["bound"]
        if kind == "array":
            return self._ctype(one["element"]) * one["length"]
        if kind in ("struct", "exception"):
            return self._record(one, [(m["name"], self._ctype(m["type"])) for m in one["members"]])
        if kind == "sequence":
            items = self._ctype(one["element"]) * one["bound"]
            word = ctypes.c_uint32
            return self._record(one, [("_maximum", word), ("_length", word), ("_buffer", items)])
        if kind == "optional":
            # An optional: a flag before the value, if the value has an offset.
            flag = (ctypes.c_bool, 0)
            return self._placed(one, flag, (self._ctype(one["element"]), one["offsets"][0]))
        if kind == "union":
            members = [(m["name"], self._ctype(m["type"])) for m in one["members"]]
            inner = type(one["name"], (ctypes.Union,), {"_fields_": members})
            at = one["members"][0]["offset"]
            return self._placed(one, (self._ctype(one["discriminant"]), 0), (inner, at))
        raise TypeError(f"{one['name']} cannot be shared: it is a {kind}")

    @staticmethod
    def _record(one: Dict[str, Any], fields: List[Tuple[str, Any]]) -> Any:
        made = type(one["name"], (ctypes.Structure,), {"_fields_": fields})
        for member in one.get("members", []):
            if getattr(made, member["name"]).offset != member["offset"]:
                raise TypeError(f"{one['name']}.{member['name']} lies elsewhere here")
        return made

    @staticmethod
    def _placed(one: Dict[str, Any], *parts: Tuple[Any, int]) -> Any:
        (first, _), (second, offset) = parts
        fields = [("_d", first), ("_u", second)]
        made = type(one["name"], (ctypes.Structure,), {"_fields_": fields})
        if made._u.offset != offset:  # type: ignore[attr-defined]
            raise TypeError(f"{one['name']} lies elsewhere here")
        return made

    def _end(self, at: int) -> Tuple[Get, Put]:
        found = self._ends.get(at)
        if found is None:
            found = self._ends[at] = self._make_end(self._types[at], self._ctype(at))
        return found

    def _make_end(self, one: Dict[str, Any], made: Any) -> Tuple[Get, Put]:
        kind = one["kind"]
        if kind == "char":
            return _char()
        if kind in _BASIC:
            return _number(one, made)
        if kind == "enum":
            return _enumeration(one)
        if kind == "string":
            return _text(one)
        if kind in ("struct", "exception"):
            return self._struct(one)
        if kind == "array":
            get, put = self._items(one["element"])
            length = one["length"]

            def put_all(address: int, value: Any) -> None:
                if isinstance(value, dict):
                    put(address, {int(key): inner for key, inner in value.items()}, length)
                    return
                put(address, value, length)

            return lambda address: get(address, length), put_all
        if kind == "sequence":
            return self._sequence(one)
        if kind == "optional":
            return self._optional(one)
        return self._union(one)

    def _struct(self, one: Dict[str, Any]) -> Tuple[Get, Put]:
        ends = [(m["name"], m["offset"], *self._end(m["type"])) for m in one["members"]]
        puts = {name: (offset, put) for name, offset, _, put in ends}

        def get(address: int) -> Any:
            return {name: get(address + offset) for name, offset, get, _ in ends}

        def put(address: int, value: Any) -> None:
            for name, inner in value.items():
                place = puts.get(name)
                if place is None:
                    raise ValueError(f"{one['name']} has no member `{name}`; it has: {', '.join(puts)}")
                place[1](address + place[0], inner)

        return get, put

    def _items(self, element: int) -> Tuple[Callable[[int, int], Any], Callable[[int, Any, int], int]]:
        """Functions that return the number of elements to read, and store the number written."""
        size = self._types[element]["size"]
        get_one, put_one = self._end(element)
        code = _numbers.CODES.get(self._types[element]["kind"])

        def get(address: int, length: int) -> Any:
            if code is not None:
                return _numbers.unpacked(ctypes.string_at(address, length * size), code, self._buffers)
            return [get_one(address + index * size) for index in range(length)]

        def put(address: int, values: Any, most: int) -> int:
            given = values
            if not isinstance(values, dict):
                if code is not None:
                    # All at once, with a check of their ranges.
                    packed = _numbers.packed(values, code)
                    count = fits(len(packed) // size, most)
                    ctypes.memmove(address, packed, len(packed))
                    return count
                if _numbers.buffer(values) is not None:
                    values = given = values.tolist()
                values = dict(enumerate(values))
                fits(len(values), most)
            for index, value in values.items():
                if not 0 <= index < most:
                    raise ValueError(f"there is no element {index}, only {most}")
                put_one(address + index * size, value)
            return len(given)

        def fits(count: int, most: int) -> int:
            if count > most:
                raise ValueError(f"{most} elements of {self._types[element]['name']} fit, {count} were given")
            return count

        return get, put

    def _sequence(self, one: Dict[str, Any]) -> Tuple[Get, Put]:
        maximum, at = one["bound"], one["offsets"][2]
        get_items, put_items = self._items(one["element"])

        def get(address: int) -> Any:
            length = ctypes.c_uint32.from_address(address + 4).value
            return get_items(address + at, min(length, maximum))

        def put(address: int, value: Any) -> None:
            count = put_items(address + at, value, maximum)
            ctypes.c_uint32.from_address(address).value = maximum
            ctypes.c_uint32.from_address(address + 4).value = count

        return get, put

    def _optional(self, one: Dict[str, Any]) -> Tuple[Get, Put]:
        at = one["offsets"][0]
        get_value, put_value = self._end(one["element"])

        def get(address: int) -> Any:
            present = ctypes.c_bool.from_address(address).value
            return get_value(address + at) if present else None

        def put(address: int, value: Any) -> None:
            if value is not None:
                put_value(address + at, value)
            ctypes.c_bool.from_address(address).value = value is not None

        return get, put

    def _union(self, one: Dict[str, Any]) -> Tuple[Get, Put]:
        get_switch, put_switch = self._end(one["discriminant"])
        raw = _BASIC.get(self._types[one["discriminant"]]["kind"], (ctypes.c_uint32,))[0]
        members = {m["name"]: (m["offset"], *self._end(m["type"])) for m in one["members"]}
        chosen = {label: m["name"] for m in one["members"] for label in m["labels"]}

        def member(address: int) -> Optional[str]:
            return chosen.get(int(raw.from_address(address).value), chosen.get(None))

        def get(address: int) -> Any:
            name, switch = member(address), get_switch(address)
            if name is None:
                return {"d": switch, "u": {}}
            offset, get_value, _ = members[name]
            return {"d": switch, "u": {name: get_value(address + offset)}}

        def put(address: int, value: Any) -> None:
            put_switch(address, value["d"])
            for name, inner in value.get("u", {}).items():
                if name != member(address):
                    raise ValueError(f"{one['name']} holds no `{name}` when it is {value['d']!r}")
                offset, _, put_value = members[name]
                put_value(address + offset, inner)

        return get, put


def _bare(name: str) -> str:
    return name[2:] if name.startswith("::") else name


def _number(one: Dict[str, Any], made: Any) -> Tuple[Get, Put]:
    kind, bits = one["kind"], 8 * one["size"]
    low, high = (0, 2**bits - 1) if kind.startswith("u") or kind == "octet" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    from_address = made.from_address

    def get(address: int) -> Any:
        return from_address(address).value

    def put(address: int, value: Any) -> None:
        if value is None and kind in ("float", "double"):
            value = float("nan")
        # ctypes would wrap around instead of failing.
        elif kind not in ("float", "double", "boolean") and not low <= value <= high:
            raise ValueError(f"{value} is no {kind}")
        from_address(address).value = value

    return get, put


def _char() -> Tuple[Get, Put]:
    def put(address: int, value: Any) -> None:
        code = value.encode("latin-1")
        if len(code) != 1:
            raise ValueError(f"{value!r} is not one character")
        ctypes.c_char.from_address(address).value = code

    return lambda address: ctypes.c_char.from_address(address).value.decode("latin-1"), put


def _enumeration(one: Dict[str, Any]) -> Tuple[Get, Put]:
    names: List[str] = one["enumerators"]
    ranks = {name: rank for rank, name in enumerate(names)}

    def get(address: int) -> Any:
        rank = ctypes.c_uint32.from_address(address).value
        return names[rank] if rank < len(names) else "<invalid>"

    def put(address: int, value: Any) -> None:
        rank = ranks.get(str(value).rsplit("::", 1)[-1])
        if rank is None:
            raise ValueError(f"{one['name']} has no `{value}`; it has: {', '.join(names)}")
        ctypes.c_uint32.from_address(address).value = rank

    return get, put


def _text(one: Dict[str, Any]) -> Tuple[Get, Put]:
    room = one["bound"]

    def get(address: int) -> Any:
        return ctypes.string_at(address, room).split(b"\0", 1)[0].decode("utf-8", "replace")

    def put(address: int, value: Any) -> None:
        code = value.encode()
        if len(code) >= room:
            raise ValueError(f"{value!r} is longer than {room - 1} bytes")
        ctypes.memset(address, 0, room)
        ctypes.memmove(address, code, len(code))

    return get, put
