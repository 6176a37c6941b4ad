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

    def __call__(self, element: Optional[str] = None) -> Dict[str, Any]:
        """The last value, under the port's name: ``{'position': {...}}``."""
        return {self.name: self.read(element)}

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


def port_of(daemon: Daemon, component: str, description: Dict[str, Any]) -> Port:
    """A port with a class of its own, so that help() tells of this very port."""
    told = [description.get("doc") or "", f"{description['direction']} port of type {description['type']}."]
    body = {"__doc__": "\n\n".join(text for text in told if text), "__module__": "genom"}
    made: Port = type(description["name"], (Port,), body)(daemon, component, description)
    return made
