"""What a call of a codel in Python costs: ``PYTHONPATH=src:. python3 benches/codels.py``.

C calls the codel as genomd does; the call of C from Python that starts it is part of the figures of
all rows alike, so that differences between rows are those of the codels.
"""

import ctypes
import sys
import time
from typing import Any, List

from tests.scripts import IDS, Called, codel, data, pointer

CALLS, TIMES = 20_000, 7


def microseconds(body: str, *parameters: Any) -> float:
    """The shortest mean time of a call."""
    names = ", ".join(one["name"] for one in parameters)
    lines = "".join(f"    {line}\n" for line in body.splitlines())
    called = Called(f"def f({names}):\n{lines}    return 'main'\n", codel(*parameters, yields=["main"]))
    memory = (ctypes.c_uint8 * IDS["size"])()
    arguments: List[Any] = [pointer(memory) for _ in parameters]
    classes = [ctypes.c_void_p] * (len(arguments) + 1)
    function = ctypes.CFUNCTYPE(ctypes.c_void_p, *classes)(called.answer["functions"]["f"])
    arguments.append(ctypes.addressof(called.context))
    best = float("inf")
    for _ in range(TIMES):
        begin = time.perf_counter()
        for _ in range(CALLS):
            function(*arguments)
        best = min(best, (time.perf_counter() - begin) / CALLS)
    assert not called.logged, called.logged
    return best * 1e6


def main() -> None:
    """Prints a table."""
    ids = data("ids", "inout", 10)
    rows = [
        ("empty, no arguments", "pass", []),
        ("the IDS, not used", "pass", [ids]),
        (
            "three doubles read and written",
            "ids.velocity += 1\nids.current.position += 1\nids.last += 1",
            [ids],
        ),
        (
            "an integer, an enumeration, a double read and written",
            "ids.count = (ids.count + 1) % 9\nids.speed = ids.speed\nids.last += 1",
            [ids],
        ),
        ("an element of an array read and written", "ids.joints[0] += 1", [ids]),
    ]
    print(f"Python {sys.version.split()[0]}, microseconds a call")
    for name, body, parameters in rows:
        print(f"{microseconds(body, *parameters):6.2f}  {name}")


if __name__ == "__main__":
    main()
