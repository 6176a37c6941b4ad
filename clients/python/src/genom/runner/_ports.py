"""Ports, as codels get them. One is valid during the call that it is an argument of."""

from __future__ import annotations

import ctypes
from typing import Any, Callable, Dict, Optional

from . import _kept
from ._events import Exceptions
from ._kinds import Kind
from ._lists import Array, SequenceKind
from ._records import Record, Union_

# The functions keep the interpreter: they wait for nothing.
_SIMPLE = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)
_NAMED = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)


class _Port:
    """A handle: a table of functions."""

    __slots__ = ("name", "_kind", "_const", "_context", "_exceptions", "_functions", "_views")

    def __init__(
        self, name: str, kind: Kind, const: bool, handle: int, context: int, exceptions: Exceptions,
        prototype: Any, count: int,
    ) -> None:
        self.name, self._kind, self._const = name, kind, const
        self._context, self._exceptions = context, exceptions
        table = (ctypes.c_void_p * count).from_address(handle)
        self._functions = [prototype(at) for at in table]
        # Values that are views stay where they are: one view of each serves for all calls.
        lasting = isinstance(kind, (Record, Array, SequenceKind, Union_))
        self._views: Optional[Dict[int, Any]] = {} if lasting else None

    def _at(self, address: int) -> Any:
        views = self._views
        if views is None:
            return self._kind.get(address, self._const, None)
        view = views.get(address)
        if view is None:
            view = views[address] = self._kind.get(address, self._const, None)
            # This dictionary keeps it.
            _kept.given.pop(id(view), None)
        return view

    def _checked(self, event: Optional[int]) -> None:
        if event:
            raise self._exceptions.of(event, self._context)


class InPort(_Port):
    """``port in``: `read` takes the next value, which stays until the next `read`."""

    __slots__ = ()

    @property
    def data(self) -> Any:
        """The value that was read last, or None."""
        address = self._functions[0](self._context)
        return self._at(address) if address else None

    def read(self) -> Any:
        """Takes the next value; None if the port was never written.

        Raises ``::genom::no_such_inport`` if it is not connected, ``::genom::port_io``,
        ``::genom::serialization``.
        """
        self._checked(self._functions[1](self._context))
        return self.data

    def latest(self) -> Any:
        """Takes the next value; None if the port is not connected or was never written."""
        if self._functions[1](self._context):
            return None
        return self.data


class OutPort(_Port):
    """``port out``: `write` publishes what `data` holds."""

    __slots__ = ()

    @property
    def data(self) -> Any:
        """The value that is to be published; it may be changed in place, or assigned."""
        return self._at(self._functions[0](self._context))

    @data.setter
    def data(self, value: Any) -> None:
        self._kind.put(self._functions[0](self._context), value)

    def write(self, *value: Any) -> None:
        """Publishes a value, or what `data` holds.

        Raises ``::genom::no_such_outport``, ``::genom::port_io``, ``::genom::serialization``.
        """
        if value:
            (self.data,) = value
        self._checked(self._functions[1](self._context))


class _Element:
    """An element of a multiple port."""

    __slots__ = ("_port", "_name")

    def __init__(self, port: _Port, name: str) -> None:
        self._port, self._name = port, name.encode()

    def _address(self) -> Any:
        return self._port._functions[0](self._name, self._port._context)

    def _exchange(self) -> Any:
        return self._port._functions[1](self._name, self._port._context)


class InElement(_Element):
    """An element of a multiple in port, as an `InPort`."""

    __slots__ = ()

    @property
    def data(self) -> Any:
        """The value that was read last, or None."""
        address = self._address()
        return self._port._at(address) if address else None

    def read(self) -> Any:
        """As `InPort.read`."""
        self._port._checked(self._exchange())
        return self.data

    def latest(self) -> Any:
        """As `InPort.latest`."""
        return None if self._exchange() else self.data


class OutElement(_Element):
    """An element of a multiple out port, as an `OutPort`."""

    __slots__ = ()

    def _existing(self) -> int:
        address = self._address()
        if not address:
            raise KeyError(f"port {self._port.name} has no element {self._name.decode()!r}: open it")
        return int(address)

    @property
    def data(self) -> Any:
        """The value that is to be published."""
        return self._port._at(self._existing())

    @data.setter
    def data(self, value: Any) -> None:
        self._port._kind.put(self._existing(), value)

    def write(self, *value: Any) -> None:
        """As `OutPort.write`."""
        if value:
            (self.data,) = value
        self._port._checked(self._exchange())


class MultipleInPort(_Port):
    """``port multiple in``: elements by name, which supervisors connect."""

    __slots__ = ()

    def __getitem__(self, name: str) -> InElement:
        return InElement(self, name)


class MultipleOutPort(_Port):
    """``port multiple out``: elements by name, which codels open and close."""

    __slots__ = ()

    def __getitem__(self, name: str) -> OutElement:
        return OutElement(self, name)

    def open(self, name: str) -> None:
        """Creates an element, if it does not exist yet."""
        self._checked(self._functions[2](name.encode(), self._context))

    def close(self, name: str) -> None:
        """Removes an element."""
        self._checked(self._functions[3](name.encode(), self._context))


def maker(port: Dict[str, Any], kind: Kind, exceptions: Exceptions) -> Callable[[int, int], Any]:
    """Makes the argument for a handle and a context."""
    made: Any
    if port["multiple"]:
        made, count = (MultipleOutPort, 4) if port["out"] else (MultipleInPort, 2)
    else:
        made, count = (OutPort, 2) if port["out"] else (InPort, 2)
    prototype = _NAMED if port["multiple"] else _SIMPLE

    def make(handle: int, context: int) -> Any:
        const = not port["out"]
        return made(port["name"], kind, const, handle, context, exceptions, prototype, count)

    return make
