"""Arrays and sequences: of numbers as arrays of NumPy, of anything else as lists of views."""

from __future__ import annotations

import ctypes
from typing import Any, Dict, Iterator, Optional, Sequence, Tuple

from . import _kept, _numbers
from ._kinds import LIBC, Kind, Made, Number, shape

_FREE = ctypes.cast(LIBC.free, ctypes.c_void_p).value
LIBC.calloc.argtypes, LIBC.calloc.restype = [ctypes.c_size_t, ctypes.c_size_t], ctypes.c_void_p


class ListView:
    """Elements in memory. An index beyond them is an IndexError."""

    __slots__ = ("_kind", "_at", "_count", "_const", "_owner")

    def __init__(self, kind: Kind, at: int, count: int, const: bool, owner: Any) -> None:
        self._kind, self._at, self._count = kind, at, count
        self._const, self._owner = const, owner
        if owner is None and _kept.watching:
            _kept.give(self)

    def _place(self) -> Tuple[int, int]:
        """Address of the first element, and how many there are."""
        return self._at, self._count

    def __len__(self) -> int:
        return self._place()[1]

    def _address(self, rank: int) -> int:
        at, count = self._place()
        rank = rank.__index__()
        if not -count <= rank < count:
            raise IndexError(f"there is no element {rank}, only {count}")
        return at + (rank % count) * self._kind.size

    def __getitem__(self, rank: Any) -> Any:
        if isinstance(rank, slice):
            return [self[one] for one in range(*rank.indices(len(self)))]
        return self._kind.get(self._address(rank), self._const, self._owner)

    def __setitem__(self, rank: int, value: Any) -> None:
        self._writable()
        self._kind.put(self._address(rank), value)

    def __iter__(self) -> Iterator[Any]:
        return (self[rank] for rank in range(len(self)))

    def _writable(self) -> None:
        if self._const:
            raise TypeError("an `in` argument cannot be changed")

    def __eq__(self, other: Any) -> bool:
        try:
            return len(self) == len(other) and all(a == b for a, b in zip(self, other))
        except TypeError:
            return NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return repr(list(self))


class SequenceView(ListView):
    """Elements of a sequence, whose number may change up to its bound."""

    __slots__ = ("_sequence",)

    def __init__(self, sequence: "SequenceKind", at: int, const: bool, owner: Any) -> None:
        super().__init__(sequence.inner, at, 0, const, owner)
        self._sequence = sequence

    def _place(self) -> Tuple[int, int]:
        return self._sequence.elements(self._at)

    def resize(self, count: int) -> None:
        """Takes elements away at the end, or adds empty ones."""
        self._writable()
        self._sequence.resize(self._at, count)

    def append(self, value: Any) -> None:
        """Adds an element at the end."""
        count = len(self)
        self.resize(count + 1)
        try:
            self[count] = value
        except BaseException:
            self.resize(count)
            raise

    def extend(self, values: Any) -> None:
        """Adds elements at the end."""
        for value in values:
            self.append(value)

    def clear(self) -> None:
        """Takes all elements away."""
        self.resize(0)

    @property
    def array(self) -> Any:
        """The numbers as an array, valid until the sequence is resized."""
        at, count = self._place()
        if not isinstance(self._kind, Number):
            raise TypeError(f"{self._kind.name} is no number")
        made = _numbers.array(self._kind.keyword, at, (count,), self._const, self._owner)
        return _kept.give(made) if self._owner is None and _kept.watching else made

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        made = self.array
        return made if dtype is None else made.astype(dtype)


class Array(Kind):
    """A fixed number of elements."""

    def __init__(self, one: Dict[str, Any], kinds: Sequence[Kind]) -> None:
        super().__init__(one)
        self.length: int = one["length"]
        self._kinds: Sequence[Kind] = kinds
        self._rank: int = one["element"]
        # Views of numbers by address: making one takes longer than a codel may.
        self._known: Dict[Tuple[int, bool], Any] = {}

    @property
    def inner(self) -> Kind:
        return self._kinds[self._rank]

    def get(self, address: int, const: bool, owner: Any) -> Any:
        if owner is None:
            known = self._known.get((address, const))
            if known is not None:
                return _kept.give(known, 1) if _kept.watching else known
        number, lengths = shape(self._kinds, self)
        if number is None:
            return ListView(self.inner, address, self.length, const, owner)
        made = _numbers.array(number, address, lengths, const, owner)
        if owner is None:
            if len(self._known) > 256:
                self._known.clear()
            self._known[address, const] = made
            if _kept.watching:
                _kept.give(made, 1)
        return made

    def put(self, address: int, value: Any) -> None:
        # Made elsewhere first: the values may be views of this array, or not be stored.
        made = Made(self.inner, self.length)
        number, lengths = shape(self._kinds, self)
        if number is not None:
            _numbers.fill(_numbers.array(number, made.address, lengths, False, None), value)
            made.move_to(address)
            return
        values = list(value)
        if len(values) != self.length:
            raise ValueError(f"{self.length} elements are needed, not {len(values)}")
        made.fill(values)
        self.empty(address)
        made.move_to(address)

    def empty(self, address: int) -> None:
        for rank in range(self.length):
            self.inner.empty(address + rank * self.inner.size)


class SequenceKind(Kind):
    """A number of elements that may change: in place up to a bound, or somewhere else."""

    def __init__(self, one: Dict[str, Any], kinds: Sequence[Kind]) -> None:
        super().__init__(one)
        self.bound: Optional[int] = one["bound"]
        self.buffer_at: int = one["offsets"][2]
        self._kinds: Sequence[Kind] = kinds
        self._rank: int = one["element"]

    @property
    def inner(self) -> Kind:
        return self._kinds[self._rank]

    def elements(self, address: int) -> Tuple[int, int]:
        """Address of the first element, and how many there are."""
        count = ctypes.c_uint32.from_address(address + 4).value
        if self.bound is not None:
            return address + self.buffer_at, min(count, self.bound)
        at = ctypes.c_void_p.from_address(address + self.buffer_at).value
        return at or 0, count if at else 0

    def get(self, address: int, const: bool, owner: Any) -> Any:
        return SequenceView(self, address, const, owner)

    def put(self, address: int, value: Any) -> None:
        # As for arrays.
        values = value if hasattr(value, "__len__") else list(value)
        count = len(values)
        self._checked(count)
        made = Made(self.inner, count)
        if isinstance(self.inner, Number) and count:
            _numbers.fill(
                _numbers.array(self.inner.keyword, made.address, (count,), False, None), values
            )
        else:
            made.fill(values)
        self.resize(address, 0)
        self.resize(address, count)
        made.move_to(self.elements(address)[0])

    def _checked(self, count: int) -> None:
        most = 2**32 - 1 if self.bound is None else self.bound
        if not 0 <= count <= most:
            raise ValueError(f"{count} elements: {self.name} has at most {most}")

    def resize(self, address: int, count: int) -> None:
        """Takes elements away at the end, or adds empty ones."""
        count = count.__index__()
        self._checked(count)
        at, before = self.elements(address)
        if not self.inner.fixed:
            for rank in range(count, before):
                self.inner.empty(at + rank * self.inner.size)
        if self.bound is not None:
            ctypes.c_uint32.from_address(address).value = self.bound
        elif count > ctypes.c_uint32.from_address(address).value or (count and not at):
            at = self._grow(address, at, before, count)
        if count > before:
            size = self.inner.size
            ctypes.memset(at + before * size, 0, (count - before) * size)
        ctypes.c_uint32.from_address(address + 4).value = count

    def _grow(self, address: int, at: int, before: int, count: int) -> int:
        """More room for elements; as `genom_sequence_resize` in C does it."""
        room = max(count, 2 * before)
        made = LIBC.calloc(room, max(self.inner.size, 1))
        if not made:
            raise MemoryError(f"{count} elements of {self.inner.name}")
        ctypes.memmove(made, at, before * self.inner.size)
        self._release(address, at)
        ctypes.c_uint32.from_address(address).value = room
        ctypes.c_void_p.from_address(address + self.buffer_at).value = made
        ctypes.c_void_p.from_address(address + self.buffer_at + 8).value = _FREE
        return int(made)

    def _release(self, address: int, at: int) -> None:
        release = ctypes.c_void_p.from_address(address + self.buffer_at + 8).value
        if at and release:
            ctypes.CFUNCTYPE(None, ctypes.c_void_p)(release)(at)

    def empty(self, address: int) -> None:
        self.resize(address, 0)
        if self.bound is None:
            self._release(address, self.elements(address)[0])
            super().empty(address)
