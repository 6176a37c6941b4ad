"""The socket between a program and the daemon that it started: requests, one after the other.

`daemon/embedding/src/wire.rs` of genomd documents the messages.
"""

from __future__ import annotations

import json
import os
import socket
import struct
import threading
from time import perf_counter
from typing import Callable, List, NoReturn, Tuple

from .errors import GenoMError, refusal

_HELLO, _STEP, _OPEN, _CLOSE = range(4)
_HEAD = struct.Struct("=II")
_STEPPED = struct.Struct("=IIQ")
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

    def hello(self) -> str:
        """Waits until the daemon is ready; returns its version."""
        return self._ask(_HELLO, b"")[_TIME.size :].decode()

    def step(self, nanoseconds: int) -> int:
        """Advances the clock; returns its time in nanoseconds."""
        with self._lock:
            number = self._number = (self._number + 1) & 0xFFFFFFFF
            room = self._room
            try:
                self._socket.send(_STEPPED.pack(number, _STEP, nanoseconds))
                size = self._receive()
                while size and _HEAD.unpack_from(room)[0] != number:
                    # Of a request that was interrupted, such as by Ctrl-C.
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
        raise refusal(json.loads(reply[_HEAD.size :]), 409)

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

    def _ask(self, verb: int, body: bytes) -> bytes:
        with self._lock:
            return self._exchange(verb, body)[0]

    def _exchange(self, verb: int, body: bytes) -> Tuple[bytes, List[int]]:
        number = self._number = (self._number + 1) & 0xFFFFFFFF
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
