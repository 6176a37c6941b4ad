"""Numbers in memory, and arrays of them as NumPy arrays, or memoryviews where NumPy is missing."""

from __future__ import annotations

import ctypes
import importlib
from typing import Any, Dict, Tuple

# NumPy, once it was looked for; it starts threads, which the limits of a cell would not hold for.
numpy: Any = None


def find_numpy() -> None:
    """Looks for NumPy, for a component that has arrays."""
    global numpy
    try:
        numpy = importlib.import_module("numpy")
    except ImportError:
        numpy = None


# Type in C, least and greatest value (of integers), type of NumPy.
NUMBERS: Dict[str, Tuple[Any, Any, str]] = {
    "octet": (ctypes.c_uint8, (0, 2**8 - 1), "u1"),
    "short": (ctypes.c_int16, (-(2**15), 2**15 - 1), "i2"),
    "unsigned short": (ctypes.c_uint16, (0, 2**16 - 1), "u2"),
    "long": (ctypes.c_int32, (-(2**31), 2**31 - 1), "i4"),
    "unsigned long": (ctypes.c_uint32, (0, 2**32 - 1), "u4"),
    "long long": (ctypes.c_int64, (-(2**63), 2**63 - 1), "i8"),
    "unsigned long long": (ctypes.c_uint64, (0, 2**64 - 1), "u8"),
    "float": (ctypes.c_float, None, "f4"),
    "double": (ctypes.c_double, None, "f8"),
    "boolean": (ctypes.c_bool, None, "?"),
}


def integer(value: Any, low: int, high: int, what: str) -> int:
    """The value as an integer of that range: ctypes would wrap around instead of failing."""
    if type(value) is int and low <= value <= high:
        return value
    if type(value) is not int:
        if isinstance(value, float) or not hasattr(value, "__index__"):
            raise TypeError(f"{what} is to be an integer, not {value!r}")
    number = int(value.__index__())
    if not low <= number <= high:
        raise ValueError(f"{what} is to be between {low} and {high}, not {number}")
    return number


def array(kind: str, address: int, shape: Tuple[int, ...], const: bool, owner: Any) -> Any:
    """A view of the numbers at an address."""
    made, _, code = NUMBERS[kind]
    count = 1
    for length in shape:
        count *= length
    if count == 0:
        address = ctypes.addressof(_NOTHING)
    items = (made * count).from_address(address)
    items._owner = owner
    if numpy is not None:
        view = numpy.frombuffer(items, dtype=code, count=count).reshape(shape)
        if const:
            view.flags.writeable = False
        return view
    flat: Any = memoryview(items).cast("B")
    if const:
        flat = flat.toreadonly()
    code = _MEMORY[code]
    return flat.cast(code, list(shape)) if count else flat.cast(code)


_NOTHING = ctypes.c_uint64()
# Codes of the module `struct`.
_MEMORY = {
    "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q",
    "f4": "f", "f8": "d", "?": "?",
}


def fill(view: Any, values: Any) -> None:
    """Stores as many values as there are numbers."""
    if numpy is not None:
        view[...] = _fitting(view, numpy.asarray(values))
        return
    if view.ndim > 1:
        _fill_nested(view, values, ())
        return
    values = list(values)
    if len(values) != len(view):
        raise ValueError(f"{len(view)} numbers are needed, not {len(values)}")
    for rank, value in enumerate(values):
        view[rank] = value


def _fitting(view: Any, values: Any) -> Any:
    """The array, if it is as large as the view, and of integers where those are needed: NumPy would
    repeat, round and wrap around."""
    if values.shape != view.shape:
        raise ValueError(f"numbers in {view.shape} are needed, not in {values.shape}")
    if values.size and view.dtype.kind in "iu" and not numpy.can_cast(values.dtype, view.dtype):
        if values.dtype.kind not in "iu":
            raise TypeError(f"integers are needed, not {values.dtype}")
        limits = numpy.iinfo(view.dtype)
        least, greatest = int(values.min()), int(values.max())
        if least < limits.min or greatest > limits.max:
            raise ValueError(f"{least} to {greatest} is beyond {limits.min} to {limits.max}")
    return values


def _fill_nested(view: Any, values: Any, at: Tuple[int, ...]) -> None:
    if len(at) == view.ndim:
        view[at] = values
        return
    values = list(values)
    if len(values) != view.shape[len(at)]:
        raise ValueError(f"{view.shape[len(at)]} elements are needed, not {len(values)}")
    for rank, value in enumerate(values):
        _fill_nested(view, value, (*at, rank))
