"""Chooses how the values of a port are transmitted: shared memory, zenoh, or the daemon."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Sequence

from ._place import Place
from .errors import RefusalError

# Middlewares that this package supports, the fastest first.
_SPOKEN = ("shm", "zenoh")


@dataclass(frozen=True)
class Way:
    """How the values of a port are transmitted."""

    backend: Optional[str]
    """The middleware that is spoken from here; None through the daemon."""
    source: Optional[str]
    """The address they come from."""
    digest: Optional[str]
    """Of their type, where that has to be known here."""


def reading(port: Place, element: Optional[str], fast: Optional[bool]) -> Way:
    """The way from a port to a reader, as of now."""
    now = port.now(element)
    if port.direction == "in":
        return _way(port, [] if now.on is None else [now.on], now.source, fast)
    return _way(port, now.backends, port.address(element), fast)


def writing(port: Place, element: Optional[str], fast: Optional[bool]) -> Way:
    """The way from a publisher to an in port, as of now."""
    here, now = port.address(element), port.now(element)
    # If the port is connected to its own address already, on that middleware.
    there = [now.on] if now.source == here and now.on in _SPOKEN else now.backends
    return _way(port, there, here, fast)


@dataclass(frozen=True)
class Wish:
    """What a reader asks for."""

    depth: int
    rate: float
    buffers: bool


def reader(port: Place, element: Optional[str], way: Way, wish: Wish) -> Any:
    """Opens a reader on that way."""
    if way.backend == "zenoh":
        from . import _zenoh

        return _zenoh.Reader(port, str(way.source), wish.depth, wish.buffers)
    if way.backend == "shm":
        from . import _shm

        return _shm.Reader(port, str(way.source), wish.depth, wish.buffers)
    from . import _through

    return _through.Reader(port, element, wish.rate, wish.buffers)


def writer(port: Place, element: Optional[str], way: Way) -> Any:
    """Opens a writer on that way."""
    if way.backend == "zenoh":
        from . import _zenoh

        return _zenoh.Writer(port, str(way.source))
    if way.backend == "shm":
        from . import _shm

        return _shm.Writer(port, str(way.source))
    from . import _through

    return _through.Writer(port, element)


def _way(port: Place, backends: Sequence[Optional[str]], source: Optional[str], fast: Optional[bool]) -> Way:
    slow = Way(None, source, None)
    if fast is False:
        return slow
    backend = next((name for name in _SPOKEN if name in backends), None)
    why = _why_slow(port, backend, backends)
    if why is None:
        return Way(backend, source, port.layout(anew=True)["digest"])
    if fast:
        raise RefusalError("not_fast", f"{port.address()} has no fast path: {why}")
    return slow


def _why_slow(
    port: Place, backend: Optional[str], backends: Sequence[Optional[str]]
) -> Optional[str]:
    """Why a middleware cannot be used from here; None if it can."""
    if backend is None:
        on = "+".join(str(name) for name in backends)
        return f"it is on {on}, not on shm or zenoh" if on else "it is not connected"
    if backend == "zenoh":
        try:
            import zenoh  # noqa: F401
        except ImportError:
            return "the package eclipse-zenoh is not installed"
        if "connect" not in port._client._meeting_point("zenoh"):
            return "the daemon's zenoh has no endpoint to connect to"
        return None
    if not port._client._transport.local:
        return "the daemon is on another machine"
    try:
        import iceoryx2  # noqa: F401
    except ImportError:
        return "the package iceoryx2 is not installed"
    return None
