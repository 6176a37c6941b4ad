"""What codels may do and seldom mean: told once for each place, with its line."""

from __future__ import annotations

import io
import os
import sys
import threading
import time
import traceback
from typing import Callable, Set, Tuple

# Characters printed in a second that are told.
MOST_PRINTED = 1 << 20


def lines_of(depth: int) -> str:
    """The lines of codels that lead to a caller, ``depth`` frames above the one that asks."""
    frames = traceback.extract_stack(sys._getframe(depth + 1))
    own = [one for one in frames if not one.filename.startswith("<codel ")]
    return "".join(traceback.format_list(own)).rstrip()


class Places:
    """Places in scripts of which something was told."""

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        self._told: Set[Tuple[str, int, str]] = set()

    def tell(self, what: str, depth: int) -> None:
        """Logs something of the line ``depth`` frames above, unless it was logged already."""
        frame = sys._getframe(depth + 1)
        place = frame.f_code.co_filename, frame.f_lineno, what
        if place not in self._told:
            self._told.add(place)
            self._log(f"{what}:\n{lines_of(depth + 1)}")


class Output(io.TextIOWrapper):
    """Standard output that tells of a codel that prints without end."""

    def __init__(self, plain: io.TextIOWrapper, places: Places) -> None:
        super().__init__(
            plain.buffer, plain.encoding, plain.errors, line_buffering=plain.line_buffering
        )
        self._places = places
        self._alone = threading.Lock()
        self._since, self._printed = time.monotonic(), 0

    def write(self, text: str) -> int:
        """Writes, and counts."""
        with self._alone:
            now = time.monotonic()
            if now - self._since > 1.0:
                self._since, self._printed = now, 0
            self._printed += len(text)
            much = self._printed > MOST_PRINTED
        if much:
            self._places.tell("more than 1 MiB is printed in a second", 1)
        return super().write(text)


def watch(log: Callable[[str], None]) -> None:
    """Begins to tell of what codels print, and of processes that they fork."""
    places, process = Places(log), os.getpid()

    def forks() -> None:
        if os.getpid() == process:
            what = "os.fork: the child ends where it would return from the codel"
            places.tell(what, 1)

    os.register_at_fork(before=forks)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout = Output(sys.stdout, places)
