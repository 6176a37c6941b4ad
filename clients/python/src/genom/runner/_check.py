"""Compares the functions of a script with the codels of the description, before any of them runs."""

from __future__ import annotations

import ast
import inspect
import typing
from typing import Any, Dict, Iterator, List, Optional, Sequence

from ._codel import Codel, Parameter
from ._records import View, meant

_PLAIN = (bool, int, float, str)


class Checker:
    """A script as text and as what its text made."""

    def __init__(self, path: str, text: str, scope: Dict[str, Any]) -> None:
        self._path, self._scope = path, scope
        tree = ast.parse(text, path)
        self._defined: Dict[int, Any] = {
            _first_line(one): one
            for one in ast.walk(tree)
            if isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef))
        }

    def check(self, codel: Codel) -> List[str]:
        """What is wrong with the function of a codel."""
        what = f"codel `{codel.name}` ({codel.place})"
        function = self._scope.get(codel.name)
        if function is None:
            known = [name for name, one in self._scope.items() if inspect.isfunction(one)]
            return [f"{what} is not defined{meant(codel.name, known)}"]
        if not inspect.isfunction(function):
            return [f"{what} is a {type(function).__name__} here, not a function (def)"]
        line = function.__code__.co_firstlineno
        own = function.__code__.co_filename == self._path
        where = f"line {line}" if own else f"{function.__code__.co_filename}:{line}"
        wrong = [*_kind(function), *_parameters(codel, function), *_annotations(codel, function)]
        wrong = [f"{what}, {where}: {one}" for one in wrong]
        text = self._defined.get(line) if own else None
        if text is not None:
            wrong += [f"{what}, {one}" for one in _returns(codel, text)]
        return wrong


def _kind(function: Any) -> Iterator[str]:
    if inspect.iscoroutinefunction(function) or inspect.isasyncgenfunction(function):
        yield "it is `async`: a codel returns its event at once"
    elif inspect.isgeneratorfunction(function):
        yield "it has a `yield`: a codel returns its event, and is called again"


def _parameters(codel: Codel, function: Any) -> Iterator[str]:
    wanted = [one.python for one in codel.parameters]
    listed = inspect.signature(function).parameters.values()
    several = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    found = [one.name for one in listed if one.kind not in several]
    for one in listed:
        if one.kind in several:
            yield f"it takes any number of arguments (`{one}`): name those of the description"
        elif one.name not in wanted and one.default is one.empty:
            yield f"the description has no parameter `{one.name}`{meant(one.name, wanted)}"
    for parameter in codel.parameters:
        if parameter.python not in found:
            yield f"it does not take parameter `{parameter.python}` ({parameter.place})"


def _annotations(codel: Codel, function: Any) -> Iterator[str]:
    try:
        given = typing.get_type_hints(function)
    except Exception:  # Names that only type checkers know.
        given = {k: v for k, v in function.__annotations__.items() if not isinstance(v, str)}
    for parameter in codel.parameters:
        annotation = given.get(parameter.python)
        if annotation is not None and not _fits(parameter, annotation):
            yield (
                f"parameter `{parameter.python}` is annotated {_name(annotation)}, and is "
                f"{_described(parameter)} ({parameter.place})"
            )
    annotation = given.get("return")
    if typing.get_origin(annotation) is typing.Literal:
        for event in typing.get_args(annotation):
            if event not in _events(codel):
                yield f"its annotation says that it returns {event!r}{_may(codel)}"


def _fits(parameter: Parameter, annotation: Any) -> bool:
    """Whether an annotation is right; one that says nothing of the type is."""
    if parameter.is_handle or not isinstance(annotation, type):
        return True
    wanted = parameter.kind.annotation()
    plain = annotation in _PLAIN
    if issubclass(annotation, View) and annotation._kind is not None:
        return wanted is annotation
    if not plain or wanted is None:
        return not plain
    if parameter.value is None:
        return False
    # An integer is a float as well for type checkers, and an enumerator an integer.
    return annotation is wanted or (annotation is int and issubclass(wanted, int) and wanted is not bool)


def _name(annotation: Any) -> str:
    return getattr(annotation, "__name__", str(annotation))


def _described(parameter: Parameter) -> str:
    name = parameter.kind.name
    if parameter.value is None and parameter.kind.annotation() in _PLAIN:
        return f"a place for a {name}: use its member `value`"
    return f"a {name}"


def _events(codel: Codel) -> Sequence[Optional[str]]:
    """What it may return."""
    return [None] if codel.yields is None else codel.yields


def _may(codel: Codel) -> str:
    if codel.yields is None:
        return "; it may return nothing: what is refused is raised"
    return f"; it may yield {', '.join(codel.yields)}"


def _returns(codel: Codel, function: Any) -> Iterator[str]:
    for one in _within(function.body):
        if not isinstance(one, ast.Return):
            continue
        for value in _constants(one.value):
            if value not in _events(codel):
                yield f"line {one.lineno}: it returns {value!r}{_may(codel)}"
    if codel.yields is not None and _goes_on(function.body):
        yield f"line {_first_line(function)}: it may end without a `return`{_may(codel)}"


def _within(body: List[ast.stmt]) -> Iterator[ast.AST]:
    """All statements of a function, without those of functions inside."""
    waiting: List[ast.AST] = list(body)
    while waiting:
        one = waiting.pop(0)
        yield one
        inner = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)
        if not isinstance(one, inner):
            waiting[:0] = ast.iter_child_nodes(one)


def _constants(value: Optional[ast.expr]) -> Iterator[Any]:
    """What an expression is seen to be."""
    if value is None:
        yield None
    elif isinstance(value, ast.Constant):
        yield value.value
    elif isinstance(value, ast.IfExp):
        yield from _constants(value.body)
        yield from _constants(value.orelse)


def _goes_on(body: List[ast.stmt]) -> bool:
    """Whether what comes after these statements may be reached."""
    return all(_passes(one) for one in body)


def _passes(one: Any) -> bool:
    if isinstance(one, (ast.Return, ast.Raise, ast.Continue)):
        return False
    if isinstance(one, ast.If):
        return _goes_on(one.body) or _goes_on(one.orelse)
    if isinstance(one, (ast.With, ast.AsyncWith)):
        return _goes_on(one.body)
    if isinstance(one, ast.While) and isinstance(one.test, ast.Constant) and one.test.value:
        return any(isinstance(inner, ast.Break) for inner in _within(one.body))
    if isinstance(one, ast.Try) or type(one).__name__ == "TryStar":
        if one.finalbody and not _goes_on(one.finalbody):
            return False
        ends = [*one.body, *one.orelse]
        return _goes_on(ends) or any(_goes_on(handler.body) for handler in one.handlers)
    if type(one).__name__ == "Match":
        last = one.cases[-1]
        whole = last.guard is None and getattr(last.pattern, "pattern", 0) is None
        return not whole or any(_goes_on(case.body) for case in one.cases)
    return True


def _first_line(function: Any) -> int:
    """As in its code: the first decorator counts."""
    lines: List[int] = [one.lineno for one in (function, *function.decorator_list)]
    return min(lines)
