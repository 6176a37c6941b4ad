"""Monitors changes in a daemon for the ends of ports that are open in this process."""

from __future__ import annotations

import threading
import weakref
from typing import Any, Dict, Optional, Protocol

from ._http import Transport
from .errors import GenoMError
from .events import EventStream

_ONLY = (
    "component_loaded,component_unloaded,component_left,backend_changed,connected,disconnected"
)
# Seconds between checks by the ends themselves while there is no stream.
_AGAIN = 1.0
_MOMENT = 0.05


class _Changes(EventStream):
    _resumes = False


class Ear(Protocol):
    """An object that is notified of changes."""

    def _hear(self, change: Optional[Dict[str, Any]]) -> None: ...

    def _doubt(self) -> None: ...


class Watch:
    """One stream of changes for all ends of a client, open while there are any."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._ears: "weakref.WeakSet[Ear]" = weakref.WeakSet()
        self._lock = threading.Lock()
        self._stream: Optional[_Changes] = None
        self._thread: Optional[threading.Thread] = None
        self._end = threading.Event()

    def add(self, ear: Ear) -> None:
        """Notifies the object of all changes from now on."""
        with self._lock:
            self._ears.add(ear)
            if self._thread is None:
                self._end = threading.Event()
                self._stream = self._open()
                run = (self._end, self._stream)
                self._thread = threading.Thread(
                    target=self._run, args=run, name="genom-watch", daemon=True
                )
                self._thread.start()

    def remove(self, ear: Ear) -> None:
        """Stops notifying the object."""
        with self._lock:
            self._ears.discard(ear)
            if not self._ears:
                self._stop()

    def close(self) -> None:
        """Closes the stream. Ends that are used afterwards check by themselves, and open a stream
        again.
        """
        with self._lock:
            self._stop()
            ears = list(self._ears)
        for ear in ears:
            ear._doubt()

    def _stop(self) -> None:
        self._thread = None
        self._end.set()
        if self._stream is not None:
            self._stream.close()

    def _open(self) -> Optional[_Changes]:
        try:
            return _Changes(self._transport, f"/events?only={_ONLY}")
        except GenoMError:
            return None  # No stream is free, or there is no daemon: the next request reports it.

    def _run(self, end: threading.Event, stream: Optional[_Changes]) -> None:
        while True:
            try:
                for change in stream or ():
                    self._tell(None if change["event"] in ("missed", "stopping") else change)
            except GenoMError:
                pass  # The daemon does not answer: the next request of an end raises.
            # Wait a moment, in case streams end as soon as they begin.
            if end.wait(_MOMENT):
                return
            stream = self._open()
            with self._lock:
                if end.is_set():
                    if stream is not None:
                        stream.close()
                    return
                self._stream = stream
            # Anything may have changed in between.
            self._tell(None)
            if stream is None:
                end.wait(_AGAIN)

    def _tell(self, change: Optional[Dict[str, Any]]) -> None:
        with self._lock:
            ears = list(self._ears)
        for ear in ears:
            ear._hear(change)
