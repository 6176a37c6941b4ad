"""Memory in which a program and its daemon have a request and its answer, without messages.

`daemon/lockstep/src/slate.rs` of genomd documents it.
"""

from __future__ import annotations

import mmap
import os
import platform
import sys
from time import perf_counter
from typing import Any, Dict, Optional

# Options of a map with which its file need not stay open: before Python 3.13 it does.
FORGET: Dict[str, Any] = {"trackfd": False} if sys.version_info >= (3, 13) else {}

_SIZE = 192
# Places of numbers of 32 bits, and of 64.
_ASKED, _VERB, _ANSWERED, _STATUS, _LOOKS = 0, 1, 16, 17, 32
_ARGUMENT, _FIRST = 1, 9
_STEP = 1
# How often the answer is looked for before others may have the processor: for some 1 us.
_GLANCES = range(16)
_yield = getattr(os, "sched_yield", lambda: None)


class Slate:
    """The program's end: it asks, one thread at a time."""

    def __init__(self, file: int) -> None:
        """Maps ``file``, and closes it."""
        try:
            self._memory = mmap.mmap(file, _SIZE, **FORGET)
        finally:
            os.close(file)
        self._words = memoryview(self._memory).cast("I")
        self._longs = memoryview(self._memory).cast("Q")

    def close(self) -> None:
        """Nobody uses it any more."""
        self._words.release()
        self._longs.release()
        self._memory.close()

    @staticmethod
    def serves() -> bool:
        """Whether a thread sees what another one wrote in the order in which it was written, with
        nothing done for that, which Python cannot: so it is on x86.
        """
        return platform.machine().lower() in ("x86_64", "amd64")

    def is_looked_at(self) -> bool:
        """Whether the daemon seems to look for requests here."""
        return self._words[_LOOKS] == 1

    def step(self, number: int, nanoseconds: int, until: float) -> Optional[int]:
        """Asks for a step; returns the time of the clock in nanoseconds. None if there is more to
        tell, or no answer before ``until``.
        """
        words, longs = self._words, self._longs
        words[_VERB] = _STEP
        longs[_ARGUMENT] = nanoseconds
        # Last: from now on it is there.
        words[_ASKED] = number
        while perf_counter() < until:
            for _ in _GLANCES:
                if words[_ANSWERED] == number:
                    return int(longs[_FIRST]) if words[_STATUS] == 0 else None
            _yield()
        return None
