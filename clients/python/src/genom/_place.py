"""A port as the daemon sees it: address, type, value and connection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Optional

from ._daemon import Daemon
from ._http import url


@dataclass(frozen=True)
class Now:
    """The present connection of a port."""

    backends: List[str]
    """Its middlewares."""
    source: Optional[str]
    """What an in port reads, if it is connected."""
    on: Optional[str]
    """The middleware of that connection."""


class Place:
    """A port of a component, read and written through the daemon."""

    def __init__(self, daemon: Daemon, component: str, description: Dict[str, Any]) -> None:
        self._client = daemon
        self._component = component
        self._description = description
        self._layout: Optional[Dict[str, Any]] = None
        self.name: str = description["name"]
        self.direction: str = description["direction"]
        self.type: str = description["type"]

    def read(self, element: Optional[str] = None) -> Any:
        """The last value; None if there was none. ``element`` is one of a multiple port."""
        return self._get(element).get("value")

    def connected(self, element: Optional[str] = None) -> Optional[str]:
        """The address that an in port is connected to, if any."""
        found = self._get(element).get("connected")
        return None if found is None else str(found)

    def connect(
        self, outport: str, *, element: Optional[str] = None, **options: Any
    ) -> Dict[str, Any]:
        """Connects this in port to ``component/port``; for the options see `Client.connect_port`.
        """
        return self._client.connect_port(self.address(element), outport, **options)

    def disconnect(self, element: Optional[str] = None) -> None:
        """Disconnects this in port."""
        path = ["connections", self._component, self.name]
        path += [] if element is None else [element]
        self._client._transport.request("DELETE", url(*path))

    def why(self) -> List[Dict[str, Any]]:
        """Why no data flows through the port: ``what`` and ``fix`` of each reason; empty if data
        flows.
        """
        path = url("components", self._component, "ports", self.name, "why")
        return list(self._client._transport.request("GET", path)["findings"])

    def publish(self, value: Any, element: Optional[str] = None) -> Any:
        """Publishes a value to this in port through the daemon; returns the whole value."""
        path = self._path(element)
        return self._client._transport.request("POST", path, value)["value"]

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

    def now(self, element: Optional[str] = None) -> Now:
        """The present connection."""
        request = self._client._transport.request
        listed = request("GET", url("components", self._component, "ports") + "?values=false")
        here = self.address(element)
        named = [one for one in listed["ports"] if one["name"] == self.name]
        # An element that is not open yet has the middlewares of its port.
        found = next((one for one in named if one["address"] == here), None)
        backends = str((found or named[0])["backend"]).split("+") if named else []
        source = None if found is None else found.get("connected")
        on = None
        if source is not None:
            made = request("GET", "/connections")["connections"]
            on = next((one.get("backend") for one in made if one["in"] == here), None)
        return Now(backends, source, on)

    def layout(self, anew: bool = False) -> Dict[str, Any]:
        """The memory layout of the port's type; with ``anew``, asked for again."""
        if self._layout is None or anew:
            path = url("components", self._component, "ports", self.name, "type")
            self._layout = dict(self._client._transport.request("GET", path))
        return self._layout
