"""A request: a running activity, or the outcome of a service."""

from __future__ import annotations

import asyncio
import enum
import threading
import time
from typing import Any, Callable, Dict, Generator, Optional

from ._daemon import Part
from ._http import url
from .errors import GenoMError, exception

# Maximum duration of one waiting request, in seconds; a longer wait takes several.
_PATIENCE = 30.0


class Status(str, enum.Enum):
    """Progress of a request. It equals its text: ``a.status == 'done'``."""

    SENT = "sent"
    DONE = "done"
    ERROR = "error"
    # Also as other clients spell them.
    sent = "sent"
    done = "done"
    error = "error"

    def __str__(self) -> str:
        return self.value


class Activity:
    """A request to a service. Several threads may wait for it."""

    def __init__(self, component: Part, service: str, zero: bool = False) -> None:
        self.component = component
        self.service = service
        # Whether inputs left out take their defaults or zero, also those of an attribute.
        self._zero = zero
        self._lock = threading.Lock()
        self._answered = threading.Event()
        self._number: Optional[int] = None
        self._ended = False
        self._result: Optional[Dict[str, Any]] = None
        self._exception: Optional[GenoMError] = None
        # The error if the request was not accepted.
        self._refused: Optional[GenoMError] = None

    @property
    def number(self) -> Optional[int]:
        """The activity's number in the component; None until accepted, and for other services."""
        return self._number

    @property
    def status(self) -> Status:
        """``sent``, ``done`` or ``error``; asks the daemon while the activity runs."""
        self._look(0.0)
        if not self._ended:
            return Status.SENT
        return Status.ERROR if self._exception is not None else Status.DONE

    @property
    def result(self) -> Optional[Dict[str, Any]]:
        """The outputs once it is done; None before, and after an exception."""
        self._look(0.0)
        return self._result

    @property
    def exception(self) -> Optional[GenoMError]:
        """The exception that it ended with, if any."""
        self._look(0.0)
        return self._exception

    def wait(self, timeout: Optional[float] = None) -> Dict[str, Any]:
        """Waits for the end: returns the outputs, or raises the exception.

        Raises TimeoutError if it has not ended after ``timeout`` seconds; the activity goes on
        then.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while not self._ended:
            left = _PATIENCE if end is None else min(_PATIENCE, end - time.monotonic())
            self._look(max(left, 0.0))
            if not self._ended and end is not None and time.monotonic() >= end:
                raise TimeoutError(f"{self} still runs after {timeout} s")
        if self._exception is not None:
            raise self._exception
        return self._result if self._result is not None else {}

    def __await__(self) -> Generator[Any, None, Dict[str, Any]]:
        """``await a``: its outputs, or its exception; other tasks of asyncio go on meanwhile.

        If the waiting task is cancelled, the activity goes on.
        """
        return self._waited().__await__()

    async def _waited(self) -> Dict[str, Any]:
        loop = asyncio.get_running_loop()
        ended: "asyncio.Future[None]" = loop.create_future()

        def over() -> None:
            if not ended.done():
                ended.set_result(None)

        def tell(_: "Activity") -> None:
            try:
                loop.call_soon_threadsafe(over)
            except RuntimeError:
                pass  # The loop has ended: nobody waits any more.

        self._call_back(tell)
        await ended
        return self.wait()

    def abort(self) -> None:
        """Asks it to stop: its stop codels run, and `wait` returns when it has ended."""
        self._answered.wait()
        if self._number is None or self._ended:
            return
        try:
            self._request("DELETE", "")
        except GenoMError as error:
            if error.name != "ended":
                raise

    def __repr__(self) -> str:
        number = "" if self._number is None else f" {self._number}"
        state = "sent" if not self._ended else "error" if self._exception else "done"
        return f"<{self.component._name}/{self.service}{number}: {state}>"

    def _request(self, method: str, query: str) -> Any:
        path = url("components", self.component._name, "activities", str(self._number))
        return self.component._client._transport.request(method, path + query)

    def _look(self, wait: float) -> None:
        if self._ended:
            return
        if not self._answered.is_set():
            self._answered.wait(wait)
        elif self._number is not None:
            self._take(self._request("GET", f"?wait={wait:.6f}" if wait > 0.0 else ""))

    def _take(self, reply: Dict[str, Any]) -> None:
        """Stores the daemon's reply."""
        with self._lock:
            if self._ended:
                return
            if isinstance(reply.get("activity"), int):
                self._number = reply["activity"]
            if "exception" in reply:
                self._exception = exception(reply["exception"], reply.get("detail"))
                self._ended = True
            elif "result" in reply:
                self._result = reply["result"]
                self._ended = True
        self._answered.set()

    def _fail(self, error: GenoMError, refused: bool = False) -> None:
        with self._lock:
            if refused:
                self._refused = error
            if not self._ended:
                self._exception, self._ended = error, True
        self._answered.set()

    def _send(self, inputs: Dict[str, Any]) -> None:
        """Sends the request and waits until it is accepted; a refusal ends it as well."""
        path = url("components", self.component._name, "services", self.service)
        path += "?zero=true" if self._zero else ""
        self._take(self.component._client._transport.request("POST", path, inputs))

    def _call_back(self, callback: Callable[["Activity"], None]) -> None:
        def work() -> None:
            try:
                self.wait()
            except GenoMError as error:
                # Its own exception, or the daemon is gone: stored in the activity.
                self._fail(error)
            callback(self)

        threading.Thread(target=work, name="genom-callback", daemon=True).start()
