"""Ports over zenoh with the package eclipse-zenoh, without the daemon.

Samples are put into a ring of zenoh's own: a callback in Python would take tens of microseconds per
sample.
"""

from __future__ import annotations

import itertools
import math
import queue
import secrets
import struct
import time
from typing import Any, Callable, Optional, Tuple

import zenoh

from ._cdr import Cdr
from ._helper import helper
from ._meeting import MATCHING, session
from ._place import Place
from .errors import GenoMError, InputError, RefusalError

# Attachment of samples that only wake up a reader, and room in rings for these.
_WAKE = b"genom: wake up"
_WAKES = 2
_tokens = itertools.count(1)
# Identifier of the writer and number of the sample.
_MARK = struct.Struct("<QQ")
# Queries go to every writer, and each one's answer counts.
_ALL = {
    "target": zenoh.QueryTarget.ALL,
    "consolidation": zenoh.ConsolidationMode.NONE,
    "timeout": MATCHING,
}


def _direct(callback: Any) -> Any:
    """Runs a callback in zenoh's own thread: a Python thread would delay the exit of the program.
    """
    return zenoh.handlers.Callback(callback, indirect=False)


class _End:
    """What both ends of a port have."""

    def __init__(self, port: Place, address: str, buffers: bool = False) -> None:
        self.layout = port.layout()
        self.cdr = Cdr(self.layout, buffers)
        meet = port._client._meeting_point("zenoh")
        self.session = session(meet)
        self._client = port._client
        self.prefix = meet.get("prefix", "")
        self.address = address
        self.key = self.prefix + address
        self.digest = self.layout["digest"]
        name = str(self.layout["type"])
        name = name[2:] if name.startswith("::") else name
        self.encoding = f"application/cdr;{name};digest={self.digest}"

    def declare(self, kind: str) -> Any:
        """Declares a liveliness token by which others see this end."""
        top = self.layout["types"][0]
        size = f"{top['size']} bytes" if top["fixed"] else "variable size"
        types = _escape(f"{self.layout['type']} ({size}, digest {self.digest})")
        number = f"{self.session.info.zid()}/{next(_tokens)}"
        token = f"{self.prefix}@genom/{kind}/{number}/{self.digest}/{types}/{self.address}"
        return self.session.liveliness().declare_token(token)

    def is_written(self) -> bool:
        """Whether a publisher is visible there, to the daemon or to this session."""
        for one in self._client._visible("zenoh"):
            if one["kind"] == "publisher" and one["address"] == self.address:
                return True
        found = self.session.liveliness().get(f"{self.prefix}@genom/pub/**", timeout=MATCHING)
        keys = [str(reply.ok.key_expr) for reply in found if reply.ok is not None]
        return any(key.split("/", 6)[-1] == self.address for key in keys)

    def match(self, end: Any) -> bool:
        """Waits until an end has a matching one, within a limit."""
        begin = time.monotonic()
        while not end.matching_status.matching:
            if time.monotonic() - begin > MATCHING:
                return False
            time.sleep(0.001)
        return True


class Writer:
    """Writer at an in port, over zenoh."""

    def __init__(self, port: Place, address: str) -> None:
        self._end = end = _End(port, address)
        if end.is_written():
            raise RefusalError(
                "taken",
                f"{end.address} takes no publisher: somebody publishes there",
                help="another program publishes there: stop it first",
            )
        self._token = end.declare("pub")
        self._value = end.cdr.zero()
        self._message: Optional[Tuple[bytes, bytes]] = None
        self._writer = secrets.randbits(64) | 1
        self._number = 0
        self._queryable = end.session.declare_queryable(end.key, _direct(self._answer))
        # On a full link zenoh would drop samples without notice to readers: publishing blocks
        # instead.
        block = zenoh.CongestionControl.BLOCK
        self._publisher: Any = end.session.declare_publisher(
            end.key, encoding=end.encoding, congestion_control=block
        )
        # The first sample must arrive, too.
        if not end.match(self._publisher):
            self.close()
            raise RefusalError("not_fast", f"{end.address} is not read over zenoh")

    def publish(self, value: Any) -> None:
        """Publishes a value, without a request to the daemon."""
        try:
            merged = self._end.cdr.merge(self._value, value)
            message = self._end.cdr.encode(merged)
        except (TypeError, ValueError, AttributeError, KeyError, struct.error) as why:
            raise InputError("bad_input", f"{self._end.address}: {why}") from why
        if self._publisher is None:
            raise GenoMError("ended", None, f"{self._end.address} is not fed any more")
        self._number += 1
        mark = _MARK.pack(self._writer, self._number)
        # Stored for late readers first, then sent to present ones, so that nobody misses it.
        self._value, self._message = merged, (message, mark)
        self._publisher.put(message, attachment=mark)

    def last(self) -> Any:
        """The value published last; None if there was none."""
        return None if self._message is None else self._value

    def repeat(self) -> None:
        """Nothing to do: late readers query the last value."""

    def close(self) -> None:
        """Closes the writer and frees the address."""
        if self._publisher is not None:
            for one in (self._publisher, self._queryable, self._token):
                one.undeclare()
            self._publisher = None

    def _answer(self, query: Any) -> None:
        # Late readers query the last value.
        if self._message is not None:
            message, mark = self._message
            query.reply(self._end.key, message, encoding=self._end.encoding, attachment=mark)


class Reader:
    """Reader of a port, over zenoh.

    Samples wait in a ring of zenoh's, which its threads fill without Python's lock.
    """

    ended = False

    def __init__(self, port: Place, address: str, depth: int, buffers: bool) -> None:
        self._end = end = _End(port, address, buffers)
        self._encoding = zenoh.Encoding(end.encoding)
        # Answers of writers that were queried for the last value.
        self._answers: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        # Mark of the sample taken last, and of the one before the last query.
        self._known: Optional[Tuple[int, int]] = None
        self._before: Optional[Tuple[int, int]] = None
        session = end.session
        ring: Any = zenoh.handlers.RingChannel(depth + _WAKES)
        self._subscriber = session.declare_subscriber(end.key, ring)
        self._ring: Any = self._subscriber.handler
        token = f"{end.prefix}@genom/pub/*/*/*/*/{end.address}"
        heard = _direct(lambda sample: helper.soon(lambda: self._ask(sample.kind)))
        self._watch = session.liveliness().declare_subscriber(token, heard, history=True)
        # So that existing values can be read at once.
        asked = session.declare_querier(end.key, **_ALL)
        if not end.is_written() or end.match(asked):
            for reply in asked.get():
                self._answers.put(reply)
        asked.undeclare()
        # Makes this reader visible to others.
        self._token = end.declare("sub")

    def take(self) -> Any:
        """The oldest value not taken yet; None if there is none."""
        while True:
            sample, asked = self._next(False), False
            if sample is None:
                try:
                    sample, asked = self._answers.get_nowait().ok, True
                except queue.Empty:
                    return None
            value = self._news(sample, asked)
            if value is not None:
                return value

    def wait(self, left: Optional[float], told: Callable[[], bool]) -> Any:
        """Waits for the oldest value not taken yet; None if none arrived in time, or something
        changed.
        """
        end = math.inf if left is None else time.monotonic() + left
        # Waiting in zenoh has no timeout: a sample without a value ends it.
        with helper.after(left, self.wake):
            while not told() and time.monotonic() < end:
                value = self._news(self._next(True), False)
                if value is None:
                    value = self.take()
                if value is not None:
                    return value
        return None

    def close(self) -> None:
        """Closes the reader."""
        if self._ring is not None:
            self._ring = None
            for one in (self._subscriber, self._watch, self._token):
                one.undeclare()

    def _next(self, wait: bool) -> Any:
        ring = self._ring
        try:
            if ring is not None:
                return ring.recv() if wait else ring.try_recv()
        except zenoh.ZError:
            # Closed meanwhile, or the session was.
            self._ring = None
        raise GenoMError("ended", None, f"{self._end.address} is not followed any more")

    def wake(self) -> None:
        """Puts a sample without a value into the rings of this process."""
        here = zenoh.Locality.SESSION_LOCAL
        try:
            self._end.session.put(self._end.key, b"", attachment=_WAKE, allowed_destination=here)
        except zenoh.ZError:
            pass  # It was closed, which wakes the reader as well.

    def _ask(self, kind: Any) -> None:
        """A writer appeared: queries the value that it wrote before."""
        if kind != zenoh.SampleKind.PUT or self._ring is None:
            return
        self._before = self._known
        try:
            for reply in self._end.session.get(self._end.key, **_ALL):
                self._answers.put(reply)
        except zenoh.ZError:
            return  # It was closed.
        self.wake()

    def _news(self, sample: Any, asked: bool) -> Any:
        """The value of a sample; None if it is not new, or has no value."""
        if sample is None or not self._is_news(sample, asked):
            return None
        return self._decoded(sample)

    def _is_news(self, sample: Any, asked: bool) -> bool:
        """Whether a sample is neither a repetition nor older than one received."""
        mark, known = _mark(sample), self._known
        if mark is None:
            return False
        if known is not None and mark[0] == known[0] and mark[0]:
            news = mark[1] > known[1]
        else:
            # Written by another writer than the last sample: an answer must not replace a newer
            # value.
            news = not asked or known is None or (mark[0] != 0 and known == self._before)
        if news:
            self._known = mark
        return news

    def _decoded(self, sample: Any) -> Any:
        """The value of a sample; None if it is not of this port's type."""
        if sample.encoding != self._encoding:
            told = str(sample.encoding).rsplit("digest=", 1)
            if len(told) == 2 and told[1] != self._end.digest:
                return None
        try:
            return self._end.cdr.decode(sample.payload.to_bytes())
        except (ValueError, IndexError, struct.error):
            return None


def _mark(sample: Any) -> Optional[Tuple[int, int]]:
    """Mark of a sample: zeros if its writer sends none, None for a wake-up."""
    told = sample.attachment
    mark = b"" if told is None else told.to_bytes()
    if len(mark) == 16:
        return _MARK.unpack(mark)
    return None if mark == _WAKE else (0, 0)


def _escape(text: str) -> str:
    """Percent-encodes characters with a meaning in keys."""
    plain = b"_-.:<>,()"
    return "".join(
        chr(byte) if chr(byte).isalnum() and byte < 128 or byte in plain else f"%{byte:02x}"
        for byte in text.encode()
    )
