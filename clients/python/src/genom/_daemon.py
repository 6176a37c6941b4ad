"""What a daemon says of itself and its middlewares; `client` makes its components into objects."""

from __future__ import annotations

from typing import Any, Dict, List, Optional

from ._http import Transport
from ._watch import Watch
from .errors import RefusalError


class Daemon:
    """One daemon, and the way to it."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._watch = Watch(transport)
        self._meet: Optional[Dict[str, Dict[str, str]]] = None

    def about(self) -> Dict[str, Any]:
        """What the daemon is: version, process, default backend."""
        return dict(self._transport.request("GET", "/"))

    def components(self) -> List[str]:
        """Instance names of the components that run."""
        listed = self._transport.request("GET", "/components")["components"]
        return [one["name"] for one in listed]

    def connect_port(self, inport: str, outport: str, **options: Any) -> Dict[str, Any]:
        """Connects an in port to an out port, both ``component/port``.

        ``policy`` is ``latest``, ``queue:N`` or ``ring:N``; ``wait=True`` connects to a port that
        comes later.
        """
        body = {"in": inport, "out": outport, **options}
        return dict(self._transport.request("POST", "/connections", body))

    def _meeting_point(self, backend: str) -> Dict[str, str]:
        """What a program must be told to meet the daemon on a middleware."""
        # A middleware that was not open yet when it was asked for tells nothing.
        if self._meet is None or not self._meet.get(backend):
            listed = self._transport.request("GET", "/middlewares")["middlewares"]
            self._meet = {one["name"]: one.get("meet", {}) for one in listed}
        if backend not in self._meet:
            raise RefusalError("unknown_backend", f"the daemon has no backend {backend}")
        meet = self._meet[backend]
        if backend == "zenoh" and not self._transport.local:
            meet = self._from_afar(meet)
        return meet

    def _from_afar(self, meet: Dict[str, str]) -> Dict[str, str]:
        """What of it leads from this machine to another one."""
        host = self._transport.host
        ends = [end for end in meet.get("connect", "").split(",") if not end.startswith("unixsock")]
        ends = [end.replace("0.0.0.0", host).replace("[::]", host) for end in ends if end and host]
        far = {"prefix": meet.get("prefix", "")}
        return {**far, "connect": ",".join(ends)} if ends else far

    def _visible(self, backend: str) -> List[Dict[str, str]]:
        """What the daemon sees on a middleware."""
        listed = self._transport.request("GET", "/middlewares?visible=true")["middlewares"]
        return [end for one in listed if one["name"] == backend for end in one.get("endpoints", [])]


class Part:
    """What a daemon knows by a name."""

    def __init__(self, daemon: Daemon, name: str) -> None:
        self._client = daemon
        self._name = name
