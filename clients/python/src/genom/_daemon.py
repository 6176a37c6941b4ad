"""Requests about the daemon and its middlewares; `client` adds components as objects."""

from __future__ import annotations

import json
import os
from typing import Any, Dict, List, Optional

from ._http import Transport, url
from ._watch import Watch
from .errors import RefusalError


class Daemon:
    """A daemon, and how to reach it."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._watch = Watch(transport)
        # In ports fed by this program's publishers, by the names the program gave these.
        self._named: Dict[str, str] = {}
        self._meet: Optional[Dict[str, Dict[str, str]]] = None

    def about(self) -> Dict[str, Any]:
        """Version, process, and default middleware of the daemon."""
        return dict(self._transport.request("GET", "/"))

    def components(self) -> List[str]:
        """Instance names of the running components."""
        listed = self._transport.request("GET", "/components")["components"]
        return [one["name"] for one in listed]

    def connect_port(self, inport: str, outport: str, **options: Any) -> Dict[str, Any]:
        """Connects an in port to an out port, both ``component/port``.

        ``policy`` is ``latest``, ``queue:N`` or ``ring:N``. With ``wait=True`` the out port need
        not exist yet. ``over`` names a middleware, on which the out port is opened as long as the
        connection lasts if it is not there.
        """
        if self._named.get(outport) == inport:
            return {"in": inport, "out": inport}
        body = {"in": inport, "out": outport, **options}
        return dict(self._transport.request("POST", "/connections", body))

    def step(self, seconds: float) -> float:
        """Advances the clock of a daemon with ``--clock virtual``; returns its new time."""
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
        """Applies a deployment file; returns the steps taken.

        ``timeout`` is how long connections may wait for their other side; with ``dry_run`` no step
        is taken.
        """
        with open(file, encoding="utf-8") as opened:
            text = opened.read()
        body: Dict[str, Any] = {"text": text, "file": os.path.abspath(file)}
        body.update(dry_run=dry_run, timeout=timeout)
        if daemon is not None:
            body["daemon"] = daemon
        return list(self._transport.request("POST", "/deployment", body)["steps"])

    def dump(self) -> str:
        """The running system, as text of a deployment file."""
        return str(self._transport.request("GET", "/deployment")["text"])

    def freeze(self, file: str) -> None:
        """Writes the state of the running system into a file, readable by its owner only."""
        text = json.dumps(self._transport.request("POST", "/freeze"), indent=1) + "\n"
        aside = f"{file}.{os.getpid()}"
        descriptor = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            with open(descriptor, "w", encoding="utf-8") as opened:
                opened.write(text)
            os.replace(aside, file)
        except BaseException:
            os.unlink(aside)
            raise

    def thaw(self, file: str, *, replace: bool = False) -> Dict[str, List[str]]:
        """Brings back what ``freeze`` wrote; returns what was not taken over, by component."""
        with open(file, encoding="utf-8") as opened:
            body = {"frozen": json.load(opened), "replace": replace}
        thawed = self._transport.request("POST", "/thaw", body)["components"]
        return {one["name"]: list(one.get("notes", [])) for one in thawed}

    def why(self, address: str) -> List[Dict[str, Any]]:
        """Why no data flows through ``component/port``, or why calls of a remote fail."""
        component, _, port = address.partition("/")
        path = url("components", component, "ports", port.split("/", 1)[0], "why")
        return list(self._transport.request("GET", path)["findings"])

    def stats(self, component: str) -> Dict[str, Any]:
        """Statistics of the tasks and codels of a component."""
        return dict(self._transport.request("GET", url("components", component, "tasks")))

    def _meeting_point(self, backend: str) -> Dict[str, str]:
        """The settings that a program needs to meet the daemon on a middleware."""
        # A middleware that was not open when asked for has no settings yet.
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
        """The address of these settings that can be reached from another machine."""
        host = self._transport.host
        ends = [end for end in meet.get("connect", "").split(",") if not end.startswith("unixsock")]
        ends = [end.replace("0.0.0.0", host).replace("[::]", host) for end in ends if end and host]
        far = {"prefix": meet.get("prefix", "")}
        return {**far, "connect": ",".join(ends)} if ends else far

    def _visible(self, backend: str) -> List[Dict[str, str]]:
        """The endpoints that the daemon sees on a middleware."""
        listed = self._transport.request("GET", "/middlewares?visible=true")["middlewares"]
        return [end for one in listed if one["name"] == backend for end in one.get("endpoints", [])]


class Part:
    """Something in a daemon that has a name."""

    def __init__(self, daemon: Daemon, name: str) -> None:
        self._client = daemon
        self._name = name
