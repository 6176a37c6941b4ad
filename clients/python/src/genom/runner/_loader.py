"""Loads scripts for genomd: from a request to C functions, or to all that is wrong."""

from __future__ import annotations

import json
import threading
from typing import Any, Callable, Dict, List

from ._check import Checker
from ._codel import Codel, Handles
from ._events import UNKEX, Events, Exceptions
from ._kinds import Unsupported
from ._numbers import find_numpy
from ._script import Refused, Script
from ._types import Types


class Loader:
    """The scripts of this process."""

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        # Functions, events and modules of each: C code has their addresses.
        self._kept: Dict[int, Any] = {}
        self._next = 1
        self._turn = threading.Lock()

    def load(self, request: bytes) -> bytes:
        """The answer to a request."""
        try:
            with self._turn:
                answer = self._load(json.loads(request))
        except Refused as refused:
            answer = {"errors": refused.errors}
        return json.dumps(answer).encode()

    def release(self, number: int) -> None:
        """Forgets a script: nothing calls its functions any more."""
        self._kept.pop(number, None)

    def _load(self, request: Dict[str, Any]) -> Dict[str, Any]:
        component = request["component"]
        if any(one["kind"] in ("array", "sequence") for one in request["types"]):
            find_numpy()
        known = Types(request["types"])
        exceptions = Exceptions(request["exceptions"], known)
        states = [one for codel in request["codels"] for one in codel["yields"] or []]
        names = [f"::{component}::{one}" for one in states]
        events = Events(list(dict.fromkeys([*names, *exceptions.classes, UNKEX])))
        codels, errors = self._codels(request, known, events, exceptions)
        script = Script(request, known, exceptions)
        if errors:
            raise Refused(errors)
        scope = script.run()
        checker = Checker(script.path, script.text, scope)
        errors = [error for codel in codels for error in checker.check(codel)]
        if errors:
            script.undo()
            raise Refused(list(dict.fromkeys(errors)))
        functions = {codel.name: codel.c_function(scope[codel.name]) for codel in codels}
        number, self._next = self._next, self._next + 1
        self._kept[number] = (functions, events, exceptions, scope)
        return {
            "functions": {name: _address(one) for name, one in functions.items()},
            "events": {"start": events.start, "end": events.end},
            "number": number,
        }

    def _codels(
        self, request: Dict[str, Any], known: Types, events: Events, exceptions: Exceptions
    ) -> Any:
        handles = Handles(request["ports"], request["remotes"])
        codels: List[Codel] = []
        errors: List[str] = []
        for one in request["codels"]:
            try:
                codels.append(
                    Codel(
                        one, known, handles, events, exceptions, request["component"], self._log
                    )
                )
            except Unsupported as why:
                errors.append(f"codel `{one['name']}` ({one['place']}): {why}")
        return codels, errors


def _address(function: Any) -> int:
    import ctypes

    return ctypes.cast(function, ctypes.c_void_p).value or 0
