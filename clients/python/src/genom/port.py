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
        if self.direction != "in":
            raise RefusalError("out_port", f"{self.address(element)} is an out port: codels write it")
        feed = self.connected(element)
        if feed is not None and feed != self.address(element):
            raise RefusalError(
                "connected",
                f"{self.address(element)} reads {feed}",
                help="disconnect() it first, to feed it from here",
            )
        if self._is_fast(fast):
            address = self.address(element)
            # The daemon makes the place, and lets go of it if it published there.
            self._client.connect_port(address, address, backend=self._fast_backend())
            try:
                if self._fast_backend() == "zenoh":
                    from ._zenoh import ZenohPublisher

                    return ZenohPublisher(self, element)
                from ._shm import ShmPublisher

                return ShmPublisher(self, element)
            except BaseException:
                if feed is None:
                    self.disconnect(element)
                raise
        return Publisher(self, element)

    def subscribe(
        self,
        element: Optional[str] = None,
        *,
        fast: Optional[bool] = None,
        depth: int = 16,
        rate: float = 1000.0,
    ) -> Subscription:
        """Follows this port: its last value first, then each one that is written.

        ``fast`` as of `publisher`. The fast way every sample comes, as long as no more than
        ``depth`` wait to be read; through the daemon values that changed, ``rate`` times a second.
        An in port is followed where it reads.
        """
        if self._is_fast(fast) and self._source(element) is not None:
            if self._fast_backend() == "zenoh":
                from ._zenoh import ZenohSubscription

                return ZenohSubscription(self, element, depth)
            from ._shm import ShmSubscription

            return ShmSubscription(self, element, depth)
        return Subscription(self, element, rate)

    def _fast_backend(self) -> Optional[str]:
        """The middleware that is spoken from here, of those the component is on."""
        names = self._backend.split("+")
        return next((name for name in ("shm", "zenoh") if name in names), None)

    def _is_fast(self, wanted: Optional[bool]) -> bool:
        """Whether the fast way is to be used; an error when it is wanted and cannot be."""
        if wanted is False:
            return False
        why = self._why_slow()
        if why is not None and wanted:
            raise RefusalError("not_fast", f"{self.address()} has no fast path: {why}")
        return why is None

    def _why_slow(self) -> Optional[str]:
        backend = self._fast_backend()
        if backend is None:
            return f"it is on {self._backend}, not on shm or zenoh"
        if backend == "zenoh":
            try:
                import zenoh  # noqa: F401
            except ImportError:
                return "the package eclipse-zenoh is not installed"
            if "connect" not in self._client._meeting_point("zenoh"):
                return "the daemon's zenoh has no endpoint to connect to"
            return None
        if not self._client._transport.local:
            return "the daemon is on another machine"
        try:
            import iceoryx2  # noqa: F401
        except ImportError:
            return "the package iceoryx2 is not installed"
        if not self.layout()["types"][0]["fixed"]:
            return f"{self.type} has no fixed size"
        return None


def port_of(
    daemon: Daemon, component: str, description: Dict[str, Any], backend: str
) -> Port:
    """A port with a class of its own, so that help() tells of this very port."""
    told = [description.get("doc") or "", f"{description['direction']} port of type {description['type']}."]
    body = {"__doc__": "\n\n".join(text for text in told if text), "__module__": "genom"}
    made: Port = type(description["name"], (Port,), body)(daemon, component, description, backend)
    return made
