"""Ports: read them, subscribe to them, publish to them, connect them.

Values are transmitted through the daemon; or directly over shared memory, if the package iceoryx2
is installed and the port's type has a fixed size; or directly over zenoh, if the package
eclipse-zenoh is installed. The objects are the same in all cases.
"""

from __future__ import annotations

from typing import Any, Dict, Optional

from ._daemon import Daemon
from ._ends import Publisher, Subscription
from ._place import Place
from ._ways import Wish
from .errors import RefusalError


class Port(Place):
    """A port of a component. Calling it reads the port."""

    def __call__(self, element: Optional[str] = None) -> "Reading":
        """The last value, under the port's name: ``{'position': {...}}``.

        The result also has the methods of that element: ``c.state('robot').publisher()``. For a
        single in port any name may be given: it names a publisher, to which
        ``c.connect_port('state', 'name')`` connects the port.
        """
        if element is not None and self.direction == "in":
            name, element = element, element if self._description["multiple"] else None
            self._client._named[name] = self.address(element)
        return Reading(self, element, self.read(element))

    def publisher(
        self, element: Optional[str] = None, *, fast: Optional[bool] = None
    ) -> Publisher:
        """Opens a publisher to this in port.

        With ``fast=True`` it uses shared memory or zenoh, or fails; with ``fast=False`` the daemon;
        by default the fastest way available.
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
        """Subscribes to this port: the last value first, then each new one.

        ``fast`` as for `publisher`. Directly, every sample is received as long as no more than
        ``depth`` wait to be read; through the daemon, changed values at most ``rate`` times per
        second. A subscription to an in port receives what the in port reads. With ``buffers``,
        sequences and arrays of numbers are `memoryview` rather than lists; numpy accepts them
        without a copy.
        """
        return Subscription(self, element, fast, Wish(depth, rate, buffers))


class Reading(Dict[str, Any]):
    """The value of a port or element under the port's name, with the methods of that port."""

    def __init__(self, port: Port, element: Optional[str], value: Any) -> None:
        super().__init__({port.name: value})
        self.port = port
        self.element = element

    def publisher(self, *, fast: Optional[bool] = None) -> Publisher:
        """See `Port.publisher`."""
        return self.port.publisher(self.element, fast=fast)

    def subscribe(self, **options: Any) -> Subscription:
        """See `Port.subscribe`."""
        return self.port.subscribe(self.element, **options)

    def connect(self, outport: str, **options: Any) -> Dict[str, Any]:
        """See `Port.connect`."""
        return self.port.connect(outport, element=self.element, **options)

    def disconnect(self) -> None:
        """See `Port.disconnect`."""
        self.port.disconnect(self.element)


def port_of(daemon: Daemon, component: str, description: Dict[str, Any]) -> Port:
    """A port with a class of its own, so that help() describes this port."""
    told = [description.get("doc") or "", f"{description['direction']} port of type {description['type']}."]
    body = {"__doc__": "\n\n".join(text for text in told if text), "__module__": "genom"}
    made: Port = type(description["name"], (Port,), body)(daemon, component, description)
    return made
