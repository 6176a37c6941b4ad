"""Runs the text of a script, with the types of its component as a module that it may import."""

from __future__ import annotations

import linecache
import os
import sys
import traceback
import types
from typing import Any, Callable, Dict, List

from ._events import Exceptions
from ._kinds import Enum
from ._limit import TooLong, run_within
from ._types import Types


class Refused(Exception):
    """A script cannot be used: all that is wrong with it."""

    def __init__(self, errors: List[str]) -> None:
        super().__init__("\n".join(errors))
        self.errors = errors


class Script:
    """What a script and the types of its component have in `sys.modules`."""

    def __init__(self, request: Dict[str, Any], known: Types, exceptions: Exceptions) -> None:
        self.path: str = request["path"]
        self.text: str = request["text"]
        self._component: str = request["component"]
        self._seconds: float = request["seconds"]
        self.undo: Callable[[], None] = lambda: None
        self._types_name = f"{self._component}_types"
        self._types = _types_module(self._types_name, request, known, exceptions)

    def run(self) -> Dict[str, Any]:
        """Runs the text; returns what it defined. What was there before is there again if it fails,
        or with `undo`: the script before it goes on."""
        folder = os.path.dirname(self.path)
        if folder not in sys.path:
            sys.path.insert(0, folder)
        name = os.path.splitext(os.path.basename(self.path))[0]
        # What it imports from beside it is imported anew: it may have changed as well.
        replaced = {name, self._types_name}
        replaced |= {one for one, module in list(sys.modules.items()) if _lies_in(module, folder)}
        before = {one: sys.modules.pop(one) for one in replaced if one in sys.modules}
        shown = linecache.cache.get(self.path)
        module = types.ModuleType(name)
        module.__file__ = self.path
        sys.modules[self._types_name], sys.modules[name] = self._types, module
        lines = self.text.splitlines(keepends=True)
        # For tracebacks: the file may hold another text by then.
        linecache.cache[self.path] = (len(self.text), None, lines, self.path)

        def undo() -> None:
            for one in (name, self._types_name):
                sys.modules.pop(one, None)
            sys.modules.update(before)
            if shown is not None:
                linecache.cache[self.path] = shown

        self.undo = undo
        try:
            run_within(
                self._seconds, lambda: exec(compile(self.text, self.path, "exec"), module.__dict__)
            )
        except BaseException as error:
            undo()
            raise Refused([_why(error, self.path)]) from None
        return module.__dict__


def _lies_in(module: Any, folder: str) -> bool:
    file = getattr(module, "__file__", None)
    return isinstance(file, str) and os.path.dirname(file) == folder


def _why(error: BaseException, path: str) -> str:
    """The error, with the line of the script that led to it."""
    if isinstance(error, SyntaxError) and error.filename == path:
        return f"line {error.lineno}: {error.msg}"
    if isinstance(error, TooLong):
        frames, what = error.frames, str(error)
    else:
        frames = list(traceback.extract_tb(error.__traceback__))
        what = f"{type(error).__name__}: {error}"
    own = [frame for frame in frames if frame.filename == path]
    where = f"line {own[-1].lineno}: " if own else ""
    inner = frames[-1] if frames else None
    within = "" if inner is None or (own and inner is own[-1]) else f" ({inner.filename}:{inner.lineno})"
    return f"{where}{what}{within}"


def _types_module(
    name: str, request: Dict[str, Any], known: Types, exceptions: Exceptions
) -> types.ModuleType:
    """Types, exceptions and constants by their names; those of other scopes within their scope."""
    module = types.ModuleType(name, f"Types of component {request['component']}.")
    component = request["component"]

    def place(segments: List[str], value: Any) -> None:
        at: Any = module
        scope = segments[:-1]
        for one in scope[1:] if scope[:1] == [component] else scope:
            if not isinstance(getattr(at, one, None), (types.SimpleNamespace, type)):
                setattr(at, one, types.SimpleNamespace())
            at = getattr(at, one)
        # A type whose name is that of a scope as well has what is in it.
        before = getattr(at, segments[-1], None)
        if isinstance(before, types.SimpleNamespace):
            for inner, held in vars(before).items():
                setattr(value, inner, held)
        setattr(at, segments[-1], value)

    for one in request["constants"]:
        place(one["name"], one["value"])
    for one in request["declared"]:
        kind = known[one["type"]]
        if not isinstance(kind, Enum) or kind.enum.__module__ == name:
            # An enumeration that was seen already has another name now.
            place(one["name"], kind.annotation() or Any)
        else:
            kind.enum.__module__ = name
            place(one["name"], kind.enum)
            # In IDL, enumerators stand in the scope of their enumeration.
            for member in kind.members:
                place([*one["name"][:-1], member.name], member)
    for one in request["exceptions"]:
        made = exceptions.classes[one["event"]]
        made.__module__ = name
        place(one["name"], made)
    return module
