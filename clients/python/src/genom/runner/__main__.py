"""The command line: that of genomd, which starts it as a cell (``--run-cell``)."""

from __future__ import annotations

import faulthandler
import os
import sys
from typing import NoReturn

from ._odd import lines_of, watch
from ._runtime import NoRuntime, Runtime

_end = os._exit


def _refuse(why: str) -> NoReturn:
    """Tells genomd, in the place of a cell, why it does not run: another start would not help."""
    words = sys.argv
    if "--run-cell" in words and "--config" in words[:-1]:
        place = os.path.dirname(words[words.index("--config") + 1])
        try:
            with open(os.path.join(place, "refusal"), "w", encoding="utf-8") as file:
                file.write(why)
        except OSError:
            # It is on standard error as well.
            pass
    print(f"error: {why}", file=sys.stderr, flush=True)
    _end(3)


def main() -> NoReturn:
    """Runs genomd in this interpreter."""
    # `-m` put the working directory of genomd there: no place of codels, nor one for a sandbox to open.
    if not getattr(sys.flags, "safe_path", False):
        del sys.path[0]
    # When a native extension crashes, the lines of Python that led there.
    faulthandler.enable(all_threads=False)
    try:
        runtime = Runtime()
    except NoRuntime as why:
        _refuse(str(why))

    process = os.getpid()

    def told_exit(status: int) -> NoReturn:
        # A child that a codel forked ends as it likes.
        if os.getpid() == process:
            runtime.log(f"os._exit({status}) ends this cell:\n{lines_of(1)}")
            runtime.exits()
        _end(status)

    os._exit = told_exit
    watch(runtime.log)
    status = runtime.run(["genomd", *sys.argv[1:]])
    sys.stdout.flush()
    sys.stderr.flush()
    # Without its finalisation: threads of genomd may be in codels still.
    _end(status)


if __name__ == "__main__":
    main()
