"""Types of a description: how a value of each is read and written at an address.

The daemon says where everything lies; what ctypes makes of it is compared with that.
"""

from __future__ import annotations

import ctypes
import enum
from typing import Any, Dict, List, Optional, Sequence, Tuple

from . import _numbers

LIBC = ctypes.CDLL(None)
LIBC.strdup.argtypes, LIBC.strdup.restype = [ctypes.c_char_p], ctypes.c_void_p
LIBC.free.argtypes, LIBC.free.restype = [ctypes.c_void_p], None
_UNITS = {1: ctypes.c_uint8, 2: ctypes.c_uint16, 4: ctypes.c_uint32, 8: ctypes.c_uint64}


class Unsupported(Exception):
    """Codels in Python cannot use a type."""


class Kind:
    """One type."""

    # Whether codels get an `in` argument by value in C.
    by_value: Any = None

    def __init__(self, one: Dict[str, Any]) -> None:
        self.keyword: str = one["kind"]
        self.name: str = str(one.get("full_name", one["name"])).lstrip(":") or one["name"]
        self.size: int = one["size"]
        self.align: int = one["align"]
        self.fixed: bool = one["fixed"]

    def ctype(self, const: bool) -> Any:
        """The type of a member in a structure of ctypes."""
        return _UNITS[self.align] * (self.size // self.align)

    def get(self, address: int, const: bool, owner: Any) -> Any:
        """The value at an address, or a view of it that keeps its owner."""
        raise NotImplementedError

    def put(self, address: int, value: Any) -> None:
        """Stores a value at an address."""
        raise NotImplementedError

    def given(self, value: Any) -> Any:
        """The argument that a codel gets for one by value."""
        return value

    def passed(self, value: Any) -> Any:
        """What C gets for an input of a service by value."""
        return value

    def empty(self, address: int) -> None:
        """Releases what the value owns, and makes it the empty value."""
        ctypes.memset(address, 0, self.size)

    def annotation(self) -> Any:
        """The Python type of a value, where there is one."""
        return None


class Made:
    """New values, in memory of their own until they are moved to where they belong."""

    def __init__(self, kind: Kind, count: int) -> None:
        self._kind, self._size = kind, kind.size * count
        self._memory = (ctypes.c_uint64 * (self._size // 8 + 1))()
        self.address = ctypes.addressof(self._memory)

    def fill(self, values: Sequence[Any]) -> None:
        """Stores them all, or none."""
        size = self._kind.size
        for rank, one in enumerate(values):
            try:
                self._kind.put(self.address + rank * size, one)
            except BaseException:
                for stored in range(rank + 1):
                    self._kind.empty(self.address + stored * size)
                raise

    def move_to(self, address: int) -> None:
        """Moves them to memory that owns nothing."""
        if self._size:
            ctypes.memmove(address, self.address, self._size)


class Number(Kind):
    """Integers, floating point, booleans."""

    def __init__(self, one: Dict[str, Any]) -> None:
        super().__init__(one)
        self.made, self.range, _ = _numbers.NUMBERS[self.keyword]
        self.by_value = self.made

    def ctype(self, const: bool) -> Any:
        return self.made

    def get(self, address: int, const: bool, owner: Any) -> Any:
        return self.made.from_address(address).value

    def put(self, address: int, value: Any) -> None:
        self.made.from_address(address).value = self.checked(value)

    def checked(self, value: Any) -> Any:
        """The value, if it is one of this type."""
        if self.range is None:
            return value
        low, high = self.range
        return _numbers.integer(value, low, high, f"a {self.keyword}")

    def passed(self, value: Any) -> Any:
        return self.checked(value)

    def annotation(self) -> Any:
        if self.keyword == "boolean":
            return bool
        return float if self.range is None else int


class Char(Kind):
    """One character: a string of length 1, of the first 256."""

    by_value = ctypes.c_uint8

    def get(self, address: int, const: bool, owner: Any) -> Any:
        return chr(ctypes.c_uint8.from_address(address).value)

    def put(self, address: int, value: Any) -> None:
        code = value.encode("latin-1")
        if len(code) != 1:
            raise ValueError(f"one character is needed, not {value!r}")
        ctypes.c_uint8.from_address(address).value = code[0]

    def given(self, value: Any) -> Any:
        return chr(value)

    def passed(self, value: Any) -> Any:
        code = ctypes.c_uint8()
        self.put(ctypes.addressof(code), value)
        return code.value

    def annotation(self) -> Any:
        return str


class Enum(Kind):
    """Enumerations: members of an `IntEnum`. What is none of them stays a number."""

    by_value = ctypes.c_uint32

    def __init__(self, one: Dict[str, Any]) -> None:
        super().__init__(one)
        names = one["enumerators"]
        make: Any = enum.IntEnum
        ranks = {name: rank for rank, name in enumerate(names)}
        self.enum: Any = make(self.name.rsplit("::", 1)[-1], ranks)
        self.members: List[Any] = list(self.enum)

    def ctype(self, const: bool) -> Any:
        return ctypes.c_uint32

    def checked(self, value: Any) -> int:
        """The number of a member, which may be given by its name."""
        if isinstance(value, str):
            value = self.enum[value]
        return _numbers.integer(value, 0, len(self.members) - 1, f"a {self.name}")

    def get(self, address: int, const: bool, owner: Any) -> Any:
        return self.given(ctypes.c_uint32.from_address(address).value)

    def put(self, address: int, value: Any) -> None:
        ctypes.c_uint32.from_address(address).value = self.checked(value)

    def passed(self, value: Any) -> Any:
        return self.checked(value)

    def given(self, value: Any) -> Any:
        return self.members[value] if value < len(self.members) else value

    def annotation(self) -> Any:
        return self.enum


class Text(Kind):
    """Strings of bounded length, in place, and of any length, of which memory has the address."""

    def __init__(self, one: Dict[str, Any]) -> None:
        super().__init__(one)
        self.bound: Optional[int] = one["bound"]
        self.by_value = ctypes.c_char_p if self.bound is None else None

    def get(self, address: int, const: bool, owner: Any) -> Any:
        if self.bound is None:
            return self.given(ctypes.c_char_p.from_address(address).value)
        return self.given(ctypes.string_at(address, self.bound).split(b"\0", 1)[0])

    def put(self, address: int, value: Any) -> None:
        if not isinstance(value, str):
            raise TypeError(f"a string is needed, not {value!r}")
        code = value.encode()
        if b"\0" in code:
            raise ValueError("a string of IDL has no NUL inside")
        if self.bound is None:
            made = LIBC.strdup(code)
            if not made:
                raise MemoryError
            place = ctypes.c_void_p.from_address(address)
            LIBC.free(place.value)
            place.value = made
            return
        if len(code) >= self.bound:
            raise ValueError(f"{value!r} is longer than {self.bound - 1} bytes")
        ctypes.memmove(address, code.ljust(self.bound, b"\0"), self.bound)

    def passed(self, value: Any) -> Any:
        if not isinstance(value, str):
            raise TypeError(f"a string is needed, not {value!r}")
        return value.encode()

    def given(self, value: Any) -> Any:
        return "" if value is None else value.decode("utf-8", "replace")

    def empty(self, address: int) -> None:
        if self.bound is None:
            LIBC.free(ctypes.c_void_p.from_address(address).value)
        super().empty(address)

    def annotation(self) -> Any:
        return str


class Optional_(Kind):
    """A value, or None."""

    def __init__(self, one: Dict[str, Any], kinds: Sequence[Kind]) -> None:
        super().__init__(one)
        self.inner_at: int = one["offsets"][0]
        self._kinds: Sequence[Kind] = kinds
        self._rank: int = one["element"]

    @property
    def inner(self) -> Kind:
        return self._kinds[self._rank]

    def get(self, address: int, const: bool, owner: Any) -> Any:
        if not ctypes.c_bool.from_address(address).value:
            return None
        return self.inner.get(address + self.inner_at, const, owner)

    def put(self, address: int, value: Any) -> None:
        if value is None:
            self.empty(address)
            return
        self.inner.put(address + self.inner_at, value)
        ctypes.c_bool.from_address(address).value = True

    def empty(self, address: int) -> None:
        self.inner.empty(address + self.inner_at)
        ctypes.c_bool.from_address(address).value = False


def shape(kinds: Sequence[Kind], kind: Kind) -> Tuple[Optional[str], Tuple[int, ...]]:
    """Of an array of numbers, however deep: the keyword of the numbers, and the dimensions."""
    from ._lists import Array

    lengths: Tuple[int, ...] = ()
    while isinstance(kind, Array):
        lengths = (*lengths, kind.length)
        kind = kind.inner
    return (kind.keyword if isinstance(kind, Number) else None), lengths
