"""Errors. All derive from GenoMError, so that one ``except`` is sufficient."""

from __future__ import annotations

import json
from typing import Any, Dict, Optional, Type


class GenoMError(Exception):
    """A service ended with an exception, or the daemon could not do what was asked.

    ``name`` is the full name of the exception, such as ``::demo::OUT_OF_RANGE``, or the stable name
    of a refusal, such as ``no_such_service``. ``detail`` holds the members of the exception.
    """

    def __init__(
        self, name: str, detail: Any = None, message: Optional[str] = None
    ) -> None:
        self.name = name
        self.detail = detail
        shown = "" if not detail else " " + json.dumps(detail)
        super().__init__(message if message is not None else name + shown)


class DaemonError(GenoMError):
    """No daemon answers, or the connection was lost."""


class RefusalError(GenoMError):
    """The daemon refused the request: nothing was run or changed."""

    def __init__(
        self,
        name: str,
        message: str,
        where: Optional[str] = None,
        help: Optional[str] = None,
    ) -> None:
        self.where = where
        self.help = help
        text = message
        if where and where.strip("/"):
            text += f" (at {where})"
        if help:
            text += f"; {help}"
        super().__init__(name, None, text)


class InputError(RefusalError, ValueError):
    """A value does not have the type that the component's description requires."""


_classes: Dict[str, Type[GenoMError]] = {}


def exception_class(name: str) -> Type[GenoMError]:
    """The class for an exception of this full name; always the same for one name."""
    known = _classes.get(name)
    if known is None:
        last = name.rsplit("::", 1)[-1]

        def __init__(
            self: GenoMError, detail: Any = None, message: Optional[str] = None
        ) -> None:
            GenoMError.__init__(self, name, detail, message)

        body = {"__init__": __init__, "__doc__": f"Exception {name}.", "__module__": "genom"}
        known = _classes.setdefault(name, type(last, (GenoMError,), body))
    return known


def exception(name: str, detail: Any = None, message: Optional[str] = None) -> GenoMError:
    """An exception of the class for this name."""
    make: Any = exception_class(name)
    made: GenoMError = make(detail, message)
    return made


def refusal(reply: Any, status: int) -> GenoMError:
    """The error for a reply that is not a success."""
    error = reply.get("error") if isinstance(reply, dict) else None
    if not isinstance(error, dict):
        return RefusalError("not_understood", f"genomd answers {status} without a reason")
    code = str(error.get("code", ""))
    message = str(error.get("message", ""))
    if code in ("disallowed", "too_many_activities"):
        # These are exceptions of GenoM that the daemon reports as HTTP errors.
        help = error.get("help")
        return exception("::genom::" + code, None, f"{message}; {help}" if help else message)
    kind = InputError if code in ("bad_input", "malformed") else RefusalError
    return kind(code, message, error.get("where"), error.get("help"))
