"""Connections that do not work: samples between an out port and the in port that reads it are lost,
late or wrong.

The in port is disconnected, and after each period (the shortest of all tasks) what the out port wrote
is published to it: dropped, delayed or changed. `genomctl test` does the same.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any, Callable, Deque, Dict, List, Optional, Tuple

from ._daemon import Daemon
from ._http import url
from .errors import RefusalError


@dataclass
class Relay:
    """A connection whose samples pass through here."""

    port: str
    drop: bool = False
    delay: Optional[int] = None
    """Nanoseconds."""
    corrupt: Any = None
    every: int = 1
    samples: Optional[int] = None
    was: Dict[str, Any] = field(default_factory=dict)
    """The connection as it was."""
    seen: int = 0
    came: int = 0
    hit: int = 0
    waiting: Deque[Tuple[int, Any]] = field(default_factory=deque)

    def take(self, now: int, value: Any) -> None:
        """A sample was written."""
        self.came += 1
        at = now
        if self.came % self.every == 0 and (self.samples is None or self.hit < self.samples):
            self.hit += 1
            if self.drop:
                return
            if self.delay is not None:
                at += self.delay
            else:
                value = _replaced(value, self.corrupt)
        # Samples stay in order, as on every middleware: one that is late holds up the next.
        last = self.waiting[-1][0] if self.waiting else 0
        self.waiting.append((max(at, last), value))


def _replaced(value: Any, other: Any) -> Any:
    """The value with these members in place of its own."""
    if isinstance(value, dict) and isinstance(other, dict):
        return {**value, **{key: _replaced(value.get(key), one) for key, one in other.items()}}
    return other


class Faults:
    """The faults of a daemon that is stepped."""

    def __init__(self, daemon: Daemon) -> None:
        self._daemon = daemon
        self._relays: Dict[str, Relay] = {}

    def __bool__(self) -> bool:
        return bool(self._relays)

    def add(self, relay: Relay) -> None:
        """From now on samples of this in port's connection pass through here."""
        before = self._relays.get(relay.port)
        if before is not None:
            # Another fault of the same connection.
            relay.was, relay.seen, relay.waiting = before.was, before.seen, before.waiting
            self._relays[relay.port] = relay
            return
        made = self._ask("GET", "/connections")["connections"]
        found = next((one for one in made if one["in"] == relay.port), None)
        if found is None:
            raise RefusalError("not_connected", f"{relay.port} is not connected")
        keys = ("in", "out", "policy")
        relay.was = {key: found[key] for key in keys if found.get(key) is not None}
        if found.get("fixed"):
            relay.was["over"] = found["backend"]
        _, relay.seen = self._sample(relay.was["out"])
        last, _ = self._sample(relay.port)
        self._ask("DELETE", "/connections/" + relay.port)
        self._relays[relay.port] = relay
        # A reader keeps what it read last.
        if last is not None:
            self._publish(relay.port, last)

    def repair(self, port: str) -> None:
        """The connection is again as it was; what was on its way is lost."""
        relay = self._relays.pop(port, None)
        if relay is None:
            raise RefusalError("no_fault", f"{port} has no fault")
        self._ask("POST", "/connections", relay.was)

    def step(self, nanoseconds: int, step: Callable[[int], int]) -> int:
        """Advances the clock, from the end of one period to the next; returns its new time."""
        period = self.period()
        # What is due now comes first.
        now = step(0)
        target = now + nanoseconds
        while True:
            self._pass_on(now)
            if now >= target:
                return now
            now = step(min(target - now, period - now % period))

    def period(self) -> int:
        """The shortest period of all tasks, in nanoseconds."""
        periods: List[int] = []
        for component in self._daemon.components():
            try:
                tasks = self._daemon.stats(component)["tasks"]
            except RefusalError:
                # One that is down has no tasks.
                continue
            periods += [task["period_ns"] for task in tasks if task.get("period_ns")]
        return min(periods, default=1_000_000)

    def _pass_on(self, now: int) -> None:
        for relay in list(self._relays.values()):
            value, samples = self._sample(relay.was["out"])
            new, relay.seen = samples - relay.seen, samples
            if new > 1:
                raise RefusalError(
                    "too_many",
                    f"{new} samples of {relay.was['out']} within one period: a fault passes on one",
                )
            if new == 1 and value is not None:
                relay.take(now, value)
            while relay.waiting and relay.waiting[0][0] <= now:
                self._publish(relay.port, relay.waiting.popleft()[1])

    def _sample(self, address: str) -> Tuple[Any, int]:
        """The last value of a port, and how many there were."""
        port = self._ask("GET", path(address))
        return port.get("value"), (port.get("traffic") or {}).get("samples", 0)

    def _publish(self, address: str, value: Any) -> None:
        self._ask("POST", path(address), value)

    def _ask(self, method: str, path: str, body: Any = None) -> Any:
        return self._daemon._transport.request(method, path, body)


def path(address: str) -> str:
    """Where the control plane has a port, ``component/port`` or ``component/port/element``."""
    component, _, rest = address.partition("/")
    name, _, element = rest.partition("/")
    here = url("components", component, "ports", name)
    return here + ("?element=" + url(element)[1:] if element else "")
