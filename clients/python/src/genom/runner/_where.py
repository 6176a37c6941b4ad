"""At which lines a codel is that does not return."""

from __future__ import annotations

import sys
import traceback
from typing import Optional


def where(codel: str) -> Optional[str]:
    """The lines of each thread that is in this codel; None if there is none."""
    told = []
    for top in sys._current_frames().values():
        frames = traceback.extract_stack(top)
        begin = [rank for rank, one in enumerate(frames) if one.filename == f"<codel {codel}>"]
        if begin:
            lines = traceback.format_list(frames[begin[-1] + 1 :])
            told.append("".join(lines).rstrip())
    if not told:
        return None
    return f"codel {codel} has not returned, and is here:\n" + "\n".join(told)
