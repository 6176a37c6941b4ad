"""A session with a daemon behind the one at the socket, which relays the messages."""

from __future__ import annotations

import json
import threading
import time
from typing import Any, Callable, Dict, Optional, Tuple
from urllib.parse import quote

from ._proof import Greeting, Session, Token, decode, encode
from .errors import DaemonError, refusal

# Seconds after which an unused session is replaced: the daemon drops idle sessions later.
_IDLE = 60.0

# Posts bytes to the daemon at the socket; returns status and body of the reply.
Near = Callable[[str, bytes], Tuple[int, bytes]]


class Far:
    """A daemon that has to prove itself before anything is asked of it."""

    def __init__(self, near: Near, daemon: str, token: Optional[str]) -> None:
        self._near = near
        self._daemon = daemon
        self._token = None if token is None else Token(token)
        self._lock = threading.Lock()
        self._session: Optional[Session] = None
        self._used = 0.0

    def request(self, method: str, path: str, body: bytes = b"") -> Tuple[int, bytes]:
        """Makes a request as over HTTP, and waits for the whole reply: status and body."""
        session = self._met()
        answer, data = self._request(session, method, path, {}, body)
        stream = answer.get("stream")
        while stream is not None:
            more, piece = self._ask(session, {"more": stream})
            data, stream = data + piece, more.get("stream")
        return int(answer["status"]), data

    def stream(self, path: str, headers: Dict[str, str]) -> "FarStream":
        """Opens a stream of server-sent events."""
        session = self._met()
        answer, data = self._request(session, "GET", path, headers, b"")
        if answer["status"] >= 300:
            raise refusal(json.loads(data or b"null"), int(answer["status"]))
        return FarStream(lambda asked: self._ask(session, asked), answer.get("stream"), data)

    def _request(
        self, session: Session, method: str, path: str, headers: Dict[str, str], body: bytes
    ) -> Tuple[Dict[str, Any], bytes]:
        asked: Dict[str, Any] = {"method": method, "path": path}
        if "Last-Event-ID" in headers:
            asked["last_event_id"] = headers["Last-Event-ID"]
        waits = "wait=" in path or path == "/deployment"
        return self._ask(session, {"request": asked}, body, waits)

    def _met(self) -> Session:
        with self._lock:
            if self._session is None or time.monotonic() - self._used > _IDLE:
                self._session = self._meet()
            self._used = time.monotonic()
            return self._session

    def _meet(self) -> Session:
        if self._token is None:
            message = f"a token is needed here: daemon {self._daemon} asks who you are"
            raise refusal({"error": {"code": "unauthorized", "message": message}}, 401)
        greeting = Greeting(self._token, self._daemon)
        status, data = self._near(f"/daemons/{quote(self._daemon, safe='')}/hello", greeting.message())
        reply = json.loads(data or b"null")
        if status >= 300:
            raise refusal(reply, status)
        return greeting.meet([(one["at"], one["message"].encode()) for one in reply["answers"]])

    def _ask(
        self, session: Session, asked: Dict[str, Any], body: bytes = b"", waits: bool = False
    ) -> Tuple[Dict[str, Any], bytes]:
        number, sealed = session.seal(encode(asked, body))
        path = f"/daemons/{quote(self._daemon, safe='')}/questions"
        wait = "true" if waits else "false"
        status, data = self._near(f"{path}?at={quote(session.at, safe='')}&wait={wait}", sealed)
        if status >= 300:
            raise refusal(json.loads(data or b"null"), status)
        try:
            answer = session.open(number, data)
        except DaemonError:
            # The next request starts a new session; this one is not repeated.
            with self._lock:
                self._session = None
            raise
        return decode(answer)


class FarStream:
    """A stream that is fetched piece by piece; stands for a connection and its response."""

    def __init__(
        self,
        ask: Callable[[Dict[str, Any]], Tuple[Dict[str, Any], bytes]],
        stream: Optional[int],
        data: bytes,
    ) -> None:
        self._ask = ask
        self._stream = stream
        self._data = data
        self._over = False
        self.sock = self

    def readline(self) -> bytes:
        """The next line, or the rest at the end of the stream."""
        while b"\n" not in self._data:
            if self._over or self._stream is None:
                rest, self._data = self._data, b""
                return rest
            try:
                answer, piece = self._ask({"more": self._stream})
            except DaemonError as why:
                raise OSError(str(why)) from why
            self._data += piece
            if answer.get("stream") is None:
                self._stream = None
        line, _, self._data = self._data.partition(b"\n")
        return line + b"\n"

    def shutdown(self, _how: int) -> None:
        """Ends the stream for readers."""
        self._over = True

    def close(self) -> None:
        """Tells the daemon that the stream is not read any more."""
        stream, self._stream, self._over = self._stream, None, True
        if stream is not None:
            try:
                self._ask({"end": stream})
            except DaemonError:
                pass
