#!/usr/bin/env python3
"""Many components of the demo on ROS 2: start, stop, memory, threads, open files, processor time.

    cargo build --release -p genomd
    tests/benches/ros2_many.py target/release/genomd target/components/demo/demo.so dds 500 \\
        --cells 10 --own --heard PYTHON

Tasks are of 10 Hz. With `--cells N` components are spread over N cells; with `--own` there is no
gateway, and each process opens the middleware itself; with `--bare` nodes have neither parameters nor
descriptions of types; with `--moving` every component moves, and writes at each tick. `--heard PYTHON`
reads, with an interpreter that has cyclonedds (dds) or eclipse-zenoh (zenoh), the topics of some of
the components and what comes on /diagnostics, in `ros2_many_peer.py`.
"""

import argparse
import collections
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))


def configuration(given, scratch):
    zenoh = f'zenoh = {{ connect = ["unixsock-stream/{scratch}/router"] }}\n'
    lines = [
        'backend = "ros2"\n',
        "[cells]\nready_timeout = 900.0\nalive_timeout = 120.0\n",
        "[gateways]\nof = []\n" if given.own else "",
        f'[backends.ros2]\nrmw = "{given.rmw}"\ndomain = {given.domain}\n',
        zenoh if given.rmw == "zenoh" else "",
        "parameters = false\ntype_descriptions = false\n" if given.bare else "",
        f'[backends.shm]\nprefix = "many{os.getpid()}_"\nroot = "{scratch}/shm"\n',
    ]
    for number in range(given.number):
        lines.append(f'[[component]]\nlibrary = "{given.library}"\nname = "d{number}"\n')
        if given.cells:
            lines.append(f'cell = "c{number % given.cells}"\n')
        lines.append("[component.tasks.main]\nperiod_ms = 100.0\n")
        if given.moving:
            lines.append("[component.attributes]\nset_speed = { velocity = 0.001 }\n")
    for number in range(given.number if given.moving else 0):
        lines.append(f'[[activity]]\ncomponent = "d{number}"\nservice = "goto"\n')
        lines.append("inputs = { goal = 1.0 }\n")
    return "".join(lines)


def ask(path, what, patience=30):
    """The body of a reply of the daemon, or nothing."""
    try:
        with socket.socket(socket.AF_UNIX) as peer:
            peer.settimeout(patience)
            peer.connect(path)
            peer.sendall(f"GET {what} HTTP/1.0\r\nHost: genomd\r\n\r\n".encode())
            reply = b"".join(iter(lambda: peer.recv(1 << 16), b""))
        return json.loads(reply.split(b"\r\n\r\n", 1)[1])
    except (OSError, ValueError, IndexError):
        return None


def descendants(root):
    parents = collections.defaultdict(list)
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                with open(f"/proc/{name}/stat") as file:
                    parents[int(file.read().rsplit(")", 1)[1].split()[1])].append(int(name))
            except OSError:
                pass
    found, left = [], [root]
    while left:
        one = left.pop()
        found.append(one)
        left += parents[one]
    return found


def kind_of(process, daemon):
    if process == daemon:
        return "daemon"
    with open(f"/proc/{process}/cmdline") as file:
        return "gateway" if "gateway" in file.read() else "cells"


def spent(process):
    """Seconds that the threads of a process spent on processors."""
    total = 0
    for task in os.listdir(f"/proc/{process}/task"):
        try:
            with open(f"/proc/{process}/task/{task}/schedstat") as file:
                total += int(file.read().split()[0])
        except OSError:
            pass
    return total / 1e9


def held(process):
    """Proportional set size in MB, threads, open files."""
    with open(f"/proc/{process}/smaps_rollup") as file:
        pss = next(int(line.split()[1]) for line in file if line.startswith("Pss:"))
    threads = len(os.listdir(f"/proc/{process}/task"))
    return pss * 1024 / 1e6, threads, len(os.listdir(f"/proc/{process}/fd"))


def report(given, daemon):
    kinds = collections.defaultdict(list)
    for process in descendants(daemon.pid):
        kinds[kind_of(process, daemon.pid)].append(process)
    everyone = [process for all_ in kinds.values() for process in all_]
    begin, before = time.monotonic(), {process: spent(process) for process in everyone}
    time.sleep(given.seconds)
    after = {process: spent(process) for process in everyone}
    span = time.monotonic() - begin
    for kind, all_ in sorted(kinds.items()):
        sizes = [held(process) for process in all_]
        used = sum(after[process] - before[process] for process in all_) / span
        print(
            f"  {kind:8} {len(all_):4} processes, {sum(size[0] for size in sizes):7.0f} MB,"
            f" {sum(size[1] for size in sizes):6} threads,"
            f" {sum(size[2] for size in sizes):6} files (most {max(size[2] for size in sizes)}),"
            f" {used * 100:6.1f} % of a processor",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser()
    for name in ("genomd", "library", "rmw"):
        parser.add_argument(name)
    parser.add_argument("number", type=int)
    parser.add_argument("--cells", type=int, default=0)
    parser.add_argument("--domain", type=int, default=77)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--heard")
    for name in ("--own", "--bare", "--moving"):
        parser.add_argument(name, action="store_true")
    given = parser.parse_args()
    given.library = os.path.abspath(given.library)
    with tempfile.TemporaryDirectory(prefix="many") as scratch:
        config, path = f"{scratch}/genomd.toml", f"{scratch}/genomd.sock"
        with open(config, "w") as file:
            file.write(configuration(given, scratch))
        log = open(f"{scratch}/log", "w+")
        begin = time.monotonic()
        daemon = subprocess.Popen(
            [given.genomd, "--config", config, "--socket", path], stderr=log, stdout=log
        )
        ready = None
        while not (ready and ready.get("ready")) and daemon.poll() is None:
            ready = ask(path, "/ready?wait=60&deployed=true", 120)
            if not ready:
                time.sleep(0.05)
            if time.monotonic() - begin > 1200:
                break
        if daemon.poll() is not None:
            log.seek(0)
            sys.exit(f"{given.genomd} has ended by itself:\n{log.read()}")
        print(f"{sys.argv[3:]}\n  ready {ready} after {time.monotonic() - begin:.1f} s", flush=True)
        peer = None
        if given.heard:
            of = [str(given.domain), given.rmw, f"unixsock-stream/{scratch}/router"]
            few = [f"d{number}" for number in range(0, given.number, max(1, given.number // 7))]
            script = f"{HERE}/ros2_many_peer.py"
            peer = subprocess.Popen([given.heard, script, *of, *few], stdin=subprocess.PIPE)
        try:
            report(given, daemon)
            if peer:
                peer.communicate()
        finally:
            if peer:
                peer.kill()
            begin = time.monotonic()
            daemon.send_signal(signal.SIGTERM)
            status = daemon.wait()
        print(f"  ended with {status} after {time.monotonic() - begin:.1f} s", flush=True)
        log.seek(0)
        lines = collections.Counter(
            line.split("]")[-1].strip()[:150] for line in log if "WARN" in line or "ERROR" in line
        )
        for line, count in lines.most_common(8):
            print(f"  {count} x {line}")


if __name__ == "__main__":
    main()
