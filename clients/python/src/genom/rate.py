"""Loops at a fixed rate, for simulators and control."""

from __future__ import annotations

import os
import time
from typing import Iterator

# Threads wake up at most this much late, in seconds: the rest of a wait is a busy loop.
_SLACK = 0.0002


class Rate:
    """A periodic loop: ``for step in genom.Rate(1000): ...`` runs 1000 times per second.

    A step that takes longer than its period is counted as late, and the next one begins at once. If
    it is late by more than a period, all later steps are shifted rather than run in a burst.
    """

    def __init__(self, hertz: float) -> None:
        self._period = 1.0 / hertz
        self._next = time.perf_counter() + self._period
        self.steps = 0
        """Steps done so far."""
        self.late = 0
        """How many of them took longer than their period."""

    def sleep(self) -> bool:
        """Waits for the end of this period; returns False if that is past already."""
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
