"""Events: strings that codels return by their addresses, and the exceptions among them."""

from __future__ import annotations

import ctypes
from types import SimpleNamespace
from typing import Any, Dict, List, Type

from ..codel import Raised
from ._types import Types

_RAISE = ctypes.PYFUNCTYPE(
    ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p
)
_RAISED = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
UNKEX = "::genom::unkex"
_MWERR = "::genom::mwerr"
# Bytes of the message in its detail, the NUL included.
_WHAT = 128


class Events:
    """The events of one script. They stay at their addresses as long as it is loaded."""

    def __init__(self, names: List[str]) -> None:
        codes = {name: name.encode() + b"\0" for name in names}
        self._memory = ctypes.create_string_buffer(b"".join(codes.values()))
        self.start = ctypes.addressof(self._memory)
        self.end = self.start + len(self._memory)
        self._places: Dict[str, int] = {}
        at = self.start
        for name, code in codes.items():
            self._places[name] = at
            at += len(code)

    def __getitem__(self, name: str) -> int:
        return self._places[name]


class Exceptions:
    """The exceptions that codels of a component may raise, and how."""

    def __init__(self, listed: List[Dict[str, Any]], types: Types) -> None:
        self.classes: Dict[str, Type[Raised]] = {}
        for one in listed:
            kind = None if one["type"] is None else types[one["type"]]
            body = {"event": one["event"], "_kind": kind}
            self.classes[one["event"]] = type(one["name"][-1], (Raised,), body)

    def of(self, event: int, context: int) -> Raised:
        """The exception for an event that a port or a remote returned, with its detail."""
        name = ctypes.string_at(event).decode()
        known = self.classes.get(name)
        made = Raised() if known is None else known()
        made.event, made._recorded = name, event
        detail = _detail(event, context)
        if detail and made.detail is not None:
            made._kind.put(ctypes.addressof(made.detail), made._kind.get(detail, True, None))
        elif detail and known is None and name in (UNKEX, _MWERR):
            what = ctypes.string_at(detail, _WHAT).split(b"\0", 1)[0].decode("utf-8", "replace")
            made.detail = SimpleNamespace(what=what)
        return made


def _detail(event: int, context: int) -> int:
    """Where the detail is of the exception that was recorded last, if it is this one."""
    function = ctypes.c_void_p.from_address(context + ctypes.sizeof(ctypes.c_void_p)).value
    recorded = ctypes.c_void_p()
    detail = function and _RAISED(function)(ctypes.addressof(recorded), context)
    return int(detail or 0) if recorded.value == event else 0


def record(events: Events, error: Raised, context: int) -> int:
    """Records an exception in a context; returns what the codel is to return."""
    if error._recorded:
        return error._recorded
    event = events[error.event]
    if error.detail is None:
        return event
    address, size = ctypes.addressof(error.detail), ctypes.sizeof(error.detail)
    return _raise(context, event, address, size)


def unkex(events: Events, what: str, context: int) -> int:
    """The same for an error that no description declares, with a message."""
    code = what.encode()[: _WHAT - 1].decode("utf-8", "ignore").encode()
    detail = ctypes.create_string_buffer(code, _WHAT)
    return _raise(context, events[UNKEX], ctypes.addressof(detail), _WHAT)


def _raise(context: int, event: int, address: int, size: int) -> int:
    function = _RAISE(ctypes.c_void_p.from_address(context).value or 0)
    return int(function(event, address, size, context) or 0)
