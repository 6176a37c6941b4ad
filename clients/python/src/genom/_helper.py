"""A thread for jobs that must not run where they arise: delayed ones, or in zenoh's threads."""

from __future__ import annotations

import itertools
import math
import queue
import threading
import time
from contextlib import contextmanager
from typing import Any, Callable, Dict, Iterator, Optional, Tuple

Job = Callable[[], Any]


class Helper:
    """Runs jobs one after the other, soon or after a delay."""

    def __init__(self) -> None:
        self._soon: "queue.SimpleQueue[Job]" = queue.SimpleQueue()
        self._later: Dict[int, Tuple[float, Job]] = {}
        self._numbers = itertools.count()
        # When the thread wakes up by itself; a later job need not wake it.
        self._looks = math.inf
        self._lock = threading.Lock()
        self._started = False

    def soon(self, job: Job) -> None:
        """Runs a job soon."""
        self._soon.put(job)
        if not self._started:
            with self._lock:
                if not self._started:
                    self._started = True
                    threading.Thread(target=self._run, name="genom-helper", daemon=True).start()

    @contextmanager
    def after(self, seconds: Optional[float], job: Job) -> Iterator[None]:
        """Runs a job if the body of the `with` statement takes longer than the delay."""
        if seconds is None:
            yield
            return
        number, due = next(self._numbers), time.monotonic() + seconds
        with self._lock:
            self._later[number] = (due, job)
            sooner = due < self._looks
        if sooner:
            self.soon(lambda: None)
        try:
            yield
        finally:
            with self._lock:
                self._later.pop(number, None)

    def _run(self) -> None:
        while True:
            now = time.monotonic()
            with self._lock:
                due = [one for one, (at, _) in self._later.items() if at <= now]
                jobs = [self._later.pop(one)[1] for one in due]
                self._looks = min((at for at, _ in self._later.values()), default=math.inf)
                left = None if self._looks == math.inf else max(self._looks - now, 0.0)
            for job in jobs:
                job()
            try:
                self._soon.get(timeout=left)()
            except queue.Empty:
                pass


helper = Helper()
