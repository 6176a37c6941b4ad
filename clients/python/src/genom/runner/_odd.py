"""What codels may do and seldom mean: told once for each place, with its line."""

from __future__ import annotations

import io
import os
import sys
import threading
import time
import traceback
from typing import Callable, List, Set, Tuple

# Characters printed in a second that are told.
MOST_PRINTED = 1 << 20
# The module that runs the text of a script.
_RUNS = os.path.join(os.path.dirname(__file__), "_script.py")


def lines_of(depth: int) -> str:
    """The lines of codels that lead to a caller, ``depth`` frames above the one that asks."""
    frames = list(traceback.extract_stack(sys._getframe(depth + 1)))
    # What runs a script is above its own lines.
    ran = [rank for rank, one in enumerate(frames) if one.filename == _RUNS]
    del frames[: ran[-1] + 1 if ran else 0]
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


# A stream that nobody refers to closes what it writes to; scripts may put others in their place.
_outputs: List[io.TextIOWrapper] = []


class Count:
    """Characters that were printed in the present second."""

    def __init__(self) -> None:
        self._alone = threading.Lock()
        self._since, self._printed = time.monotonic(), 0

    def add(self, count: int) -> bool:
        """Counts more of them; whether they are too many."""
        with self._alone:
            now = time.monotonic()
            if now - self._since > 1.0:
                self._since, self._printed = now, 0
            self._printed += count
            return self._printed > MOST_PRINTED


class Output(io.TextIOWrapper):
    """Standard output, or standard error, that tells of a codel that prints without end."""

    def __init__(self, plain: io.TextIOWrapper, count: Count, places: Places) -> None:
        super().__init__(
            plain.buffer, plain.encoding, plain.errors, line_buffering=plain.line_buffering,
            write_through=plain.write_through,
        )
        self._count, self._places = count, places

    def write(self, text: str) -> int:
        """Writes, and counts."""
        if self._count.add(len(text)):
            self._places.tell("more than 1 MiB is printed in a second", 1)
        return super().write(text)


def watch(log: Callable[[str], None]) -> None:
    """Begins to tell of what codels print, and of processes that they fork."""
    places, process = Places(log), os.getpid()

    def forks() -> None:
        if os.getpid() == process:
            what = "os.fork: the child ends where it would return from the codel, or from the script"
            places.tell(what, 1)

    os.register_at_fork(before=forks)
    # One count for both: what is printed to either harms in the same way.
    count = Count()
    for name in ("stdout", "stderr"):
        plain = getattr(sys, name)
        if isinstance(plain, io.TextIOWrapper):
            output = Output(plain, count, places)
            setattr(sys, name, output)
            _outputs.append(output)
