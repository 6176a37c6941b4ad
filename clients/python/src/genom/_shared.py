"""Ports of an embedded daemon, in memory that it shares with this program.

`daemon/embedding/src/memory.rs` of genomd documents the memory.
"""

from __future__ import annotations

import ctypes
import mmap
import os
from typing import Any, Callable, Dict

from ._slate import FORGET
from .errors import GenoMError
from .runner import _numbers
from .runner._kinds import Kind
from .runner._lists import Array, SequenceKind
from .runner._records import Record, Union_
from .runner._types import Types

VALUE_AT = 64
_GONE_AT = 8


class SharedPort:
    """A port: `data` is its value, as codels in Python have it. Both kinds of ports have it."""

    def __init__(
        self,
        address: str,
        layout: Dict[str, Any],
        is_in: bool,
        file: int,
        forget: Callable[[], None],
    ) -> None:
        self.address = address
        """``component/port``."""
        self._forget = forget
        self._kind = _kind(layout)
        # Mapped until the last view is gone.
        self._memory = mmap.mmap(file, VALUE_AT + self._kind.size, **FORGET)
        self._written = ctypes.c_uint64.from_buffer(self._memory)
        self._gone = ctypes.c_uint32.from_buffer(self._memory, _GONE_AT)
        self._at = ctypes.addressof(self._written) + VALUE_AT
        self._const = not is_in
        # Values that are views stay where they are: one serves for all time.
        lasting = isinstance(self._kind, (Record, Array, SequenceKind, Union_))
        self._view = self._value() if lasting else None
        self._closed = False

    @property
    def data(self) -> Any:
        """The value: of a struct, an array or a sequence a view of the memory itself."""
        self._check()
        return self._value() if self._view is None else self._view

    @property
    def count(self) -> int:
        """How often it was written: by codels, or by this program."""
        self._check()
        return int(self._written.value)

    def close(self) -> None:
        """Ends sharing; views show what is there at last."""
        if not self._closed:
            self._closed = True
            self._forget()

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.address}: {self._kind.name}>"

    def _value(self) -> Any:
        return self._kind.get(self._at, self._const, self._written)

    def _check(self) -> None:
        if self._closed:
            raise GenoMError("ended", None, f"{self.address} is closed")
        if self._gone.value:
            raise GenoMError(
                "ended", None,
                f"{self.address} is not there: its component is gone, or has another type there now",
            )


class SharedIn(SharedPort):
    """An in port of a component: this program writes it."""

    @property
    def data(self) -> Any:
        """The value that is to be written; it may be changed in place, or assigned."""
        return SharedPort.data.fget(self)  # type: ignore[attr-defined]

    @data.setter
    def data(self, value: Any) -> None:
        self._check()
        self._kind.put(self._at, value)

    def write(self, *value: Any) -> None:
        """Writes a value, or what `data` holds: the next step publishes it before anything runs."""
        self._check()
        if value:
            self._kind.put(self._at, *value)
        self._written.value += 1


class SharedOut(SharedPort):
    """An out port of a component: each step shows here what codels wrote in it last."""

    def read(self) -> Any:
        """The value; None if the port was never written."""
        return self.data if self._written.value else None


def shared(
    address: str, layout: Dict[str, Any], is_in: bool, file: int, forget: Callable[[], None]
) -> SharedPort:
    """A port in the memory of this file, which is closed."""
    try:
        made = SharedIn if is_in else SharedOut
        return made(address, layout, is_in, file, forget)
    finally:
        os.close(file)


def _kind(layout: Dict[str, Any]) -> Kind:
    if any(one["kind"] == "array" or one["kind"] == "sequence" for one in layout["types"]):
        _numbers.find_numpy()
    return Types(layout["types"])[0]
