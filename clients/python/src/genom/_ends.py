"""The ends of a port: who publishes there, who follows it; here through the daemon."""

from __future__ import annotations

import math
import os
import queue
import threading
import time
from typing import Any, Iterator, Optional

from ._place import Place
from .errors import GenoMError
from .events import EventStream

# Nobody is told when a sample lies in shared memory: it is looked for all the time at first, then
# so often.
_EAGER = 0.002
_LOOK = 0.0002


class _Values(EventStream):
    """Values of a port as the daemon sends them."""

    _kind = "value"
    _resumes = False


class Publisher:
    """The writing end of an in port: ``p(0.5)`` or ``p(position=1.0)`` publishes."""

    fast = False
    """Whether values go straight through shared memory or over zenoh."""

    def __init__(self, port: Place, element: Optional[str]) -> None:
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

    def __init__(self, port: Place, element: Optional[str], rate: float) -> None:
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
