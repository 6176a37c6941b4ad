"""Shared by the tests: a component for each test, a watchdog, and other processes."""

import contextlib
import faulthandler
import glob
import itertools
import multiprocessing
import os
import signal
import sys
import threading
import time
import unittest

import genom

# Only a hanging test takes this many seconds; the stacks are then printed.
WATCHDOG = 50.0
_numbers = itertools.count()


def echo(component, other, count):
    """Runs in another process: copies what arrives on one port to another."""
    g = genom.connect()
    commands = g.load(component).parameter.subscribe(fast=True)
    states = g.load(other).parameter.publisher(fast=True)
    states(-1.0)
    while count > 0:
        value = commands.wait(WATCHDOG)
        # Skip what was published before this process started.
        if value >= 0.0:
            states(value)
            count -= 1


@contextlib.contextmanager
def process(work, *arguments):
    """Starts another process, and checks that it ends well."""
    context = multiprocessing.get_context("spawn")
    peer = context.Process(target=work, args=arguments, daemon=True)
    peer.start()
    yield
    peer.join(WATCHDOG)
    assert peer.exitcode == 0, peer.exitcode


def is_stopped(stat):
    """Whether a thread has been stopped by SIGSTOP, according to the kernel."""
    with open(stat, encoding="utf-8") as file:
        return file.read().rpartition(")")[2].split()[0] == "T"


def p50_p99(spans):
    """Median and 99th percentile in microseconds, as text."""
    spans = sorted(spans)
    return " / ".join(f"{spans[len(spans) * part // 100] * 1e6:.0f}" for part in (50, 99))


def tell(figure):
    """Prints a line for whoever runs the tests."""
    print(figure, file=sys.stderr)


class DemoCase(unittest.TestCase):
    """A test with a demo component of its own."""

    def setUp(self):
        faulthandler.dump_traceback_later(WATCHDOG, exit=True)
        self.addCleanup(faulthandler.cancel_dump_traceback_later)
        self.g = genom.connect()
        self.addCleanup(self.g.disconnect)
        self.demo = self.load()

    def load(self):
        name = f"demo{next(_numbers)}"
        demo = self.g.load(os.environ["GENOM_DEMO"], "-i", name)
        self.addCleanup(genom.Component.unload, demo)
        return demo

    @contextlib.contextmanager
    def echoed(self, backend, count):
        """Yields a function that sends a value directly to another process and waits for it to come
        back, at most that many times.
        """
        other = self.load()
        commands = self.demo.parameter.publisher(fast=True)
        commands(-1.0)
        other.parameter.connect(other.parameter.address(), backend=backend)
        states = other.parameter.subscribe(fast=True)

        def exchange(value):
            commands(value)
            self.assertEqual(states.wait(WATCHDOG), value)

        with process(echo, self.demo.name, other.name, count):
            self.assertEqual(states.wait(WATCHDOG), -1.0)
            yield exchange

    def feed(self, publisher):
        """Moves the demo by values of a publisher at its `parameter`, the last of which is 2."""
        publisher(0.0)
        activity = self.demo.goto(goal=0.1, ack=True)
        with self.demo.parameter.subscribe(fast=False) as gain:
            self.assertEqual(gain.wait(WATCHDOG), 0.0)
        self.assertEqual(activity.status, "sent")
        publisher(2.0)
        activity.wait(WATCHDOG)

    def burst(self, publisher, count, stopped=False):
        """Checks that codels get the newest value of a burst; with `stopped`, the daemon is stopped
        meanwhile.
        """
        publisher(0.0)
        activity = self.demo.goto(goal=1.0, ack=True)
        values = [number * 1e-12 for number in range(count + 1)]
        with self.demo.parameter.subscribe(fast=False) as gain:
            self.assertEqual(gain.wait(WATCHDOG), 0.0)
            burst = threading.Thread(target=lambda: [publisher(value) for value in values])
            with self.asleep() if stopped else contextlib.nullcontext():
                burst.start()
                # Until it is done or blocked; what a network buffers is limited.
                burst.join(1.0)
            while gain.wait(WATCHDOG) != values[-1]:
                pass
            burst.join(WATCHDOG)
        activity.abort()

    @contextlib.contextmanager
    def asleep(self):
        """Stops the daemon's process meanwhile, as by Ctrl-Z."""
        process = self.g.about()["pid"]
        os.kill(process, signal.SIGSTOP)
        try:
            # Its threads stop one after the other.
            while not all(map(is_stopped, glob.glob(f"/proc/{process}/task/*/stat"))):
                time.sleep(0.001)
            yield
        finally:
            os.kill(process, signal.SIGCONT)

    def moved(self, positions):
        """The positions that a subscription receives of a motion at 2 m/s from 0 to 0.2."""
        self.demo.set_speed(2.0)
        # The value written before.
        self.assertEqual(positions.wait(WATCHDOG), {"position": 0.0, "velocity": 0.0})
        activity = self.demo.goto(0.2, ack=True)
        seen = [positions.wait(WATCHDOG)]
        while seen[-1] != {"position": 0.2, "velocity": 0.0}:
            seen.append(positions.wait(WATCHDOG))
        activity.wait(WATCHDOG)
        return [one["position"] for one in seen]

    def start_slow(self):
        """Starts a motion that does not end in time by itself."""
        with self.g.events() as events:
            activity = self.demo.goto(goal=10.0, ack=True)
            for event in events:
                if event.get("activity") == activity.number and event.get("state") == "main":
                    return activity
        self.fail("the stream of events ended")
