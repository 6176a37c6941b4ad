"""The ends of a port: who publishes there, who follows it. They go where the port goes.

What passes the values (`_through`, `_shm`, `_zenoh`) is exchanged when the port moves to another
middleware, or when its component is loaded anew.
"""

from __future__ import annotations

import threading
import time
from typing import Any, Callable, Dict, Iterator, Optional, Set, TypeVar

from . import _ways
from ._place import Place
from ._ways import Way, Wish
from .errors import GenoMError, RefusalError

# Who was refused asks again after so long, if nothing tells it to before.
_LATER = 1.0
# An end that was opened a moment ago and has ended already is not opened again at once.
_MOMENT = 0.05

Opened = TypeVar("Opened")


class _Following:
    """An end that hears of changes to its port."""

    def __init__(self, port: Place, element: Optional[str], fast: Optional[bool]) -> None:
        self.port = port
        self._element = element
        self._fast = fast
        self._way: Optional[Way] = None
        self._lock = threading.RLock()
        self._closed = False
        # Something changed: whether the way is still this one has to be asked.
        self._changed = False
        # Why there is none, and until when nobody asks again.
        self._why: Optional[GenoMError] = None
        self._until = 0.0
        self._concern: Set[str] = {port._component}

    @property
    def fast(self) -> bool:
        """Whether values go straight through shared memory or over zenoh."""
        return self._way is not None and self._way.backend is not None

    def _watched(self, begin: Callable[[], None]) -> None:
        """Begins, hearing of all that changes meanwhile."""
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
            # The daemon follows the port by itself.
            watch.remove(self)
        elif not self._closed:
            watch.add(self)

    def _hear(self, change: Optional[Dict[str, Any]]) -> None:
        """Something changed in the daemon; nobody knows what."""
        if change is not None:
            here = self.port.address(self._element)
            if change.get("component") not in self._concern and change.get("in") != here:
                return
            self._note(change)
        self._changed = True

    def _note(self, change: Dict[str, Any]) -> None:
        """A change of this port."""

    def _doubt(self) -> None:
        """Nobody tells any more what changes: it has to be asked, when there is something to do."""
        self._changed = True

    def _ask(self) -> None:
        """Asks for the way and goes it; raises why there is none."""
        with self._lock:
            if self._closed:
                raise self._over("it is not followed any more")
            if self._why is not None and not self._changed and time.monotonic() < self._until:
                raise self._why
            # Before it is asked: what changes from now on is asked for again.
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
        """Whether it was open."""
        with self._lock:
            was, self._closed, self._changed = not self._closed, True, True
        self.port._client._watch.remove(self)
        return was


class Publisher(_Following):
    """The writing end of an in port: ``p(0.5)`` or ``p(position=1.0)`` publishes.

    It goes with its port to another middleware, and publishes its last value again to a component
    that was loaded anew. Where that cannot be, publishing raises.
    """

    def __init__(self, port: Place, element: Optional[str], fast: Optional[bool]) -> None:
        super().__init__(port, element, fast)
        self._end: Any = None
        # What was published last by an end that is closed.
        self._last: Any = None
        # Somebody took the connection away, and the component is still the same.
        self._cut = False
        self._watched(lambda: self._feed(self.port.connected(element) is not None))

    def __call__(self, value: Any = None, **members: Any) -> None:
        """Publishes a value; members left out keep the value published last, at first zero."""
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
            # Heard meanwhile.
            self._settle()

    def close(self) -> None:
        """Takes the connection away, so that the component reads nothing from here."""
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
        # Where somebody publishes just now, that thread looks when it is done.
        if self._changed and self._end is not None and self._lock.acquire(blocking=False):
            try:
                self._settle()
            finally:
                self._lock.release()

    def _settle(self) -> None:
        """A component that is back wants its value, also if nobody publishes for a while."""
        try:
            with self._lock:
                if self._changed and not self._closed:
                    self._ask()
        except GenoMError:
            pass  # Who publishes next is told.

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
        """Has the port read from here, and opens the end that it reads."""
        way = _ways.writing(self.port, self._element, self._fast)
        here = self.port.address(self._element)
        if way.backend is not None:
            # The daemon makes the place, and lets go of it if it published there.
            self.port._client.connect_port(here, here, backend=way.backend)
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
        """Leaves the address to others, and keeps what was published."""
        if self._way is not None:
            self._last = self._end.last()
            self._end.close()
            self._way = None


class Subscription(_Following):
    """The reading end of a port; iterate over it to wait for each value.

    It goes with its port to another middleware, and to a component that was loaded anew; its last
    value comes again then. While the component is not there, reading raises.
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
        """The oldest value not taken yet; None when there is none."""
        value = self._end.take()
        if value is None:
            # Only now: what came before a change comes first.
            if not self._changed and self._why is None and not self._end.ended:
                return None
            self._ask()
            value = self._end.take()
            if value is None:
                return None
        self._last = value
        return value

    def read(self) -> Any:
        """The newest value, taken or not; None when there never was one."""
        while self.take() is not None:
            pass
        return self._last

    def wait(self, timeout: Optional[float] = None) -> Any:
        """The oldest value not taken yet, as soon as there is one; TimeoutError if none comes."""
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
        """Stops following."""
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
