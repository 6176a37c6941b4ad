"""The socket between a program and the daemon that it started: requests, one after the other.

`daemon/embedding/src/wire.rs` of genomd documents the messages.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import struct
import threading
from time import perf_counter
from typing import Callable, List, NoReturn, Optional, Tuple

from ._slate import Slate
from .errors import GenoMError, RefusalError, refusal

_HELLO, _STEP, _OPEN, _CLOSE = range(4)
_SLATE, _TELL = 6, 7
_HEAD = struct.Struct("=II")
_STEPPED = struct.Struct("=IIQ")
_TELLING = struct.Struct("=III")
_OPENED = struct.Struct("=IIQ")
_TIME = struct.Struct("=Q")
# No reply is longer.
_ROOM = 65536
_PROCESSORS = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
# Seconds that a reply to a step is looked for: not at all on one processor, which the daemon needs
# meanwhile.
_AWAKE = 50e-6 if _PROCESSORS > 1 else 0.0


class Door:
    """The program's end. May be used from any thread."""

    def __init__(self, end: socket.socket, lost: Callable[[], NoReturn]) -> None:
        self._socket, self._lost = end, lost
        self._lock = threading.Lock()
        self._number = 0
        self._room = bytearray(_ROOM)
        self._looks = False
        self._slate: Optional[Slate] = None
        # The step on the slate that was not heard of yet.
        self._pending: Optional[int] = None

    def hello(self) -> str:
        """Waits until the daemon is ready; returns its version."""
        version = self._ask(_HELLO, b"")[_TIME.size :].decode()
        if _AWAKE and Slate.serves():
            with self._lock, contextlib.suppress(RefusalError):
                _, files = self._exchange(_SLATE, b"")
                self._slate = Slate(files[0]) if files else None
        return version

    def step(self, nanoseconds: int) -> int:
        """Advances the clock; returns its time in nanoseconds."""
        with self._lock:
            slate = self._slate
            if slate is None or not self._looks or not slate.is_looked_at():
                return self._told(_STEPPED.pack(self._next(), _STEP, nanoseconds))
            if self._pending is not None:
                # It was interrupted, such as by Ctrl-C. What it returned nobody wants to know.
                with contextlib.suppress(RefusalError):
                    self._tell(self._pending)
            begin = perf_counter()
            number = self._pending = self._next()
            now = slate.step(number, nanoseconds, begin + _AWAKE)
            if now is None:
                now = self._tell(number)
                # What takes this long is better slept for, also the next time.
                self._looks = perf_counter() - begin < _AWAKE
            self._pending = None
            return now

    def _next(self) -> int:
        number = self._number = (self._number + 1) & 0xFFFFFFFF
        return number

    def _tell(self, number: int) -> int:
        """What a step on the slate returns."""
        return self._told(_TELLING.pack(self._next(), _TELL, number))

    def _told(self, request: bytes) -> int:
        """Asks by message for what a step returns."""
        number, room = self._number, self._room
        try:
            self._socket.send(request)
            # The daemon does what is on the slate before it answers a message.
            self._pending = None
            size = self._receive()
            while size and _HEAD.unpack_from(room)[0] != number:
                # Of a request that was interrupted.
                size = self._receive()
        except OSError:
            size = 0
        if size >= _STEPPED.size:
            _, status, now = _STEPPED.unpack_from(room)
            if status == 0:
                return int(now)
        reply = bytes(room[:size])
        if not reply:
            self._lost()
        self._refused(reply[_HEAD.size :])

    def _receive(self) -> int:
        """Waits for the reply to a step. It is looked for before this thread sleeps, where the last
        one came as soon: to be woken would take it longer than most steps.
        """
        begin = perf_counter()
        while self._looks and perf_counter() - begin < _AWAKE:
            try:
                return self._socket.recv_into(self._room, 0, socket.MSG_DONTWAIT)
            except BlockingIOError:
                pass
        size = self._socket.recv_into(self._room)
        self._looks = perf_counter() - begin < _AWAKE
        return size

    def open(self, address: str) -> Tuple[int, bool, int, str, int]:
        """Opens a port: its number, whether it is an in port, size and digest of its type, and the
        file of its memory, which is the caller's.
        """
        with self._lock:
            reply, files = self._exchange(_OPEN, address.encode())
        if not files:
            raise GenoMError("no_file", None, f"{address} is not shared: this program has no file free")
        number, is_in, size = _OPENED.unpack_from(reply)
        return number, is_in == 1, size, reply[_OPENED.size :].decode(), files[0]

    def close_port(self, number: int) -> None:
        """Forgets a port."""
        self._ask(_CLOSE, struct.pack("=I", number))

    def close(self) -> None:
        """Closes the program's end: the daemon stops."""
        self._socket.close()
        with self._lock:
            slate, self._slate = self._slate, None
        if slate is not None:
            slate.close()

    def _ask(self, verb: int, body: bytes) -> bytes:
        with self._lock:
            return self._exchange(verb, body)[0]

    def _exchange(self, verb: int, body: bytes) -> Tuple[bytes, List[int]]:
        number = self._next()
        try:
            self._socket.send(_HEAD.pack(number, verb) + body)
            while True:
                reply, files = _received(self._socket)
                if not reply:
                    break
                answered, status = _HEAD.unpack_from(reply)
                if answered == number:
                    break
                for file in files:
                    os.close(file)
        except OSError:
            reply, files = b"", []
        if not reply:
            self._lost()
        if status != 0:
            self._refused(reply[_HEAD.size :])
        return reply[_HEAD.size :], files

    @staticmethod
    def _refused(text: bytes) -> NoReturn:
        raise refusal(json.loads(text), 409)


def _received(end: socket.socket) -> Tuple[bytes, List[int]]:
    """A message, and the files that came with it."""
    item = struct.calcsize("i")
    flags = getattr(socket, "MSG_CMSG_CLOEXEC", 0)
    reply, ancillary, _, _ = end.recvmsg(_ROOM, socket.CMSG_SPACE(item), flags)
    files: List[int] = []
    for level, kind, data in ancillary:
        if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
            files += struct.unpack(f"{len(data) // item}i", data[: len(data) // item * item])
    return reply, files
