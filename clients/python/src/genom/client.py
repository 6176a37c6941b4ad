"""A daemon, with its components as objects."""

from __future__ import annotations

import os
from typing import Any, Callable, Dict, List, Optional, Tuple, Union

from ._daemon import Daemon
from ._http import Transport, url
from ._target import resolve
from .component import Component, Described
from .events import EventStream
from .recorder import Recorder


def connect(
    target: Optional[str] = None,
    *,
    socket: Optional[str] = None,
    host: Optional[str] = None,
    token: Optional[str] = None,
    token_file: Optional[str] = None,
    ca: Optional[str] = None,
    cert: Optional[str] = None,
    context: Optional[str] = None,
    timeout: Optional[float] = 10.0,
) -> "Client":
    """Connects to a daemon: by default that of this user, as genomctl does.

    ``socket`` is the path of its Unix socket. ``host`` is ``127.0.0.1:7300`` (``genomd --listen``),
    ``https://robot:7300`` on another machine, or ``zenoh:NAME`` for a daemon that the one at the
    socket sees. ``target`` is either of these. ``token``, or the one in ``token_file``,
    authenticates the caller. ``ca`` is the root of the daemon's certificate, ``cert`` your own
    certificate and its key, as PEM files. ``context`` is a name under which ``genomctl context``
    keeps such options; without other options the current context is used.

    If the daemon sends nothing for ``timeout`` seconds, on a request or a stream, and does not
    answer another request either, `DaemonError` is raised; with None, waiting has no limit. The
    duration of a service is not limited by this.
    """
    given = resolve(target, socket, host, token, token_file, ca, cert, context)
    client = Client(Transport(given, timeout))
    client.about()
    return client


def update() -> None:
    """Does nothing: results arrive by themselves. For scripts that call it."""


class Client(Daemon):
    """A daemon. `load` returns its components as objects."""

    def __init__(self, transport: Transport) -> None:
        super().__init__(transport)
        self._paths: List[str] = []

    def component(self, name: str) -> Component:
        """A running component, by its instance name."""
        return Component(self, self._transport.request("GET", url("components", name)))

    def load(
        self,
        library: str,
        *options: str,
        name: Optional[str] = None,
        backend: Optional[str] = None,
        gen: Optional[str] = None,
        cell: Optional[str] = None,
    ) -> Component:
        """The component of that name, loaded unless an instance of it is running already.

        ``library`` is a name on the daemon's component path, or a file. ``name`` is the instance
        name; ``load('demo', '-i', 'left')`` sets it, too. ``cell`` is the process that is to run it,
        which starts if it is not there.
        """
        name, backend = _options(options, name, backend)
        library = os.fspath(library)
        found = self._attached(library, name)
        if found is not None:
            return self.component(found)
        body = {"library": self._file(library)}
        for key, value in (("name", name), ("backend", backend), ("gen", gen), ("cell", cell)):
            if value is not None:
                body[key] = self._file(value) if key == "gen" else value
        loaded = self._transport.request("POST", "/components", body)
        return self.component(loaded["name"])

    def unload(self, component: Union[str, Described]) -> None:
        """Stops and unloads a component, given by its name, its library, or itself."""
        if isinstance(component, Described):
            Described.unload(component)
            return
        name = self._attached(os.fspath(component), None)
        self._transport.request("DELETE", url("components", name or component))

    def record(self, file: str, *ports: str, force: bool = False) -> Recorder:
        """Records ports (by default everything) and services in an MCAP file, until closed.

        It runs `genomctl record`, which has to be on ``PATH`` or given by ``$GENOMCTL``.
        """
        return Recorder(self._transport.options(), file, ports, force)

    def events(
        self,
        callback: Optional[Callable[[Dict[str, Any]], None]] = None,
        *,
        after: Optional[int] = None,
    ) -> EventStream:
        """Changes in the daemon from now on: iterate over them, also with ``async for``.

        With a callback, this is called for each change, from a thread of its own. ``after`` is the
        number of a change: the daemon sends the kept changes since then first.
        """
        stream = EventStream(self._transport, after=after)
        return stream if callback is None else stream.follow(callback)

    def update(self) -> None:
        """Does nothing: results arrive by themselves. For scripts that call it."""

    def rpath(self, path: Optional[str] = None) -> List[str]:
        """Adds a directory that `load` searches before the daemon's component path."""
        if path is not None:
            self._paths.append(os.fspath(path))
        return list(self._paths)

    def disconnect(self) -> None:
        """Closes the connections; components and activities go on."""
        self._watch.close()
        self._transport.close()

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.disconnect()

    def __repr__(self) -> str:
        return f"<genomd on {self._transport.target}>"

    def _attached(self, library: str, name: Optional[str]) -> Optional[str]:
        """The instance of this library or name, if it is running."""
        if name is not None:
            return name if name in self.components() else None
        running = self._transport.request("GET", "/components")["components"]
        if any(one["name"] == library for one in running):
            return library
        file = os.path.realpath(self._file(library))
        for one in running:
            if os.path.realpath(one["library"]) == file:
                return str(one["name"])
        return None

    def _file(self, name: str) -> str:
        """The absolute path of a file: the daemon has another working directory."""
        if not self._transport.local:
            return name
        candidates = [name] if "/" in name else []
        for folder in self._paths:
            candidates += [os.path.join(folder, name), os.path.join(folder, name + ".so")]
        for candidate in candidates:
            if os.path.isfile(candidate):
                return os.path.abspath(candidate)
        return name

def _options(
    options: Tuple[str, ...], name: Optional[str], backend: Optional[str]
) -> Tuple[Optional[str], Optional[str]]:
    left = list(options)
    while left:
        option = left.pop(0)
        if not left:
            raise TypeError(f"load(): option `{option}` wants a value")
        if option in ("-i", "--name"):
            name = left.pop(0)
        elif option in ("-b", "--backend"):
            backend = left.pop(0)
        else:
            raise TypeError(f"load() knows -i NAME and -b BACKEND, not `{option}`")
    return name, backend
