"""Arrays of numbers: lists and buffers (bytes, memoryview, array, numpy)."""

from __future__ import annotations

import math
import struct
from typing import Any, Optional

# Codes of `struct` for the basic numeric types; characters are bytes here.
CODES = {
    "octet": "B", "short": "h", "unsigned short": "H", "long": "i", "unsigned long": "I",
    "long long": "q", "unsigned long long": "Q", "float": "f", "double": "d", "char": "c",
}
_KINDS = {**dict.fromkeys("BHILQNc", "unsigned"), **dict.fromkeys("bhilqn", "signed"), **dict.fromkeys("efd", "real")}

# Longer lists are encoded faster as a message than as JSON.
_LONG = 256


def buffer(values: Any) -> Optional[memoryview]:
    """The buffer of an object that has one; None for lists."""
    if isinstance(values, (list, tuple, dict, str)):
        return None
    try:
        return memoryview(values)
    except TypeError:
        return None


def fitting(view: memoryview, code: str) -> bool:
    """Whether a buffer holds numbers of that code, in the byte order of this machine."""
    form = view.format.lstrip("@=<")
    return _KINDS.get(form) == _KINDS[code] and view.itemsize == struct.calcsize("=" + code)


def packed(values: Any, code: str) -> bytes:
    """The numbers in sequence, little endian, with a check of their ranges.

    A buffer of several dimensions is taken row by row.
    """
    view = buffer(values)
    if view is not None:
        if fitting(view, code):
            return view.tobytes()
        values = flat(values)
    if code == "c":
        return b"".join(_character(value) for value in values)
    if code in "fd" and None in values:
        values = [math.nan if value is None else value for value in values]
    try:
        return struct.pack(f"<{len(values)}{code}", *values)
    except (struct.error, OverflowError) as why:
        raise ValueError(str(why)) from why


def unpacked(data: bytes, code: str, buffers: bool) -> Any:
    """Numbers in sequence, as a list or as a `memoryview`."""
    if code == "c":
        return memoryview(data) if buffers else list(data.decode("latin-1"))
    view: Any = memoryview(data).cast(code)  # type: ignore[call-overload]
    return view if buffers else view.tolist()


def kept(values: Any) -> Any:
    """A copy of a buffer's numbers, which later changes of the buffer do not affect."""
    view = buffer(values)
    if view is None:
        return list(values)
    form = view.format.lstrip("@=<")
    if form == "B":
        return memoryview(view.tobytes())
    if form not in _KINDS or form == "e":
        return flat(values)
    return memoryview(view.tobytes()).cast(form)  # type: ignore[call-overload]


def flat(values: Any) -> Any:
    """A buffer as a list of numbers."""
    view = buffer(values)
    if view is None:
        return values
    # numpy and array have number formats that memoryview cannot convert.
    listed: Any = values.tolist() if hasattr(values, "tolist") else list(values)
    for _ in range(view.ndim - 1):
        listed = [value for row in listed for value in row]
    return listed


def many(value: Any) -> bool:
    """Whether a value contains a buffer or a long list."""
    if isinstance(value, dict):
        return any(many(inner) for inner in value.values())
    if isinstance(value, (list, tuple)):
        # Elements are alike: the first one is sufficient.
        return len(value) > _LONG or (bool(value) and many(value[0]))
    return buffer(value) is not None


def _character(value: Any) -> bytes:
    code = value if isinstance(value, bytes) else str(value).encode("latin-1")
    if len(code) != 1:
        raise ValueError(f"{value!r} is not one character")
    return bytes(code)
