"""Server-sent events: what changes in the daemon, values of ports."""

from __future__ import annotations

import asyncio
import http.client
import json
import socket
import threading
from typing import Any, AsyncIterator, Callable, Dict, Iterator, List, Optional, Tuple

from ._http import Transport
from .errors import DaemonError


class EventStream:
    """Changes in the daemon as dicts, in order, from the time the stream was opened.

    Iterate over it, also with ``async for``; close it, or use it in a ``with``. A stream that
    breaks is resumed where it was. It ends when the daemon stops, or when it is closed.
    """

    _kind = "change"
    _resumes = True

    def __init__(
        self, transport: Transport, path: str = "/events", after: Optional[int] = None
    ) -> None:
        self._transport = transport
        self._path = path
        self._last = after
        self._closed = False
        self._over = False
        self._connect()

    def __iter__(self) -> Iterator[Dict[str, Any]]:
        return self

    def __next__(self) -> Any:
        while not self._closed and not self._over:
            found = self._parse()
            if found is None:
                self._again()
                continue
            kind, data = found
            if kind == self._kind:
                if isinstance(data, dict) and data.get("event") == "stopping":
                    self._over = True
                return data
            if kind == "end":
                self._over = True
        raise StopIteration

    async def __aiter__(self) -> AsyncIterator[Any]:
        """Waits in a thread, so that other tasks of asyncio go on."""
        loop = asyncio.get_running_loop()
        queue: "asyncio.Queue[Any]" = asyncio.Queue()
        end = object()

        def tell(item: Any) -> None:
            try:
                loop.call_soon_threadsafe(queue.put_nowait, item)
            except RuntimeError:
                self.close()  # The loop has ended: nobody iterates any more.

        def read() -> None:
            try:
                for item in self:
                    tell((item, None))
            except Exception as error:
                tell((None, error))
            tell(end)

        threading.Thread(target=read, name="genom-events", daemon=True).start()
        try:
            while True:
                told = await queue.get()
                if told is end:
                    return
                item, error = told
                if error is not None:
                    raise error
                yield item
        finally:
            self.close()

    def follow(self, callback: Callable[[Any], None]) -> "EventStream":
        """Calls ``callback`` with each event, from a thread of its own, until closed."""

        def read() -> None:
            for item in self:
                callback(item)

        threading.Thread(target=read, name="genom-events", daemon=True).start()
        return self

    def close(self) -> None:
        """Ends the stream, also for those who wait for an event."""
        self._closed = True
        sock = self._socket
        if sock is not None:
            try:
                sock.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def __enter__(self) -> "EventStream":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _connect(self) -> None:
        headers = {} if self._last is None else {"Last-Event-ID": str(self._last)}
        self._connection, self._response = self._transport.stream(self._path, headers)
        # Kept here, because http.client drops it when the reply announces the end of the
        # connection.
        self._socket: Any = self._connection.sock

    def _again(self) -> None:
        self._connection.close()
        if self._closed:
            return
        if not self._resumes:
            self._over = True
            return
        try:
            self._connect()
        except DaemonError as error:
            self._over = True
            if error.name == "no_answer":
                raise

    def _read(self, kind: str, text: str) -> Any:
        return json.loads(text)

    def _parse(self) -> Optional[Tuple[str, Any]]:
        """The next event, kind and data; None at the end of the connection."""
        kind = "message"
        data: List[str] = []
        while True:
            try:
                line = self._response.readline()
            except (OSError, ValueError, AttributeError, http.client.HTTPException):
                return None
            if not line.endswith(b"\n"):
                return None
            text = line.decode("utf-8", "replace").rstrip("\r\n")
            if not text:
                if data:
                    return kind, self._read(kind, "\n".join(data))
                kind = "message"
                continue
            field, _, value = text.partition(":")
            value = value[1:] if value.startswith(" ") else value
            if field == "event":
                kind = value
            elif field == "data":
                data.append(value)
            elif field == "id" and value.isdigit():
                self._last = int(value)
