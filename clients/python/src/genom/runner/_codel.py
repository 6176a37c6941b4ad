"""C functions of codels: each calls a Python function with views of its arguments."""

from __future__ import annotations

import ctypes
import inspect
import threading
import traceback
from typing import Any, Callable, Dict, List, NamedTuple, Optional

from . import _kept, _ports, _remotes
from ..codel import Raised
from ._events import Events, Exceptions, record, unkex
from ._kinds import Kind, Unsupported
from ._records import python_name
from ._types import Types

# Most sets of arguments that are remembered for a codel: more come of sequences that move.
_MOST = 256

_thread = threading.local()


def _enter() -> None:
    """Lets the interpreter keep what it knows of this thread until the next call: making that anew
    each time takes longer than a codel may."""
    ctypes.pythonapi.PyGILState_Ensure()
    _thread.here = True


class Codel:
    """One codel of a script."""

    def __init__(
        self, described: Dict[str, Any], types: Types, handles: "Handles", events: Events,
        exceptions: Exceptions, component: str, log: Callable[[str], None],
    ) -> None:
        self.name, self.place = described["name"], described["place"]
        self.owner: str = described["owner"]
        self.yields: Optional[List[str]] = described["yields"]
        self._events, self._log = events, log
        if self.yields is None:
            self._returns: Dict[Any, int] = {None: 0}
        else:
            self._returns = {one: events[f"::{component}::{one}"] for one in self.yields}
        self.parameters = [
            Parameter(one, types, handles, exceptions) for one in described["parameters"]
        ]

    def c_function(self, function: Callable[..., Any]) -> Any:
        """A C function that calls this one, which fits."""
        self._where = f"{function.__code__.co_filename}:{function.__code__.co_firstlineno}"
        names = {one.python: rank for rank, one in enumerate(self.parameters)}
        by_address = [rank for rank, one in enumerate(self.parameters) if one.value is None]
        self._made_of = by_address
        arguments = ", ".join(f"a{rank}" for rank in range(len(self.parameters)))
        passed: List[str] = []
        defaults: Dict[str, Any] = {}
        for parameter in inspect.signature(function).parameters.values():
            if parameter.name not in names:
                # One of its own: the next ones keep their places.
                own = f"own{len(defaults)}"
                defaults[own] = parameter.default
                keyword = parameter.kind is parameter.KEYWORD_ONLY
                passed.append(f"{parameter.name}={own}" if keyword else own)
                continue
            rank = names[parameter.name]
            one = self.parameters[rank]
            if one.value is None:
                text = f"views[{by_address.index(rank)}]"
            else:
                text = f"given{rank}(a{rank})" if one.converts else f"a{rank}"
            keyword = parameter.kind is parameter.KEYWORD_ONLY
            passed.append(f"{parameter.name}={text}" if keyword else text)
        key = ", ".join([*(f"a{rank}" for rank in by_address), "context"])
        names_of_views = [self.parameters[rank].python for rank in by_address]
        watch = _kept.Watch(names_of_views, function, self._keeps)
        scope: Dict[str, Any] = {
            "function": function, "known": {}, "make": self._make, "thread": _thread,
            "enter": _enter, "returns": self._returns, "raised": self._raised,
            "wrong": self._wrong, "calls": _kept.calls, "turn": watch.turn,
            "watch": _kept.watch, "look": watch.look, "forget": _kept.forget, **defaults,
        }
        scope.update({f"given{rank}": one.given for rank, one in enumerate(self.parameters)})
        text = _TEXT.format(
            arguments=f"{arguments}, context" if arguments else "context",
            key=key, passed=", ".join(passed),
        )
        exec(compile(text, f"<codel {self.name}>", "exec"), scope)
        classes = [one.value or ctypes.c_void_p for one in self.parameters]
        prototype = ctypes.CFUNCTYPE(ctypes.c_void_p, *classes, ctypes.c_void_p)
        return prototype(scope["codel"])

    def _make(self, known: Dict[Any, Any], key: Any) -> Any:
        """The views of arguments at these addresses; the last one is the context."""
        addresses = key if isinstance(key, tuple) else (key,)
        if len(known) >= _MOST:
            known.clear()
        views = [
            self.parameters[rank].view(address, addresses[-1])
            for rank, address in zip(self._made_of, addresses)
        ]
        for rank in range(len(views)):
            _kept.given.pop(id(views[rank]), None)
        known[key] = made = (views, _kept.counts(views))
        return made

    def _raised(self, error: BaseException, context: int) -> int:
        """The codel raised: an exception of a description, or an error of its own."""
        if isinstance(error, Raised) and (error._recorded or self._declared(error)):
            return record(self._events, error, context)
        frames = traceback.extract_tb(error.__traceback__)[1:]
        text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        where = f"{frames[-1].filename}:{frames[-1].lineno}" if frames else self._where
        shown = "".join(traceback.format_list(frames))
        self._log(
            f"codel {self.name} ({self.place}) of {self.owner} raised an exception that the "
            f"description does not declare:\n{shown}{text}"
        )
        return unkex(self._events, f"{text} ({_end(where)})", context)

    def _keeps(self, what: str, line: int) -> None:
        """The codel keeps a view."""
        file = self._where.rpartition(":")[0]
        self._log(f"codel {self.name} ({self.place}) of {self.owner}, {file}:{line}, {what}")

    def _declared(self, error: Raised) -> bool:
        try:
            self._events[error.event]
        except KeyError:
            return False
        return True

    def _wrong(self, event: Any, context: int) -> int:
        """The codel returned what it may not."""
        if self.yields is None:
            may = "nothing: what is refused is raised"
        else:
            may = ", ".join(repr(one) for one in self.yields)
        self._log(
            f"codel {self.name} ({self.place}) of {self.owner}, {self._where}, returned {event!r}; "
            f"it may return {may}"
        )
        return unkex(self._events, f"{self.name} returned {event!r} ({_end(self._where)})", context)


# An event that is not known may be unhashable.
_TEXT = """
def codel({arguments}):
    try:
        thread.here
    except AttributeError:
        enter()
    looks = turn()
    if looks:
        watch()
    calls.append(None)
    try:
        try:
            views, usual = known[{key}]
        except KeyError:
            views, usual = make(known, ({key}))
        event = function({passed})
    except BaseException as error:
        calls.pop()
        if looks:
            forget()
        return raised(error, context)
    calls.pop()
    if looks:
        look(views, usual)
    try:
        return returns[event]
    except (KeyError, TypeError):
        return wrong(event, context)
"""


def _end(where: str) -> str:
    """The last parts of a path, since messages have little room."""
    return where[where.rfind("/") + 1 :]


class Handles(NamedTuple):
    """What the daemon says of the ports and the remotes of a component."""

    ports: List[Dict[str, Any]]
    remotes: List[Dict[str, Any]]


class Parameter:
    """A parameter of a codel: what it is in C, and what in Python."""

    def __init__(
        self, described: Dict[str, Any], types: Types, handles: Handles, exceptions: Exceptions
    ) -> None:
        self.name: str = described["name"]
        self.python = python_name(self.name)
        self.place: str = described["place"]
        # Ports and remotes.
        self.is_handle: bool = described["from"] != "data"
        self.const: bool = described["direction"] == "in"
        self.kind: Kind = types[described["type"]]
        # Its type in C when it is passed by value.
        self.value: Any = None
        self.given: Any = None
        self.converts = False
        self.view: Callable[[int, int], Any]
        if described["from"] == "port":
            self.view = _ports.maker(handles.ports[described["rank"]], self.kind, exceptions)
            return
        if described["from"] == "remote":
            self.view = _remotes.maker(handles.remotes[described["rank"]], types, exceptions)
            return
        try:
            seen = types.argument(described["type"], self.const)
        except Unsupported as why:
            raise Unsupported(f"parameter `{self.name}` ({self.place}): {why}") from None
        if self.const and self.kind.by_value is not None:
            self.value, self.given = self.kind.by_value, self.kind.given
            self.converts = type(self.kind).given is not Kind.given
            return
        const = self.const
        if const and not _lasts(self.kind):
            # In place, and yet a value of Python: read at each call.
            self.value, self.converts = ctypes.c_void_p, True
            kind = self.kind
            self.given = lambda address: kind.get(address, True, None)
            return
        self.view = lambda address, _: seen.get(address, const, None)


def _lasts(kind: Kind) -> bool:
    """Whether a view of such a value shows what is there later on."""
    from ._lists import Array, SequenceKind
    from ._records import Record, Union_

    return isinstance(kind, (Record, Array, SequenceKind, Union_))
