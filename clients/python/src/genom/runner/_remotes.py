"""Services of other components, as codels call them."""

from __future__ import annotations

import ctypes
import types
from typing import Any, Callable, Dict, List

from ._events import Exceptions
from ._kinds import Kind
from ._records import meant, python_name
from ._types import Types


class Remote:
    """A service of another component. A call waits for its end, and other tasks go on."""

    __slots__ = ("name", "_parameters", "_context", "_exceptions", "_function")

    def __init__(
        self, name: str, parameters: List["_Passed"], handle: int, context: int,
        exceptions: Exceptions,
    ) -> None:
        self.name, self._parameters = name, parameters
        self._context, self._exceptions = context, exceptions
        classes = [one.made for one in parameters]
        # Without the lock of the interpreter while it waits.
        prototype = ctypes.CFUNCTYPE(ctypes.c_void_p, *classes, ctypes.c_void_p)
        self._function = prototype(ctypes.c_void_p.from_address(handle).value or 0)

    def __call__(self, **inputs: Any) -> Any:
        """Calls the service with its inputs by name; returns its outputs, as attributes.

        Raises the exceptions of the service, and ``::genom::no_such_service``,
        ``::genom::remote_io``.
        """
        known = [one.name for one in self._parameters if one.is_input]
        for name in inputs:
            if name not in known:
                raise TypeError(f"{self.name} has no input `{name}`{meant(name, known)}")
        missing = [name for name in known if name not in inputs]
        if missing:
            raise TypeError(f"{self.name} wants input `{missing[0]}`")
        memories = [one.memory() for one in self._parameters]
        arguments = [
            one.argument(memory, inputs.get(one.name))
            for one, memory in zip(self._parameters, memories)
        ]
        event = self._function(*arguments, self._context)
        if event:
            raise self._exceptions.of(event, self._context)
        outputs = {
            one.name: one.kind.get(ctypes.addressof(memory), False, memory)
            for one, memory in zip(self._parameters, memories)
            if one.is_output
        }
        return types.SimpleNamespace(**outputs)


def _memory_of(kind: Kind) -> Any:
    """The class of memory for a value; what the value owns goes with it."""
    words = ctypes.c_uint64 * (kind.size // 8 + 1)

    def release(memory: Any) -> None:
        kind.empty(ctypes.addressof(memory))

    body: Dict[str, Any] = {"_type_": words._type_, "_length_": words._length_}
    if not kind.fixed:
        body["__del__"] = release
    return type("Memory", (ctypes.Array,), body)


class _Passed:
    """A parameter of a service."""

    def __init__(self, described: Dict[str, Any], known: Types) -> None:
        self.name = python_name(described["name"])
        self.kind: Kind = known[described["type"]]
        self.is_input = described["direction"] != "out"
        self.is_output = described["direction"] != "in"
        self._value = None if self.is_output else self.kind.by_value
        self.made: Any = self._value or ctypes.c_void_p
        self._memory = None if self._value else _memory_of(self.kind)

    def memory(self) -> Any:
        """Memory for the value, unless it is passed in a register."""
        return None if self._memory is None else self._memory()

    def argument(self, memory: Any, value: Any) -> Any:
        """What is passed to C."""
        if memory is None:
            return self.kind.passed(value)
        if self.is_input:
            self.kind.put(ctypes.addressof(memory), value)
        return ctypes.addressof(memory)


def maker(
    remote: Dict[str, Any], known: Types, exceptions: Exceptions
) -> Callable[[int, int], Remote]:
    """Makes the argument for a handle and a context."""
    parameters = [_Passed(one, known) for one in remote["parameters"]]
    return lambda handle, context: Remote(remote["name"], parameters, handle, context, exceptions)
