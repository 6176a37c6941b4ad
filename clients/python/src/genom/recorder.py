"""Recordings made by `genomctl record`."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from typing import List, Optional, Sequence

from .errors import GenoMError

_LOOK = 0.005
# Seconds that a recorder may take to finish its file.
_PATIENCE = 60.0


class Recorder:
    """A running recording: ``with g.record('run.mcap'): ...``."""

    def __init__(self, daemon: Sequence[str], file: str, ports: Sequence[str], force: bool) -> None:
        self.file = os.path.abspath(file)
        program = os.environ.get("GENOMCTL", "genomctl")
        command = [program, *daemon, "record", "--output", self.file, *(["--force"] if force else [])]
        before = _changed(self.file)
        try:
            self._process: Optional[subprocess.Popen[str]] = subprocess.Popen(
                [*command, *ports], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                stderr=subprocess.PIPE, text=True,
                # Ctrl-C is for the program, which closes the recording.
                start_new_session=True,
            )
        except OSError as why:
            raise GenoMError(
                "no_recorder", None,
                f"`{program}` does not run: {why.strerror}; put genomctl on PATH, or name it in "
                "$GENOMCTL",
            ) from why
        # The recording has begun when its file exists.
        while self._process.poll() is None and _changed(self.file) == before:
            time.sleep(_LOOK)
        if self._process.poll() is not None:
            self.close()

    def close(self) -> str:
        """Ends the recording; returns its summary, with the numbers of samples recorded and lost.
        """
        process, self._process = self._process, None
        if process is None:
            return ""
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=_PATIENCE)
        if process.returncode != 0:
            raise GenoMError("not_recorded", None, (err or out).strip())
        return out

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _changed(file: str) -> List[int]:
    """Identifies the file, to notice that it was replaced."""
    try:
        found = os.stat(file)
    except OSError:
        return []
    return [found.st_ino, found.st_mtime_ns, found.st_size]
