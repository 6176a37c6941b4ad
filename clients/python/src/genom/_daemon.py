"""What a daemon says of itself and its middlewares; `client` makes its components into objects."""

from __future__ import annotations

import os
from typing import Any, Dict, List, Optional

from ._http import Transport, url
from ._watch import Watch
from .errors import RefusalError


class Daemon:
    """One daemon, and the way to it."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._watch = Watch(transport)
        # Names that programs gave what they publish, and the in ports it feeds.
        self._named: Dict[str, str] = {}
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
        if self._named.get(outport) == inport:
            return {"in": inport, "out": inport}
        body = {"in": inport, "out": outport, **options}
        return dict(self._transport.request("POST", "/connections", body))

    def step(self, seconds: float) -> float:
        """Has time go on by so much, in a daemon with ``--clock virtual``; the time it is then."""
        body = {"nanoseconds": round(seconds * 1e9)}
        return float(self._transport.request("POST", "/clock", body)["now"]) / 1e9

    def apply(
        self,
        file: str,
        *,
        daemon: Optional[str] = None,
        dry_run: bool = False,
        timeout: float = 10.0,
    ) -> List[str]:
        """Brings the daemon to what a deployment file says; the steps that this took.

        ``timeout`` is for the other side of connections; ``dry_run`` only tells the steps.
        """
        with open(file, encoding="utf-8") as opened:
            text = opened.read()
        body: Dict[str, Any] = {"text": text, "file": os.path.abspath(file)}
        body.update(dry_run=dry_run, timeout=timeout)
        if daemon is not None:
            body["daemon"] = daemon
        return list(self._transport.request("POST", "/deployment", body)["steps"])

    def dump(self) -> str:
        """What runs, as the text of a deployment file."""
        return str(self._transport.request("GET", "/deployment")["text"])

    def why(self, address: str) -> List[Dict[str, Any]]:
        """Why no data flows through ``component/port``, or why a remote calls nothing."""
        component, _, port = address.partition("/")
        path = url("components", component, "ports", port.split("/", 1)[0], "why")
        return list(self._transport.request("GET", path)["findings"])

    def stats(self, component: str) -> Dict[str, Any]:
        """Figures on the tasks and codels of a component."""
        return dict(self._transport.request("GET", url("components", component, "tasks")))

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
