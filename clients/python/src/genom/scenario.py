"""Scenario tests in Python, which ``genomctl test`` plays: functions that get a daemon to step.

    from genom.scenario import scenario

    PATH = ["target/components"]

    @scenario
    def a_motion_ends_at_its_goal(d):
        demo = d.load("demo")
        d.finish(demo.goto(0.5, ack=True))
        assert demo.position.read()["position"] == 0.5

``python -m genom.scenario FILE`` is what genomctl runs: it lists the scenarios of a file, or plays one,
and prints one line of JSON for each.
"""

from __future__ import annotations

import argparse
import ast
import json
import linecache
import os
import reprlib
import runpy
import signal
import sys
import traceback
from dataclasses import dataclass
from types import FrameType, TracebackType
from typing import Any, Callable, Dict, List, Optional, Sequence, Union

from .embedded import Daemon
from .errors import DaemonError, GenoMError

Function = Callable[[Daemon], Any]


@dataclass
class Scenario:
    """A function that is played with a daemon of its own, whose clock stands at zero."""

    function: Function
    name: str
    path: Sequence[str]
    config: Optional[str]
    options: Sequence[str]

    @property
    def line(self) -> int:
        """Its line in the file."""
        return self.function.__code__.co_firstlineno

    @property
    def file(self) -> str:
        """The file, as it was named."""
        return self.function.__code__.co_filename


_found: List[Scenario] = []


def scenario(
    given: Union[None, str, Function] = None,
    *,
    path: Sequence[str] = (),
    config: Optional[str] = None,
    options: Sequence[str] = (),
) -> Any:
    """Makes a function a scenario: ``@scenario``, ``@scenario("what it shows", config="robot.toml")``.

    Its name is that text, or the first line of its documentation, or the name of the function with
    spaces. ``path``, ``config`` and ``options`` are those of `genom.Daemon`; paths are relative to the
    file. ``PATH`` of the file has directories that are searched for all its scenarios.
    """

    def made(function: Function) -> Function:
        if callable(given) or given is None:
            told = (function.__doc__ or function.__name__.replace("_", " ")).strip()
            name = told.splitlines()[0].rstrip(".")
        else:
            name = given
        _found.append(Scenario(function, name, path, config, options))
        return function

    return made(given) if callable(given) else made


class _Counted(Daemon):
    """Counts the steps that a scenario makes."""

    steps = 0

    def step(self, seconds: float) -> float:
        now = super().step(seconds)
        self.steps += 1
        return now

    def finish(self, activity: Any, within: float = 60.0) -> Dict[str, Any]:
        outputs = super().finish(activity, within)
        self.steps += 1
        return outputs


def _play(one: Scenario, scope: Dict[str, Any], given: argparse.Namespace) -> Dict[str, Any]:
    """Plays one: what `genomctl test` reports of it."""
    here = os.path.dirname(os.path.abspath(one.file))
    path = [os.path.join(here, each) for each in [*one.path, *scope.get("PATH", ())]]
    options = list(one.options)
    if given.backend is not None:
        options += ["--set", f"backend={json.dumps(given.backend)}"]
    config = None if one.config is None else os.path.join(here, one.config)
    told: Dict[str, Any] = {"name": one.name, "line": one.line, "steps": 0, "nanoseconds": 0}
    try:
        daemon = _Counted(path=[*given.path, *path], config=config, options=options)
        with daemon:
            try:
                if config is not None:
                    daemon.deployed()
                one.function(daemon)
                outcome: Dict[str, Any] = {"outcome": "passed"}
            except (Exception, SystemExit) as error:
                # The daemon is still there, to read values from.
                outcome = _unmet(one, error, daemon._now)
            told.update(steps=daemon.steps, nanoseconds=daemon._now)
    except GenoMError as error:
        outcome = _unmet(one, error, 0)
    return {**told, **outcome}


def _unmet(one: Scenario, error: BaseException, now: int) -> Dict[str, Any]:
    """What did not hold, and on which line."""
    line, frame = one.line, None
    for at, number in traceback.walk_tb(error.__traceback__):
        if at.f_code.co_filename == one.file:
            frame, line = at, number
    step = linecache.getline(one.file, line).strip() or "begin"
    expected = "that it is done"
    came = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    if isinstance(error, GenoMError):
        came = f"{error.name}: {error}" if error.name not in str(error) else str(error)
    failed = isinstance(error, (AssertionError, TimeoutError, GenoMError))
    if isinstance(error, AssertionError):
        test = _assertion(one.file, line)
        expected = "that it holds" if test is None else ast.unparse(test)
        values = None if test is None or frame is None else _values(test, frame)
        came = str(error) or values or "it does not hold"
        if str(error) and values:
            came += f" ({values})"
    elif not failed:
        # Where it went on from there is for whoever wrote it.
        traceback.print_exception(type(error), error, _within(error.__traceback__, one.file))
    why = {"line": line, "step": step, "nanoseconds": now, "expected": expected, "came": came}
    failed = failed and not isinstance(error, DaemonError)
    return {"outcome": "failed" if failed else "error", "why": why}


def _within(trace: Optional[TracebackType], file: str) -> Optional[TracebackType]:
    """The part of a traceback that begins in the file."""
    while trace is not None and trace.tb_frame.f_code.co_filename != file:
        trace = trace.tb_next
    return trace


def _assertion(file: str, line: int) -> Optional[ast.expr]:
    """What is asserted on this line."""
    text = "".join(linecache.getlines(file))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Assert) and node.lineno <= line <= (node.end_lineno or node.lineno):
            return node.test
    return None


_KNOWN = {"abs", "len", "list", "max", "min", "round", "sorted", "sum", "tuple"}


def _harmless(node: ast.AST) -> bool:
    """Whether an expression may be evaluated again: it reads, and does nothing."""
    for one in ast.walk(node):
        if isinstance(one, ast.Call):
            called = one.func
            reads = isinstance(called, ast.Attribute) and called.attr in ("read", "state")
            if not reads and not (isinstance(called, ast.Name) and called.id in _KNOWN):
                return False
        if isinstance(one, (ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom, ast.Lambda)):
            return False
    return True


def _values(test: ast.expr, frame: FrameType) -> Optional[str]:
    """The two sides of a comparison that does not hold."""
    if not isinstance(test, ast.Compare) or not _harmless(test):
        return None
    short = reprlib.Repr()
    short.maxother = short.maxstring = short.maxlong = 200
    short.maxdict = short.maxlist = short.maxtuple = 20
    told = []
    for side in (test.left, *test.comparators):
        try:
            code = compile(ast.Expression(side), frame.f_code.co_filename, "eval")
            told.append(short.repr(eval(code, frame.f_globals, frame.f_locals)))
        except Exception:
            return None
    operators = [ast.unparse(ast.Compare(ast.Name("a"), [op], [ast.Name("b")])) for op in test.ops]
    words = [operator[2:-2] for operator in operators]
    return told[0] + "".join(f" {word} {side}" for word, side in zip(words, told[1:]))


def _main() -> int:
    parser = argparse.ArgumentParser(prog="genom.scenario", description=__doc__)
    parser.add_argument("file")
    parser.add_argument("--list", action="store_true", help="list the scenarios")
    parser.add_argument("--line", type=int, help="play the one on this line; all otherwise")
    parser.add_argument("--backend", help="the middleware of all ports")
    parser.add_argument("--path", action="append", default=[], help="search components here first")
    given = parser.parse_args()
    # What scenarios print is no report.
    report = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    # So that its daemon and its files go when genomctl gives it up.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    sys.path.insert(0, os.path.dirname(os.path.abspath(given.file)))
    # The decorator of this very module, also when it runs as a program.
    from genom import scenario as module

    scope = runpy.run_path(given.file, run_name="scenarios")
    chosen = [one for one in module._found if given.line in (None, one.line)]
    failed = False
    for one in chosen:
        if given.list:
            told: Dict[str, Any] = {"name": one.name, "line": one.line}
        else:
            told = module._play(one, scope, given)
            failed = failed or told["outcome"] != "passed"
        print(json.dumps(told), file=report, flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(_main())
