"""Views that a script keeps longer than the call that it got them for.

After a call, whoever refers to a view besides the runner is the script. That is looked at after the
first call of a codel and one in so many, and only while no other call is under way, in any thread, whose
codel may refer to the same views.
"""

from __future__ import annotations

import dis
import gc
import sys
from collections import deque
from itertools import cycle
from threading import get_ident
from types import ModuleType
from typing import Any, Callable, Dict, List, Optional, Tuple

from . import _numbers

# An entry for each call under way, and for each that is looked at.
calls: List[None] = []
watching: List[None] = []
# Views of parts of arguments that these made: the thread, the view, and how often the runner keeps it.
given: Dict[int, Tuple[int, Any, int]] = {}
# More are not looked at: a codel may go through thousands of elements.
_MOST = 64
# Suspicions that nothing came of; each costs a collection of young garbage.
_VAIN = 8
# After how many calls it is looked at again.
_EVERY = 16


def watch() -> None:
    """A call begins that is looked at."""
    watching.append(None)
    me = get_ident()
    for key, (thread, *_) in list(given.items()):
        if thread == me:
            given.pop(key, None)


def forget() -> None:
    """It has ended."""
    watching.pop()
    if not watching:
        given.clear()


def give(view: Any, known: int = 0) -> Any:
    """The view, which is looked at after the call; the runner keeps it itself so many times."""
    if len(given) < _MOST:
        given[id(view)] = (get_ident(), view, known)
    return view


def counts(views: List[Any]) -> Tuple[int, ...]:
    """References to each of these."""
    return tuple(map(sys.getrefcount, views))


def _base(one: Any) -> Any:
    """What an array of NumPy is a view of; slices of it refer to that, and not to the array."""
    return one.base if _numbers.numpy is not None and isinstance(one, _numbers.numpy.ndarray) else None


# References that every count has, which depend on the interpreter.
_OWN = counts([object()])[0] - 1


class Watch:
    """Whether a codel keeps views; told once."""

    def __init__(
        self, names: List[str], function: Callable[..., Any], tell: Callable[[str, int], None]
    ) -> None:
        self._names, self._function, self._tell = names, function, tell
        self._left = _VAIN
        self.turn = cycle([True] + [False] * (_EVERY - 1)).__next__

    def look(self, views: List[Any], usual: Tuple[int, ...]) -> None:
        """Looks whether somebody refers to arguments, or to parts of some, after a call."""
        if self._left and not calls and self._found(views, usual) is not None:
            self._left -= 1
            # Garbage may refer to a view: a function that refers to itself, a traceback.
            gc.collect(0)
            found = self._found(views, usual)
            # Counted before this: what other threads did meanwhile is under way still, or not counted.
            if found is not None and not calls:
                self._left = 0
                self._told(*found)
        forget()

    def _found(self, views: List[Any], usual: Tuple[int, ...]) -> Optional[Tuple[Any, str]]:
        """A view to which somebody refers, and what it is."""
        for rank, (count, before) in enumerate(zip(counts(views), usual)):
            if count > before:
                return views[rank], f"`{self._names[rank]}`"
        me = get_ident()
        entries = [entry for entry in list(given.values()) if entry[0] == me]
        parts = [entry[1] for entry in entries]
        bases = [_base(part) for part in parts]
        for rank, (count, more) in enumerate(zip(counts(parts), counts(bases))):
            # Its entry and the list; of what it is a view of, the view and the list.
            kept = count > _OWN + 2 + entries[rank][2]
            if kept or (bases[rank] is not None and more > _OWN + 2):
                return parts[rank], "a part of its arguments"
        return None

    def _told(self, view: Any, what: str) -> None:
        line = self._function.__code__.co_firstlineno
        holder = _holder(self._function.__globals__, view)
        if holder is not None:
            line = _line(self._function.__code__, holder) or line
            what += f" in `{holder}`"
        self._tell(
            f"keeps a view of {what} after its call: it shows other values then, or memory that is "
            "gone; keep values, such as float(a), list(a) or a.copy()",
            line,
        )


def _holder(scope: Dict[str, Any], view: Any) -> Optional[str]:
    """The global name under which the script keeps it, if it is easily found."""
    for name, value in list(scope.items()):
        if name.startswith("__") or isinstance(value, ModuleType):
            continue
        items: List[Any] = [value]
        if isinstance(value, (list, tuple, deque)):
            items += list(value)[-_MOST:]
        elif isinstance(value, dict):
            items += list(value.values())[-_MOST:]
        elif type(value).__module__ == scope.get("__name__"):
            items += list(getattr(value, "__dict__", {}).values())
        if any(_leads(one, view) for one in items):
            return name
    return None


def _leads(one: Any, view: Any) -> bool:
    """Whether it is the view, or a view of a part of it."""
    # They are made with this module.
    from ._lists import ListView
    from ._records import View

    base = _base(view)
    for _ in range(16):
        if one is view or (one is base and base is not None):
            return True
        if isinstance(one, View):
            one = one._b_base_
        elif isinstance(one, ListView):
            one = one._owner
        else:
            one = _base(one)
    return False


def _line(code: Any, name: str) -> Optional[int]:
    """The first line of a function that uses a name."""
    line: Optional[int] = None
    for one in dis.get_instructions(code):
        here = getattr(one, "line_number", one.starts_line)
        if isinstance(here, int) and not isinstance(here, bool):
            line = here
        if one.argval == name:
            return line
    return None
