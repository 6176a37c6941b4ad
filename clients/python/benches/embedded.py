"""What a step of an embedded daemon costs: ``PYTHONPATH=src python3 benches/embedded.py DEMO [STEPS]``.

``DEMO`` is the library of the demo (``target/components/demo/demo.so``), ``$GENOMD`` genomd. In turns, so
that a slow moment of the machine is part of all rows alike: a message to another process and back over
the same kind of socket, a step of a daemon that has nothing to do, one with two ports that are written
and read at each step while the demo stands still, and one of which the demo has a period at each step;
the same with the demo in a cell, and there without a value that was written.
"""

import os
import socket
import sys
import time
from typing import Callable, List, Optional, Tuple

import genom

BURST = 200


def echo(end: socket.socket) -> None:
    """The other process: sends back what comes."""
    while end.send(end.recv(64) or os._exit(0)):
        pass


def bare() -> Callable[[], None]:
    """A message to another process and back."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    if os.fork() == 0:
        ours.close()
        echo(theirs)
    theirs.close()
    room = bytearray(64)

    def exchange() -> None:
        ours.send(b"0123456789abcdef")
        ours.recv_into(room)

    return exchange


def main() -> None:
    """Prints a table."""
    demo, steps = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 20_000
    exchange = bare()
    with genom.Daemon() as idle, genom.Daemon() as busy, genom.Daemon() as far:

        def with_ports(d: genom.Daemon, cell: Optional[str]) -> Callable[[float], Callable[[], None]]:
            loaded = d.load(demo, cell=cell)
            gain, position = d.port(loaded.parameter), d.port(loaded.position)

            def by(seconds: float) -> Callable[[], None]:
                def step() -> None:
                    gain.write(0.5)
                    d.step(seconds)
                    position.data.position

                return step

            return by

        here, there = with_ports(busy, None), with_ports(far, "arm")

        rows: List[Tuple[str, Callable[[], None], List[float]]] = [
            ("a message to another process and back", exchange, []),
            ("a step without components", lambda: idle.step(1e-6), []),
            ("a step with two ports, nothing due", here(0.0), []),
            ("a step with two ports and a period of the demo", here(0.005), []),
            ("a step of a cell, nothing written or due", lambda: far.step(0.0), []),
            ("a step with two ports in a cell, nothing due", there(0.0), []),
            ("a step with two ports in a cell and a period of the demo", there(0.005), []),
        ]
        for _ in range(steps // BURST):
            for _, run, spans in rows:
                for _ in range(BURST):
                    begin = time.perf_counter()
                    run()
                    spans.append(time.perf_counter() - begin)
        print(f"Python {sys.version.split()[0]}, microseconds: p50, p99")
        for name, _, spans in rows:
            spans.sort()
            at = [spans[len(spans) * part // 100] * 1e6 for part in (50, 99)]
            print(f"{at[0]:7.1f} {at[1]:8.1f}  {name}")


if __name__ == "__main__":
    main()
