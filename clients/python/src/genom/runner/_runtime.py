"""genomd as a library, which this process runs."""

from __future__ import annotations

import ctypes
import os
import sys
from typing import List

from .. import __version__
from ._loader import Loader
from ._where import where

VARIABLE = "GENOM_RUNTIME"

_LOAD = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
_RELEASE = ctypes.CFUNCTYPE(None, ctypes.c_uint64)
_WHERE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_size_t)


class NoRuntime(Exception):
    """The library is missing, or of another version."""


class Runtime:
    """The library."""

    def __init__(self) -> None:
        path = os.environ.get(VARIABLE)
        if not path:
            raise NoRuntime(
                f"{VARIABLE} names no library: genomd found no libgenom_runner.so beside itself; "
                "install all of its package"
            )
        try:
            self._library = ctypes.CDLL(path)
        except OSError as why:
            raise NoRuntime(f"{why}") from None
        self._library.genom_version.restype = ctypes.c_char_p
        version = self._library.genom_version().decode()
        if version != __version__:
            raise NoRuntime(
                f"{path} is genomd {version}, and this Python has the package genom {__version__}: "
                f"pip install genom=={version}"
            )
        self._library.genom_run.argtypes = [
            ctypes.c_char_p, ctypes.c_size_t, ctypes.POINTER(ctypes.c_char_p), _LOAD, _RELEASE,
            _WHERE,
        ]
        self._library.genom_answer.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t]
        self._library.genom_answer.restype = None
        self._library.genom_reads.argtypes = [ctypes.c_char_p]
        self._library.genom_reads.restype = None
        self._library.genom_log.argtypes = [ctypes.c_char_p, ctypes.c_size_t]
        self._library.genom_log.restype = None

    def log(self, text: str) -> None:
        """Writes an error into the log of genomd."""
        code = text.encode("utf-8", "replace")
        self._library.genom_log(code, len(code))

    def exits(self) -> None:
        """Says that this thread is about to end the process."""
        self._library.genom_exits()

    def run(self, words: List[str]) -> int:
        """Runs genomd with these arguments until it ends; returns its exit status."""
        loader = Loader(self.log)
        answer = self._library.genom_answer

        def load(request: int, size: int, place: int) -> None:
            code = loader.load(ctypes.string_at(request, size))
            answer(place, code, len(code))

        def tell_where(codel: int, size: int) -> None:
            told = where(ctypes.string_at(codel, size).decode())
            if told:
                self.log(told)

        functions = _LOAD(load), _RELEASE(loader.release), _WHERE(tell_where)
        # A sandbox lets this process read what it imports.
        for place in {*sys.path, sys.prefix, sys.base_prefix, sys.exec_prefix} - {""}:
            self._library.genom_reads(os.fsencode(os.path.abspath(place)))
        arguments = (ctypes.c_char_p * len(words))(*(os.fsencode(word) for word in words))
        return int(self._library.genom_run(b"python", len(words), arguments, *functions))
