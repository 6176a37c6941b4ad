"""Ports of components in cells, for a program that steps its daemon: their memory is this program's,
and each step passes values on through the control plane.
"""

from __future__ import annotations

import os
from typing import Any, Callable, Dict, Optional

from ._daemon import Daemon
from ._faults import path
from ._shared import VALUE_AT, SharedPort, shared
from .errors import GenoMError, RefusalError
from .runner._kinds import Enum, Kind, Number, Optional_, Text
from .runner._lists import Array, SequenceKind
from .runner._records import Record


class Passed:
    """A port that is passed on."""

    def __init__(self, daemon: Daemon, address: str, forget: Callable[["Passed"], None]) -> None:
        self._daemon, self._address = daemon, address
        described = self._ask("GET")
        where, _, query = path(address).partition("?")
        layout = daemon._transport.request("GET", where + "/type")
        one = layout["types"][0]
        if not one["fixed"]:
            raise RefusalError(
                "bad_input", f"{address} cannot be shared: values of {layout['name']} are not of one size",
                help="read and publish it through the component: component.PORT",
            )
        self._digest = layout["digest"]
        self._is_in = described["direction"] == "in"
        file = os.memfd_create("genom-port")
        os.ftruncate(file, VALUE_AT + one["size"])
        # What of it was passed on: how often the program wrote, or samples of codels.
        self._count = 0
        self.port: SharedPort = shared(address, layout, self._is_in, file, lambda: forget(self))
        self._took(described)

    def publish(self) -> None:
        """Before a step: what the program wrote to an in port."""
        if not self._is_in or self.port._written.value == self._count:
            return
        # A value that is refused is refused once.
        self._count = self.port._written.value
        self._ask("POST", plain(self.port._kind, self.port._value()))

    def show(self) -> None:
        """After a step: what codels wrote to an out port."""
        try:
            described = self._ask("GET")
        except RefusalError:
            # Its cell is down, or it is not there any more.
            self.port._gone.value = 1
            return
        if self.port._gone.value and not self._same():
            return
        self.port._gone.value = 0
        if not self._is_in:
            self._took(described)

    def _same(self) -> bool:
        """Whether the port that is there now has the type of the one before."""
        where, _, _ = path(self._address).partition("?")
        return bool(self._daemon._transport.request("GET", where + "/type")["digest"] == self._digest)

    def _took(self, described: Dict[str, Any]) -> None:
        port, value = self.port, described.get("value")
        samples = (described.get("traffic") or {}).get("samples", 0)
        if value is not None and (self._is_in or samples != self._count):
            port._kind.put(port._at, valued(port._kind, value))
        if not self._is_in:
            self._count = port._written.value = samples

    def _ask(self, method: str, body: Any = None) -> Any:
        return self._daemon._transport.request(method, path(self._address), body)


def passed(daemon: Any, address: str, why: GenoMError) -> Optional[Passed]:
    """The port, if its component is in a cell; `why` tells that it is not in the daemon's process."""
    component = address.partition("/")[0]
    listed = daemon._transport.request("GET", "/components")["components"]
    if why.name != "no_such_component" or not any(
        one["name"] == component and one.get("cell") for one in listed
    ):
        return None
    return Passed(daemon, address, daemon._passed.remove)


def plain(kind: Kind, value: Any) -> Any:
    """The value as the control plane takes it."""
    if isinstance(kind, Record):
        pairs = zip(kind.members, kind.given_names)
        return {
            given: plain(kind._kinds[rank], getattr(value, name)) for (name, _, rank), given in pairs
        }
    if isinstance(kind, Optional_):
        return None if value is None else plain(kind.inner, value)
    if isinstance(kind, (Array, SequenceKind)):
        if hasattr(value, "tolist"):
            return value.tolist()
        return [plain(kind.inner, one) for one in value]
    if isinstance(kind, Enum):
        return getattr(value, "name", value)
    if isinstance(kind, (Number, Text)) or isinstance(value, str):
        return value
    raise RefusalError("bad_input", f"{kind.name} is not passed to components in cells")


def valued(kind: Kind, value: Any) -> Any:
    """The value that the control plane gave."""
    if isinstance(kind, Record):
        pairs = zip(kind.members, kind.given_names)
        return {name: valued(kind._kinds[rank], value[given]) for (name, _, rank), given in pairs}
    if isinstance(kind, Optional_):
        return None if value is None else valued(kind.inner, value)
    if isinstance(kind, (Array, SequenceKind)):
        return [valued(kind.inner, one) for one in value]
    if isinstance(kind, Number) and kind.range is None:
        return float("nan") if value is None else float(value) if kind.keyword != "boolean" else value
    if isinstance(kind, (Number, Enum, Text)) or isinstance(value, str):
        return value
    raise RefusalError("bad_input", f"{kind.name} is not passed from components in cells")
