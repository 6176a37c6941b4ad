"""Ports: read them, follow them, publish to them, connect them.

Values go through the daemon; or straight through shared memory when the package iceoryx2 is
installed and the port's type has a fixed size; or straight over zenoh when the package
eclipse-zenoh is. The objects are the same.
"""

from __future__ import annotations

from typing import Any, Dict, Optional

from ._daemon import Daemon
from ._ends import Publisher, Subscription
from ._place import Place
from ._ways import Wish
from .errors import RefusalError


class Port(Place):
    """A port of a component. Calling it reads it."""

    def __call__(self, element: Optional[str] = None) -> "Reading":
        """The last value, under the port's name: ``{'position': {...}}``.

        What comes has the ends of that element, too: ``c.state('robot').publisher()``. A single in
        port takes any name: it is that of a publisher, and ``c.connect_port('state', 'name')``
        connects the port to it.
        """
        if element is not None and self.direction == "in":
            name, element = element, element if self._description["multiple"] else None
            self._client._named[name] = self.address(element)
        return Reading(self, element, self.read(element))

    def publisher(
        self, element: Optional[str] = None, *, fast: Optional[bool] = None
    ) -> Publisher:
        """Feeds this in port from here.

        ``fast=True`` insists on shared memory or zenoh, ``fast=False`` goes through the daemon; by
        default the fast way is used where it can be.
        """
        here = self.address(element)
        if self.direction != "in":
            raise RefusalError("out_port", f"{here} is an out port: codels write it")
        feed = self.connected(element)
        if feed is not None and feed != here:
            raise RefusalError(
                "connected", f"{here} reads {feed}",
                help="disconnect() it first, to feed it from here",
            )
        return Publisher(self, element, fast)

    def subscribe(
        self,
        element: Optional[str] = None,
        *,
        fast: Optional[bool] = None,
        depth: int = 16,
        rate: float = 1000.0,
        buffers: bool = False,
    ) -> Subscription:
        """Follows this port: its last value first, then each one that is written.

        ``fast`` as of `publisher`. The fast way every sample comes, as long as no more than
        ``depth`` wait to be read; through the daemon values that changed, ``rate`` times a second.
        An in port is followed where it reads. With ``buffers``, sequences and arrays of numbers
        come as a `memoryview`, which numpy takes as it is, rather than as a list.
        """
        return Subscription(self, element, fast, Wish(depth, rate, buffers))


class Reading(Dict[str, Any]):
    """The value of a port, or of an element, under the port's name; and what can be done there."""

    def __init__(self, port: Port, element: Optional[str], value: Any) -> None:
        super().__init__({port.name: value})
        self.port = port
        self.element = element

    def publisher(self, *, fast: Optional[bool] = None) -> Publisher:
        """As `Port.publisher`."""
        return self.port.publisher(self.element, fast=fast)

    def subscribe(self, **options: Any) -> Subscription:
        """As `Port.subscribe`."""
        return self.port.subscribe(self.element, **options)

    def connect(self, outport: str, **options: Any) -> Dict[str, Any]:
        """As `Port.connect`."""
        return self.port.connect(outport, element=self.element, **options)

    def disconnect(self) -> None:
        """As `Port.disconnect`."""
        self.port.disconnect(self.element)


def port_of(daemon: Daemon, component: str, description: Dict[str, Any]) -> Port:
    """A port with a class of its own, so that help() tells of this very port."""
    told = [description.get("doc") or "", f"{description['direction']} port of type {description['type']}."]
    body = {"__doc__": "\n\n".join(text for text in told if text), "__module__": "genom"}
    made: Port = type(description["name"], (Port,), body)(daemon, component, description)
    return made
