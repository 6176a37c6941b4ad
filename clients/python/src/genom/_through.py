"""Publishers and subscriptions through the daemon, which work everywhere."""

from __future__ import annotations

import base64
import math
import queue
import struct
import threading
from typing import Any, Callable, Optional

from . import _numbers
from ._cdr import Cdr
from ._http import Transport
from ._place import Place
from .errors import GenoMError, InputError
from .events import EventStream

_WAKE = object()
_LARGE = 4096


class _Values(EventStream):
    """The stream of a port's values."""

    _kind = "value"
    _resumes = False

    def __init__(self, transport: Transport, path: str, messages: bool) -> None:
        self._messages = messages
        super().__init__(transport, path)

    def _read(self, kind: str, text: str) -> Any:
        # A message is not JSON.
        return text if kind == "value" and self._messages else super()._read(kind, text)


class Writer:
    """Publishes by requests to the daemon."""

    def __init__(self, port: Place, element: Optional[str]) -> None:
        self._port = port
        self._element = element
        # The whole value published last.
        self._value: Any = None

    def publish(self, value: Any) -> None:
        """Publishes a value."""
        if not _numbers.many(value):
            self._value = self._port.publish(value, self._element)
            return
        # Many numbers are sent as a message, which is encoded much faster than JSON.
        here = self._port.address(self._element)
        try:
            cdr = Cdr(self._port.layout())
            merged = cdr.merge(cdr.zero() if self._value is None else self._value, value)
            message = cdr.encode(merged)
        except (TypeError, ValueError, AttributeError, KeyError, struct.error) as why:
            raise InputError("bad_input", f"{here}: {why}") from why
        parts = (here.encode(), message)
        body = b"".join(struct.pack("<I", len(part)) + part for part in parts)
        self._port._client._transport.send("POST", "/replay", body)
        self._value = merged

    def last(self) -> Any:
        """The value published last; None if there was none."""
        return self._value

    def repeat(self) -> None:
        """Nothing to do: the daemon keeps the last value."""

    def close(self) -> None:
        """Nothing to close."""


class Reader:
    """Receives values as the daemon sends them."""

    def __init__(self, port: Place, element: Optional[str], rate: float, buffers: bool) -> None:
        layout = port.layout()
        top = layout["types"][0]
        # JSON is faster for small values, messages for many numbers.
        message = buffers or not top["fixed"] or top["size"] > _LARGE
        self._cdr = Cdr(layout, buffers) if message else None
        self.ended = False
        self._new: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        path = port._path(element, "stream")
        path += ("&" if "?" in path else "?") + f"rate={rate}"
        path += "&form=message" if message else ""
        self._stream = _Values(port._client._transport, path, message)
        threading.Thread(target=self._follow, name="genom-port", daemon=True).start()

    def take(self) -> Any:
        """The oldest value not taken yet; None if there is none."""
        return self._get(lambda: self._new.get_nowait())

    def wait(self, left: Optional[float], told: Callable[[], bool]) -> Any:
        """Waits for the oldest value not taken yet; None if none arrived in time, or something
        changed.
        """
        return None if self.ended else self._get(lambda: self._new.get(timeout=left))

    def wake(self) -> None:
        """Lets `wait` return to check what changed."""
        self._new.put(_WAKE)

    def close(self) -> None:
        """Closes the stream."""
        self._stream.close()

    def _get(self, get: Callable[[], Any]) -> Any:
        try:
            value = get()
        except queue.Empty:
            return None
        self.ended = self.ended or value is None
        return None if value is _WAKE else value

    def _follow(self) -> None:
        cdr = self._cdr
        value: Any
        try:
            for value in self._stream:
                if cdr is not None:
                    value = cdr.decode(base64.b64decode(value))
                # JSON has no NaN.
                self._new.put(math.nan if value is None else value)
        except GenoMError:
            pass  # The daemon does not answer: the reader's next request will raise.
        finally:
            self._new.put(None)
