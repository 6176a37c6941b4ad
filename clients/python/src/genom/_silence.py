"""Handles daemons that do not answer: how long to wait, and what to report."""

from __future__ import annotations

import errno
import select
import socket
import struct
import time
from typing import Any, Optional

from .errors import DaemonError

# Seconds after which connecting is tried again if the backlog is full.
_AGAIN = 0.01


def connect(sock: socket.socket, path: str) -> None:
    """Connects to a Unix socket within the socket's timeout, even if its owner accepts slowly."""
    limit = sock.gettimeout()
    end = None if limit is None else time.monotonic() + limit
    while True:
        try:
            return sock.connect(path)
        except BlockingIOError as why:
            # With a timeout set, Linux does not wait for room in the backlog.
            if why.errno != errno.EAGAIN or (end is not None and time.monotonic() >= end):
                raise socket.timeout() from why
            time.sleep(_AGAIN)


def readable(sock: Any, seconds: float) -> bool:
    """Whether something arrives in that time."""
    if getattr(sock, "pending", lambda: 0)() > 0:
        return True  # TLS has read it already.
    poll = select.poll()
    poll.register(sock, select.POLLIN)
    return bool(poll.poll(seconds * 1000.0))


def error(target: str, path: Optional[str], seconds: Optional[float]) -> DaemonError:
    """The error for a daemon that did not answer for that long."""
    process = _owner(path)
    if process is not None and _stopped(process):
        told = (
            f"the daemon does not answer, its process is stopped (on {target}); "
            f"`kill -CONT {process}` has it go on"
        )
    else:
        told = (
            f"the daemon does not answer: nothing came from {target} for {seconds} s; "
            "connect(timeout=...) waits for longer"
        )
    return DaemonError("no_answer", None, told)


def is_stopped(sock: Any) -> bool:
    """Whether the process at the other end of a Unix socket is stopped, as by Ctrl-Z."""
    process = _peer(sock)
    return process is not None and _stopped(process)


def _owner(path: Optional[str]) -> Optional[int]:
    """The process that listens there."""
    if path is None:
        return None
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as sock:
        sock.setblocking(False)
        try:
            sock.connect(path)
        except OSError:
            return None
        return _peer(sock)


def _peer(sock: Any) -> Optional[int]:
    if sock.family != socket.AF_UNIX:
        return None
    try:
        told = sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    except OSError:
        return None
    return struct.unpack("3i", told)[0] or None


def _stopped(process: int) -> bool:
    """Whether a process is stopped, by a signal or a debugger."""
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
            # The name, which precedes the state, may contain blanks and parentheses.
            return file.read().rpartition(")")[2].split()[0] in ("T", "t")
    except (OSError, IndexError):
        return False
