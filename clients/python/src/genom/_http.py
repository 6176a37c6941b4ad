"""HTTP/1.1 with JSON bodies over Unix sockets or TCP, with one connection per thread."""

from __future__ import annotations

import functools
import http.client
import io
import json
import math
import os
import socket
import ssl
import stat
import threading
import time
import weakref
from typing import Any, Callable, Dict, List, Optional, Tuple
from urllib.parse import quote

from . import _numbers, _silence
from ._far import Far
from ._target import Target
from .errors import DaemonError, refusal

# Seconds that an idle connection is kept; the daemon closes it after 10 s.
_IDLE = 5.0
# Seconds after which the daemon sends a comment on an idle stream.
_SIGN_OF_LIFE = 5.0


def url(*segments: str) -> str:
    """A path of the control plane; each name stays within its segment."""
    return "".join("/" + quote(segment, safe="") for segment in segments)


class _Patient(io.RawIOBase):
    """A socket's reader that calls a function when nothing arrives within the timeout."""

    def __init__(self, sock: Any, whole: Any, silent: Callable[[Any], None]) -> None:
        self._sock = sock
        # Keeps the socket open while it is read.
        self._whole = whole
        self._silent = silent

    def readable(self) -> bool:
        return True

    def readinto(self, room: Any) -> int:
        while True:
            try:
                return int(self._sock.recv_into(room))
            except socket.timeout:
                self._silent(self._sock)

    def close(self) -> None:
        if not self.closed:
            super().close()
            self._whole.close()


class _Response(http.client.HTTPResponse):
    def __init__(self, sock: Any, *args: Any, silent: Callable[[Any], None], **more: Any) -> None:
        super().__init__(sock, *args, **more)
        self.fp = io.BufferedReader(_Patient(sock, self.fp, silent))


class _Connection(http.client.HTTPConnection):
    def patient(self, silent: Callable[[Any], None]) -> None:
        """Sets the function called on timeout: ``silent`` raises, or lets the read continue."""
        self.response_class = functools.partial(_Response, silent=silent)  # type: ignore[assignment]

    def __del__(self) -> None:
        # Threads come and go: the connections of those that ended are closed.
        self.close()


class _TlsConnection(_Connection, http.client.HTTPSConnection):
    pass


class _UnixConnection(_Connection):
    def __init__(self, path: str, timeout: Optional[float]) -> None:
        super().__init__("genomd", timeout=timeout)
        self._path = path

    def connect(self) -> None:
        _trusted(self._path)
        sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        sock.settimeout(self.timeout)
        try:
            _silence.connect(sock, self._path)
        except BaseException:
            sock.close()
            raise
        self.sock = sock


def _trusted(path: str) -> None:
    """Refuses a socket that another user may have created, as genomctl does."""
    try:
        place = os.stat(os.path.dirname(path) or ".")
        owners = {place.st_uid, os.lstat(path).st_uid}
    except OSError:
        return  # Connecting will report the error.
    open_to_all = place.st_mode & 0o002 and not place.st_mode & stat.S_ISVTX
    if open_to_all or not owners <= {0, os.geteuid()}:
        raise DaemonError(
            "unreachable",
            None,
            f"{path} is not used: another user may have put it there, and could answer as genomd",
        )


class _Idle(threading.local):
    connection: Optional[http.client.HTTPConnection] = None
    since = 0.0


class Transport:
    """Requests to one daemon; may be used from any thread."""

    def __init__(self, target: Target, timeout: Optional[float] = None) -> None:
        self._target = target
        self._timeout = timeout
        self._headers = {"Content-Type": "application/json"}
        # A token for a relayed daemon is not sent: its possession is proved instead.
        self._far: Optional[Far] = None
        if target.daemon is not None:
            self._far = Far(self._post, target.daemon, target.token)
        elif target.token is not None:
            self._headers["Authorization"] = "Bearer " + target.token
        self._idle = _Idle()
        self._open: "weakref.WeakSet[http.client.HTTPConnection]" = weakref.WeakSet()
        self.target = str(target)
        self.host = f"[{target.name}]" if ":" in target.name else target.name
        # Whether the daemon is on this machine, so that files and shared memory are the same.
        self.local = target.socket is not None and target.daemon is None

    def request(self, method: str, path: str, body: Any = None) -> Any:
        """Makes a request and waits for the reply."""
        text = None if body is None else json.dumps(_plain(body), allow_nan=False).encode()
        return self.send(method, path, text)

    def send(self, method: str, path: str, text: Optional[bytes]) -> Any:
        """The same with an encoded body."""
        if self._far is not None:
            status, data = self._far.request(method, path, text or b"")
        else:
            status, data = self._whole(method, path, text)
        try:
            reply = json.loads(data) if data else None
        except ValueError:
            raise DaemonError(
                "not_understood", None, f"what answers on {self.target} is no genomd"
            ) from None
        if status >= 300:
            raise refusal(reply, status)
        return reply

    def options(self) -> List[str]:
        """The options that select this daemon for genomctl."""
        return self._target.options

    def _post(self, path: str, body: bytes) -> Tuple[int, bytes]:
        return self._whole("POST", path, body)

    def _whole(self, method: str, path: str, body: Optional[bytes]) -> Tuple[int, bytes]:
        """Status and body of a reply of the connected daemon."""
        connection = self._take()
        try:
            response = self._send(connection, method, path, body, {})
            data = response.read()
        except (OSError, http.client.HTTPException) as error:
            connection.close()
            raise self._failed(error) from error
        except BaseException:
            # A part of the reply may still arrive: this connection cannot be used any more.
            connection.close()
            raise
        self._keep(connection)
        return response.status, data

    def stream(
        self, path: str, headers: Optional[Dict[str, str]] = None
    ) -> Tuple[Any, Any]:
        """Opens a stream of server-sent events; returns its own connection and the reply."""
        if self._far is not None:
            far = self._far.stream(path, headers or {})
            return far, far
        connection = self._connection()
        try:
            response = self._send(connection, "GET", path, None, headers or {})
            if self._timeout is not None and connection.sock is not None:
                # Such a stream is never silent for that long.
                connection.sock.settimeout(_SIGN_OF_LIFE + self._timeout)
            if response.status >= 300:
                raise refusal(json.loads(response.read() or b"null"), response.status)
        except BaseException:
            connection.close()
            raise
        return connection, response

    def close(self) -> None:
        """Closes all connections; further requests open new ones."""
        for connection in list(self._open):
            connection.close()

    def _connection(self) -> _Connection:
        connection: _Connection
        to = self._target
        if to.socket is not None:
            connection = _UnixConnection(to.socket, self._timeout)
        elif to.tls is not None:
            connection = _TlsConnection(to.name, to.port, context=to.tls, timeout=self._timeout)
        else:
            connection = _Connection(to.name, to.port, timeout=self._timeout)
        connection.patient(self._silent)
        self._open.add(connection)
        return connection

    def _take(self) -> http.client.HTTPConnection:
        """This thread's connection if the daemon has not closed it, else a new one."""
        connection, self._idle.connection = self._idle.connection, None
        if connection is not None and connection.sock is not None:
            fresh = time.monotonic() - self._idle.since < _IDLE
            # An idle connection has nothing to read but its end.
            if fresh and not _silence.readable(connection.sock, 0.0):
                return connection
            connection.close()
        return self._connection()

    def _keep(self, connection: http.client.HTTPConnection) -> None:
        self._idle.connection = connection
        self._idle.since = time.monotonic()

    def _send(
        self,
        connection: http.client.HTTPConnection,
        method: str,
        path: str,
        text: Optional[bytes],
        headers: Dict[str, str],
    ) -> http.client.HTTPResponse:
        try:
            try:
                connection.request(method, path, text, {**self._headers, **headers})
            except (BrokenPipeError, ConnectionResetError):
                # The daemon may reply before it has read everything; its reply says why.
                pass
            return connection.getresponse()
        except (OSError, http.client.HTTPException) as why:
            raise self._failed(why) from why

    def _silent(self, sock: Any) -> None:
        """Called when nothing arrives: checks whether the daemon is alive and may be busy with this
        request.
        """
        if _silence.is_stopped(sock):
            raise socket.timeout()
        probe = self._connection()
        try:
            probe.request("GET", "/", headers=self._headers)
            if not _silence.readable(probe.sock, self._timeout or 0.0):
                raise socket.timeout()
        except (BrokenPipeError, ConnectionResetError, ConnectionRefusedError):
            pass  # Its backlog is full, or it is gone: this connection will show which.
        finally:
            probe.close()

    def _failed(self, why: Exception) -> DaemonError:
        """Converts an error of a connection to one of this package."""
        at = self.target
        if isinstance(why, socket.timeout):
            return _silence.error(at, self._target.socket, self._timeout)
        if isinstance(why, (ConnectionRefusedError, FileNotFoundError, PermissionError, socket.gaierror)):
            name, told = "unreachable", (
                f"no genomd answers on {at}: {why.strerror}; start one with "
                "`genomd LIBRARY...`, or name its socket: connect(socket=...)"
            )
        elif isinstance(why, ssl.SSLError):
            name, told = "unreachable", (
                f"{at}: {why}; is `ca` the root of its certificate, and does it ask for a `cert`?"
            )
        else:
            name, told = "lost", f"genomd on {at} went away"
        return DaemonError(name, None, told)


def _plain(value: Any) -> Any:
    """Converts a value to the daemon's JSON: NaN and infinities, and numpy arrays to lists."""
    if isinstance(value, float):
        if math.isnan(value):
            return None
        return value if math.isfinite(value) else "inf" if value > 0.0 else "-inf"
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if _numbers.buffer(value) is not None:
        return _plain(value.tolist() if hasattr(value, "tolist") else list(value))
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    return value
