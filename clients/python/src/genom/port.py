"""Ports: read them, follow them, publish to them, connect them.

Values go through the daemon; or straight through shared memory when the package iceoryx2 is
installed and the port's type has a fixed size; or straight over zenoh when the package
eclipse-zenoh is. The objects are the same.
"""

from __future__ import annotations

import math
import os
import queue
import threading
import time
from typing import TYPE_CHECKING, Any, Dict, Iterator, Optional

from ._http import url
from .errors import GenoMError, RefusalError
from .events import EventStream

if TYPE_CHECKING:
    from .client import Client

# Nobody is told when a sample lies in shared memory: it is looked for all the time at first, then
# so often.
_EAGER = 0.002
_LOOK = 0.0002


class _Values(EventStream):
    """Values of a port as the daemon sends them."""

    _kind = "value"
    _resumes = False


class Port:
    """A port of a component. Calling it reads it."""

    def __init__(
        self, client: "Client", component: str, description: Dict[str, Any], backend: str
    ) -> None:
        self._client = client
        self._component = component
        self._description = description
        self._backend = backend
        self._layout: Optional[Dict[str, Any]] = None
        self.name: str = description["name"]
        self.direction: str = description["direction"]
        self.type: str = description["type"]

    def __call__(self, element: Optional[str] = None) -> Dict[str, Any]:
        """The last value, under the port's name: ``{'position': {...}}``."""
        return {self.name: self.read(element)}

    def read(self, element: Optional[str] = None) -> Any:
        """The last value; None when there was none. ``element`` is one of a multiple port."""
        return self._get(element).get("value")

    def connected(self, element: Optional[str] = None) -> Optional[str]:
        """The address that an in port reads, if it is connected."""
        found = self._get(element).get("connected")
        return None if found is None else str(found)

    def connect(self, outport: str, **options: Any) -> Dict[str, Any]:
        """Connects this in port to ``component/port``; options as of `Client.connect_port`."""
        return self._client.connect_port(self.address(), outport, **options)

    def disconnect(self, element: Optional[str] = None) -> None:
        """Disconnects this in port."""
        path = ["connections", self._component, self.name]
        path += [] if element is None else [element]
        self._client._transport.request("DELETE", url(*path))

    def publish(self, value: Any, element: Optional[str] = None) -> Any:
        """Publishes one value to this in port, through the daemon; returns the whole value."""
        path = self._path(element)
        return self._client._transport.request("POST", path, value)["value"]

    def publisher(
        self, element: Optional[str] = None, *, fast: Optional[bool] = None
    ) -> "Publisher":
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
    ) -> "Subscription":
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

    def address(self, element: Optional[str] = None) -> str:
        """``component/port``, or ``component/port/element``."""
        return "/".join([self._component, self.name] + ([] if element is None else [element]))

    def __repr__(self) -> str:
        return f"<{self.direction} port {self.address()}: {self.type}>"

    def _path(self, element: Optional[str], *more: str) -> str:
        path = url("components", self._component, "ports", self.name, *more)
        return path if element is None else path + "?element=" + url(element)[1:]

    def _get(self, element: Optional[str]) -> Dict[str, Any]:
        return dict(self._client._transport.request("GET", self._path(element)))

    def _source(self, element: Optional[str]) -> Optional[str]:
        """Where the values come from: an out port's own address."""
        return self.address(element) if self.direction == "out" else self.connected(element)

    def layout(self) -> Dict[str, Any]:
        """The port's type as it lies in memory."""
        if self._layout is None:
            path = url("components", self._component, "ports", self.name, "type")
            self._layout = dict(self._client._transport.request("GET", path))
        return self._layout

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
    client: "Client", component: str, description: Dict[str, Any], backend: str
) -> Port:
    """A port with a class of its own, so that help() tells of this very port."""
    told = [description.get("doc") or "", f"{description['direction']} port of type {description['type']}."]
    body = {"__doc__": "\n\n".join(text for text in told if text), "__module__": "genom"}
    made: Port = type(description["name"], (Port,), body)(client, component, description, backend)
    return made


class Publisher:
    """The writing end of an in port: ``p(0.5)`` or ``p(position=1.0)`` publishes."""

    fast = False
    """Whether values go straight through shared memory or over zenoh."""

    def __init__(self, port: Port, element: Optional[str]) -> None:
        self.port = port
        self._element = element

    def __call__(self, value: Any = None, **members: Any) -> None:
        """Publishes a value; members left out keep the value published last, at first zero."""
        if members:
            if value is not None:
                raise TypeError("a publisher takes a value or members, not both")
            value = members
        self.publish(value)

    def publish(self, value: Any) -> None:
        """Publishes a value."""
        self.port.publish(value, self._element)

    def close(self) -> None:
        """Takes the connection away, so that the component reads nothing from here."""
        try:
            self.port.disconnect(self._element)
        except GenoMError as error:
            if error.name != "not_connected":
                raise

    def __enter__(self) -> "Publisher":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Subscription:
    """The reading end of a port; iterate over it to wait for each value."""

    fast = False
    """Whether values come straight through shared memory or over zenoh."""

    def __init__(self, port: Port, element: Optional[str], rate: float) -> None:
        self.port = port
        self._last: Any = None
        self._new: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        self._ended = False
        path = port._path(element, "stream")
        path += ("&" if "?" in path else "?") + f"rate={rate}"
        self._stream = _Values(port._client._transport, path)
        threading.Thread(target=self._follow, name="genom-port", daemon=True).start()

    def take(self) -> Any:
        """The oldest value not taken yet; None when there is none."""
        try:
            return self._took(self._new.get_nowait())
        except queue.Empty:
            return None

    def read(self) -> Any:
        """The newest value, taken or not; None when there never was one."""
        while self.take() is not None:
            pass
        return self._last

    def wait(self, timeout: Optional[float] = None) -> Any:
        """The oldest value not taken yet, as soon as there is one; TimeoutError if none comes."""
        try:
            value = None if self._ended else self._took(self._new.get(timeout=timeout))
        except queue.Empty:
            raise TimeoutError(f"no value on {self.port.address()} for {timeout} s") from None
        if value is None:
            raise GenoMError("ended", None, f"{self.port.address()} is not followed any more")
        return value

    def close(self) -> None:
        """Stops following."""
        self._stream.close()

    def __iter__(self) -> Iterator[Any]:
        while True:
            try:
                yield self.wait()
            except GenoMError:
                return

    def __enter__(self) -> "Subscription":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _follow(self) -> None:
        for value in self._stream:
            # JSON has no number for it.
            self._new.put(math.nan if value is None else value)
        self._new.put(None)

    def _took(self, value: Any) -> Any:
        if value is None:
            self._ended = True
        else:
            self._last = value
        return value


def look_until(take: Any, timeout: Optional[float], what: str) -> Any:
    """Looks for a value until there is one."""
    begin = time.monotonic()
    while True:
        value = take()
        if value is not None:
            return value
        waited = time.monotonic() - begin
        if timeout is not None and waited >= timeout:
            raise TimeoutError(f"no value on {what} for {timeout} s")
        if waited < _EAGER:
            os.sched_yield()
        else:
            time.sleep(_LOOK)
