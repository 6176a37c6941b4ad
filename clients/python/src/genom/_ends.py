"""Publishers and subscriptions of ports, which follow a port to another middleware.

The object that transmits the values (`_through`, `_shm`, `_zenoh`) is replaced when the port moves,
or when its component is reloaded.
"""

from __future__ import annotations

import threading
import time
from typing import Any, Callable, Dict, Iterator, Optional, Set, TypeVar

from . import _ways
from ._place import Place
from ._ways import Way, Wish
from .errors import GenoMError, RefusalError

# Seconds after which a refused request is repeated, unless a change is reported before.
_LATER = 1.0
# An end opened less than this many seconds ago that has ended is not reopened at once.
_MOMENT = 0.05

Opened = TypeVar("Opened")


class _Following:
    """An end of a port that is notified of changes."""

    def __init__(self, port: Place, element: Optional[str], fast: Optional[bool]) -> None:
        self.port = port
        self._element = element
        self._fast = fast
        self._way: Optional[Way] = None
        self._lock = threading.RLock()
        self._closed = False
        # Set when something changed: the daemon must be asked whether the way is still valid.
        self._changed = False
        # The error if there is no way, and until when it is not asked for again.
        self._why: Optional[GenoMError] = None
        self._until = 0.0
        self._concern: Set[str] = {port._component}

    @property
    def fast(self) -> bool:
        """Whether values are transmitted directly, by shared memory or zenoh."""
        return self._way is not None and self._way.backend is not None

    def _watched(self, begin: Callable[[], None]) -> None:
        """Calls ``begin`` while changes are already monitored."""
        watch = self.port._client._watch
        if self._fast is not False:
            watch.add(self)
        try:
            begin()
        except BaseException:
            watch.remove(self)
            raise

    def _take_way(self, way: Way) -> None:
        self._way = way
        source = way.source or ""
        self._concern = {self.port._component, source.split("/", 1)[0]}
        watch = self.port._client._watch
        if way.backend is None:
            # Through the daemon, the end follows the port without help.
            watch.remove(self)
        elif not self._closed:
            watch.add(self)

    def _hear(self, change: Optional[Dict[str, Any]]) -> None:
        """Called when something unspecified changed in the daemon."""
        if change is not None:
            here = self.port.address(self._element)
            if change.get("component") not in self._concern and change.get("in") != here:
                return
            self._note(change)
        self._changed = True

    def _note(self, change: Dict[str, Any]) -> None:
        """Called when this port changed."""

    def _doubt(self) -> None:
        """Called when changes are not reported any more: the way is checked at the next use."""
        self._changed = True

    def _ask(self) -> None:
        """Asks for the way and takes it; raises if there is none."""
        with self._lock:
            if self._closed:
                raise self._over("it is not followed any more")
            if self._why is not None and not self._changed and time.monotonic() < self._until:
                raise self._why
            # Cleared before asking, so that later changes lead to asking again.
            self._changed = False
            try:
                self._go()
                self._why = None
            except GenoMError as error:
                gone = error.name in ("no_such_component", "no_such_port")
                self._why = self._over(f"{error}") if gone else error
                self._until = time.monotonic() + _LATER
                raise self._why

    def _go(self) -> None:
        raise NotImplementedError

    def _over(self, why: str) -> GenoMError:
        return GenoMError("ended", None, f"{self.port.address(self._element)}: {why}")

    def _close(self) -> bool:
        """Closes the end; returns whether it was open."""
        with self._lock:
            was, self._closed, self._changed = not self._closed, True, True
        self.port._client._watch.remove(self)
        return was


class Publisher(_Following):
    """Publisher at an in port: ``p(0.5)`` or ``p(position=1.0)`` publishes.

    It follows its port to another middleware, and publishes its last value again if the component
    is reloaded. If that is not possible, publishing raises.
    """

    def __init__(self, port: Place, element: Optional[str], fast: Optional[bool]) -> None:
        super().__init__(port, element, fast)
        self._end: Any = None
        # The value published last by an end that is closed.
        self._last: Any = None
        # Set if somebody disconnected the port while the component stayed the same.
        self._cut = False
        self._watched(lambda: self._feed(self.port.connected(element) is not None))

    def __call__(self, value: Any = None, **members: Any) -> None:
        """Publishes a value; members left out keep the value published last, zero at first."""
        if members:
            if value is not None:
                raise TypeError("a publisher takes a value or members, not both")
            value = members
        self.publish(value)

    def publish(self, value: Any) -> None:
        """Publishes a value."""
        with self._lock:
            if self._changed or self._why is not None:
                self._ask()
            self._end.publish(value)
        if self._changed:
            # A change was noticed meanwhile.
            self._settle()

    def close(self) -> None:
        """Disconnects the port from this publisher."""
        if not self._close():
            return
        try:
            if self.port.connected(self._element) == self.port.address(self._element):
                self.port.disconnect(self._element)
        except GenoMError as error:
            if error.name not in ("not_connected", "no_such_component"):
                raise
        finally:
            self._let_go()

    def __enter__(self) -> "Publisher":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _hear(self, change: Optional[Dict[str, Any]]) -> None:
        super()._hear(change)
        # If another thread is publishing now, it checks for changes when it is done.
        if self._changed and self._end is not None and self._lock.acquire(blocking=False):
            try:
                self._settle()
            finally:
                self._lock.release()

    def _settle(self) -> None:
        """Publishes to a reloaded component even if the program publishes nothing for a while."""
        try:
            with self._lock:
                if self._changed and not self._closed:
                    self._ask()
        except GenoMError:
            pass  # The next call of publish raises the error.

    def _note(self, change: Dict[str, Any]) -> None:
        self._cut = change["event"] == "disconnected" or (self._cut and "component" not in change)

    def _go(self) -> None:
        here = self.port.address(self._element)
        now = self.port.now(self._element)
        if now.source is not None and now.source != here:
            self._let_go()
            raise RefusalError(
                "connected", f"{here} reads {now.source}",
                help="disconnect() it first, to feed it from here",
            )
        if self._cut:
            self._let_go()
            raise self._over("it was disconnected; a new publisher feeds it again")
        if now.source is None or self._way is None or now.on != self._way.backend:
            self._feed(now.source is not None)

    def _feed(self, was_fed: bool) -> None:
        """Connects the port to its own address, and opens the writer there."""
        way = _ways.writing(self.port, self._element, self._fast)
        here = self.port.address(self._element)
        if way.backend is not None:
            # The daemon connects the port, and closes its own publisher there, if any.
            self.port._client.connect_port(here, here, over=way.backend)
        try:
            if way == self._way:
                self._end.repeat()
            else:
                self._let_go()
                self._end = _ways.writer(self.port, self._element, way)
                if self._last is not None:
                    self._end.publish(self._last)
        except BaseException:
            if way.backend is not None and not was_fed:
                self.port.disconnect(self._element)
            raise
        self._take_way(way)

    def _let_go(self) -> None:
        """Closes the writer, and keeps the value published last."""
        if self._way is not None:
            self._last = self._end.last()
            self._end.close()
            self._way = None


class Subscription(_Following):
    """Subscription to a port; iterating over it waits for each value.

    It follows its port to another middleware, and to a reloaded component; the last value is then
    received again. While the component does not exist, reading raises.
    """

    def __init__(
        self, port: Place, element: Optional[str], fast: Optional[bool], wish: Wish
    ) -> None:
        super().__init__(port, element, fast)
        self._wish = wish
        self._end: Any = None
        self._begun = 0.0
        self._last: Any = None
        self._watched(self._go)

    def take(self) -> Any:
        """The oldest value not taken yet; None if there is none."""
        value = self._end.take()
        if value is None:
            # Checked last: values that came before a change are returned before it.
            if not self._changed and self._why is None and not self._end.ended:
                return None
            self._ask()
            value = self._end.take()
            if value is None:
                return None
        self._last = value
        return value

    def read(self) -> Any:
        """The newest value, taken or not; None if there never was one."""
        while self.take() is not None:
            pass
        return self._last

    def wait(self, timeout: Optional[float] = None) -> Any:
        """Waits for the oldest value not taken yet; raises TimeoutError if none arrives."""
        value = self.take()
        if value is not None:
            return value
        end = None if timeout is None else time.monotonic() + timeout
        while True:
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0.0:
                raise TimeoutError(f"no value on {self.port.address(self._element)} for {timeout} s")
            value = self._end.wait(left, lambda: self._changed)
            if value is not None:
                self._last = value
                return value
            value = self.take()
            if value is not None:
                return value

    def close(self) -> None:
        """Ends the subscription."""
        if self._close():
            self._end.close()

    def __iter__(self) -> Iterator[Any]:
        while True:
            try:
                yield self.wait()
            except GenoMError:
                return

    def __enter__(self) -> "Subscription":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _hear(self, change: Optional[Dict[str, Any]]) -> None:
        super()._hear(change)
        if self._changed and self._end is not None:
            self._end.wake()

    def _go(self) -> None:
        way = _ways.reading(self.port, self._element, self._fast)
        old = self._end
        if old is not None and way == self._way and not old.ended:
            return
        time.sleep(max(0.0, self._begun + _MOMENT - time.monotonic()))
        self._begun = time.monotonic()
        self._end = _ways.reader(self.port, self._element, way, self._wish)
        self._take_way(way)
        if old is not None:
            old.close()
