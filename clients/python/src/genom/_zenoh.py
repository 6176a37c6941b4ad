"""Ports straight over zenoh, with the package eclipse-zenoh and without the daemon.

Samples come by callback: who waits for one sleeps until it is there.
"""

from __future__ import annotations

import atexit
import json
import struct
import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Any, Deque, Dict, Optional

import zenoh

from ._cdr import Cdr
from .errors import GenoMError, InputError, RefusalError
from .port import Publisher, Subscription

if TYPE_CHECKING:
    from .port import Port

# A daemon that is there is matched in far less.
_MATCHING = 5.0
_sessions: Dict[str, Any] = {}
_tokens = 0
_lock = threading.Lock()


def _session(meet: Dict[str, str]) -> Any:
    """This process's session with the daemon's; made once."""
    with _lock:
        session = _sessions.get(meet["connect"])
        if session is None or session.is_closed():
            config = zenoh.Config()
            # Whatever the daemon reaches is reached through it.
            config.insert_json5("mode", '"client"')
            config.insert_json5("connect/endpoints", json.dumps(meet["connect"].split(",")))
            session = _sessions[meet["connect"]] = zenoh.open(config)
    return session


def _direct(callback: Any) -> Any:
    """Called by zenoh's own thread: one of Python's would outlive the program's end."""
    return zenoh.handlers.Callback(callback, indirect=False)


@atexit.register
def _close() -> None:
    with _lock:
        for session in _sessions.values():
            session.close()
        _sessions.clear()


class _End:
    """What both ends of a port have."""

    def __init__(self, port: "Port", address: str) -> None:
        self.layout = port.layout()
        self.cdr = Cdr(self.layout)
        meet = port._client._meeting_point("zenoh")
        self.session = _session(meet)
        self.prefix = meet.get("prefix", "")
        self.address = address
        self.key = self.prefix + address
        self.digest = self.layout["digest"]
        name = str(self.layout["type"])
        name = name[2:] if name.startswith("::") else name
        self.encoding = f"application/cdr;{name};digest={self.digest}"

    def declare(self, kind: str) -> Any:
        """A token by which others see this end."""
        global _tokens
        with _lock:
            _tokens += 1
            number = _tokens
        top = self.layout["types"][0]
        size = f"{top['size']} bytes" if top["fixed"] else "variable size"
        types = _escape(f"{self.layout['type']} ({size}, digest {self.digest})")
        session = self.session.info.zid()
        token = f"{self.prefix}@genom/{kind}/{session}/{number}/{self.digest}/{types}/{self.address}"
        return self.session.liveliness().declare_token(token)

    def writers(self) -> int:
        """Who shows to publish there."""
        found = self.session.liveliness().get(f"{self.prefix}@genom/pub/**", timeout=_MATCHING)
        keys = [str(reply.ok.key_expr) for reply in found if reply.ok is not None]
        return sum(key.split("/", 6)[-1] == self.address for key in keys)


class ZenohPublisher(Publisher):
    """The writing end of an in port, straight over zenoh."""

    fast = True

    def __init__(self, port: "Port", element: Optional[str]) -> None:
        super().__init__(port, element)
        self._end = end = _End(port, port.address(element))
        if end.writers():
            raise RefusalError(
                "taken",
                f"{end.address} takes no publisher: somebody publishes there",
                help="another program publishes there: stop it first",
            )
        self._token = end.declare("pub")
        self._value = end.cdr.zero()
        self._message: Optional[bytes] = None
        self._queryable = end.session.declare_queryable(end.key, _direct(self._answer))
        # What goes out first must arrive, too.
        self._publisher: Any = end.session.declare_publisher(end.key, encoding=end.encoding)
        begin = time.monotonic()
        while not self._publisher.matching_status.matching:
            if time.monotonic() - begin > _MATCHING:
                self._let_go()
                raise RefusalError("not_fast", f"{end.address} is not read over zenoh")
            time.sleep(0.001)

    def publish(self, value: Any) -> None:
        """Publishes a value: no call of the daemon."""
        try:
            merged = self._end.cdr.merge(self._value, value)
            message = self._end.cdr.encode(merged)
        except (TypeError, ValueError, AttributeError, KeyError, struct.error) as why:
            raise InputError("bad_input", f"{self._end.address}: {why}") from why
        if self._publisher is None:
            raise GenoMError("ended", None, f"{self._end.address} is not fed any more")
        self._value, self._message = merged, message
        self._publisher.put(message)

    def close(self) -> None:
        """Takes the connection away and lets go of the address."""
        super().close()
        self._let_go()

    def _let_go(self) -> None:
        if self._publisher is not None:
            for one in (self._publisher, self._queryable, self._token):
                one.undeclare()
            self._publisher = None

    def _answer(self, query: Any) -> None:
        # Who comes late asks for the last value.
        if self._message is not None:
            query.reply(self._end.key, self._message, encoding=self._end.encoding)


class ZenohSubscription(Subscription):
    """The reading end of a port, straight over zenoh."""

    fast = True

    def __init__(self, port: "Port", element: Optional[str], depth: int) -> None:
        self.port = port
        self._last = None
        self._end = end = _End(port, str(port._source(element)))
        self._new: Deque[Any] = deque(maxlen=depth)  # type: ignore[assignment]
        self._came = threading.Condition()
        self._any = False
        self._closed = False
        self._subscriber = end.session.declare_subscriber(end.key, _direct(self._take_in))
        # The answer comes when the subscription is known over there.
        for reply in end.session.get(end.key, timeout=_MATCHING):
            if reply.ok is not None:
                with self._came:
                    # What came meanwhile is newer, or the same.
                    if not self._any:
                        self._add(reply.ok.payload.to_bytes())

    def take(self) -> Any:
        """The oldest value not taken yet; None when there is none."""
        with self._came:
            self._check()
            if not self._new:
                return None
            self._last = self._new.popleft()
            return self._last

    def wait(self, timeout: Optional[float] = None) -> Any:
        """The oldest value not taken yet, as soon as there is one; TimeoutError if none comes."""
        with self._came:
            if not self._came.wait_for(lambda: self._new or self._closed, timeout):
                raise TimeoutError(f"no value on {self.port.address()} for {timeout} s")
            self._check()
            self._last = self._new.popleft()
            return self._last

    def close(self) -> None:
        """Stops following."""
        with self._came:
            if self._closed:
                return
            self._closed = True
            self._came.notify_all()
        self._subscriber.undeclare()

    def _check(self) -> None:
        if self._closed:
            raise GenoMError("ended", None, f"{self.port.address()} is not followed any more")

    def _take_in(self, sample: Any) -> None:
        told = str(sample.encoding).rsplit("digest=", 1)
        if len(told) == 2 and told[1] != self._end.digest:
            return
        with self._came:
            self._add(sample.payload.to_bytes())

    def _add(self, message: bytes) -> None:
        try:
            value = self._end.cdr.decode(message)
        except (ValueError, IndexError, struct.error):
            return
        self._any = True
        self._new.append(value)
        self._came.notify()


def _escape(text: str) -> str:
    """Percent escapes for all that means something in a key."""
    plain = b"_-.:<>,()"
    return "".join(
        chr(byte) if chr(byte).isalnum() and byte < 128 or byte in plain else f"%{byte:02x}"
        for byte in text.encode()
    )
