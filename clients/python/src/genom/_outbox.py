"""Sends requests to a component in the background, in the order of the calls."""

from __future__ import annotations

import queue
import threading
from typing import Any, Dict, Tuple

from .activity import Activity
from .errors import GenoMError

# Seconds after which a thread with nothing to send ends.
_IDLE = 10.0


class Outbox:
    """Sends one request after the other, each when the previous one was answered."""

    def __init__(self) -> None:
        self._waiting: "queue.Queue[Tuple[Activity, Dict[str, Any]]]" = queue.Queue()
        self._lock = threading.Lock()
        # Number of requests not answered yet; the thread ends when it is 0.
        self._count = 0
        self._works = False

    def put(self, activity: Activity, inputs: Dict[str, Any]) -> None:
        """Sends a request after the previous ones, without waiting."""
        with self._lock:
            self._count += 1
            self._waiting.put((activity, inputs))
            if not self._works:
                self._works = True
                threading.Thread(target=self._work, name="genom-send", daemon=True).start()

    def send(self, activity: Activity, inputs: Dict[str, Any]) -> None:
        """Sends a request after the previous ones, and waits until it is accepted."""
        with self._lock:
            empty = self._count == 0
        if empty:
            activity._send(inputs)
            return
        self.put(activity, inputs)
        activity._answered.wait()
        refused = activity._refused
        if refused is not None:
            raise refused

    def _work(self) -> None:
        while True:
            try:
                activity, inputs = self._waiting.get(timeout=_IDLE)
            except queue.Empty:
                with self._lock:
                    if self._waiting.empty():
                        self._works = False
                        return
                continue
            try:
                activity._send(inputs)
            except Exception as error:
                wrong = error if isinstance(error, GenoMError) else GenoMError(
                    "bad_input", None, str(error)
                )
                activity._fail(wrong, refused=True)
            with self._lock:
                self._count -= 1
