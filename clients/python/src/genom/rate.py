"""Steps at a steady rate, for simulators and control loops."""

from __future__ import annotations

import os
import time
from typing import Iterator

# A thread that sleeps is woken up so much later than it asked for: the rest is waited for awake.
_SLACK = 0.0002


class Rate:
    """A loop's clock: ``for step in genom.Rate(1000): ...`` runs it a thousand times a second.

    A step that takes longer than its period is late, and counted; the next one begins at once.
    One that is late by more than a period delays all that follow, rather than have them hurry.
    """

    def __init__(self, hertz: float) -> None:
        self._period = 1.0 / hertz
        self._next = time.perf_counter() + self._period
        self.steps = 0
        """Steps done so far."""
        self.late = 0
        """How many of them took longer than their period."""

    def sleep(self) -> bool:
        """Waits for the end of this step's period; False when that is past."""
        left = self._next - time.perf_counter()
        if left > _SLACK:
            time.sleep(left - _SLACK)
        in_time = left > 0.0
        while time.perf_counter() < self._next:
            os.sched_yield()
        self.steps += 1
        self.late += not in_time
        self._next = max(self._next, time.perf_counter() - self._period) + self._period
        return in_time

    def __iter__(self) -> Iterator[int]:
        while True:
            yield self.steps
            self.sleep()
