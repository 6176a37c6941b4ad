"""How long a script may take when it is run to define its codels."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import traceback
from typing import Callable, List, Optional


class TooLong(Exception):
    """A script has not run through in time."""

    def __init__(self, seconds: float, frames: List[traceback.FrameSummary]) -> None:
        super().__init__(
            f"the script is here after {seconds:g} s (start_timeout), and has not run through: what "
            "takes longer, or goes on, belongs into a codel"
        )
        self.frames = frames


class _End(SystemExit):
    """Ends the thread of such a script, of which nothing is printed then."""


def run_within(seconds: float, work: Callable[[], None]) -> None:
    """Runs what may take so many seconds, and raises what it raises.

    It has a thread of its own, which is ended if it takes longer: in Python at once, in native code
    when that returns. A child that it forks ends where it would return from here: the other threads
    of genomd are not there.
    """
    process = os.getpid()
    over = threading.Event()
    raised: List[BaseException] = []

    def run() -> None:
        try:
            work()
        except BaseException as error:
            raised.append(error)
        if os.getpid() != process:
            os._exit(0)
        over.set()

    thread = threading.Thread(target=run, name="script", daemon=True)
    thread.start()
    if not over.wait(seconds):
        late = TooLong(seconds, _frames(thread.ident))
        ctypes.pythonapi.PyThreadState_SetAsyncExc(
            ctypes.c_ulong(thread.ident or 0), ctypes.py_object(_End)
        )
        raise late
    thread.join()
    if raised:
        raise raised[0]


def _frames(thread: Optional[int]) -> List[traceback.FrameSummary]:
    """Where a thread is."""
    top = sys._current_frames().get(thread or 0)
    return [] if top is None else list(traceback.extract_stack(top))
