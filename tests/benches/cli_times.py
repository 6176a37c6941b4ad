#!/usr/bin/env python3
"""Wall time of genomctl, from start to exit, against a daemon that runs the demo.

    cargo build --release -p genomd -p genomctl
    tests/benches/cli_times.py target/release target/components/demo/demo.so [COUNT]

Prints p50, p99 and the maximum of COUNT runs (10,000 by default) of `list`, of completion with
live names, and of `call`; for comparison also of /bin/true, which shows the cost of starting a
process. A query must take less than 50 ms.
"""

import os
import subprocess
import sys
import tempfile
import time


def run(program: str, arguments: "list[str]", environment: "dict[str, str]", null: int) -> float:
    """Seconds from before the start to after the end of one run."""
    actions = [(os.POSIX_SPAWN_DUP2, null, 1)]
    begin = time.perf_counter()
    child = os.posix_spawn(program, [program, *arguments], environment, file_actions=actions)
    _, status = os.waitpid(child, 0)
    span = time.perf_counter() - begin
    if status != 0:
        sys.exit(f"{program} {arguments}: status {status}")
    return span


def measure(daemon: "subprocess.Popen[str]", socket: str, genomctl: str, count: int) -> None:
    """Measures and prints."""
    assert daemon.stderr is not None
    for line in daemon.stderr:
        if "ready on" in line:
            break
    plain = {"GENOMD_SOCKET": socket}
    shell = {**plain, "GENOMCTL_COMPLETE": "bash", "_CLAP_COMPLETE_INDEX": "3"}
    cases = [
        ("/bin/true", "/bin/true", [], plain),
        ("list", genomctl, ["list"], plain),
        ("completion", genomctl, ["--", "genomctl", "call", "demo", "set"], shell),
        ("call", genomctl, ["call", "demo", "get_speed"], plain),
    ]
    null = os.open(os.devnull, os.O_WRONLY)
    print(f"{count} runs      p50       p99   longest")
    for name, program, arguments, environment in cases:
        spans = sorted(run(program, arguments, environment, null) for _ in range(count))
        chosen = (spans[count // 2], spans[count * 99 // 100], spans[-1])
        print(f"{name:<12}" + "".join(f"{span * 1e3:7.2f} ms" for span in chosen))


def main() -> None:
    directory, library = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 10_000
    genomd, genomctl = (os.path.join(directory, name) for name in ("genomd", "genomctl"))
    with tempfile.TemporaryDirectory() as scratch:
        socket = os.path.join(scratch, "genomd.sock")
        daemon = subprocess.Popen(
            [genomd, "--socket", socket, library], stderr=subprocess.PIPE, text=True
        )
        try:
            measure(daemon, socket, genomctl, count)
        finally:
            daemon.terminate()
            daemon.wait()


if __name__ == "__main__":
    main()
