"""Ports of components in cells of a daemon that is a part of the program."""

import contextlib
import math
import os
import resource
import signal
import tempfile
import unittest

import genom

from .test_embedded import DEMO, MISSION, Case, ended, run_of
from .test_embedded_files import files

DESCRIPTION = """component arm {
  lang "python";
  typedef long ticks_t;
  enum way { FAR, NEAR };
  union either switch (way) { case FAR: double at; case NEAR: long of; };
  struct told { double from; double x[2]; sequence<long, 3> path; way which; optional<double> maybe; either one; };
  ids { long n; };
  port out ticks_t ticks;
  port in told asked;
  port out told echo;
  task main {
    period 10 ms;
    codel<start> arm_tick(inout n, out ticks, in asked, out echo) yield pause::start;
    codel<stop> arm_end() yield ether;
  };
};
"""

SCRIPT = """
def arm_tick(n, ticks, asked, echo):
    n.value += 1
    ticks.write(n.value)
    if asked.latest() is not None:
        echo.write(asked.data)
    return "pause::start"


def arm_end():
    return "ether"
"""


@contextlib.contextmanager
def arm():
    """The description of a component with codels in Python, which runs in a cell."""
    with tempfile.TemporaryDirectory() as place:
        for name, text in (("arm.gen", DESCRIPTION), ("arm.py", SCRIPT)):
            with open(os.path.join(place, name), "w", encoding="utf-8") as file:
                file.write(text)
        yield os.path.join(place, "arm.gen")


class Cells(Case):
    def process_of(self, d, cell):
        return d._cell(cell)["pid"]

    def test_their_ports_are_shared_as_those_of_the_daemon(self):
        with arm() as description, genom.Daemon() as d:
            loaded = d.load(description)
            before = loaded.ticks.read() or 0
            for _ in range(10):
                d.step(0.01)
            self.assertEqual(loaded.ticks.read(), before + 10)
            ticks, asked, echo = d.port("arm/ticks"), d.port("arm/asked"), d.port("arm/echo")
            self.assertEqual((ticks.data, ticks.count, echo.read()), (before + 10, before + 10, None))
            asked.data.from_, asked.data.x = math.inf, [1.5, math.nan]
            asked.data.path.append(7)
            asked.data.which = "NEAR"
            asked.data.one.d = "NEAR"
            asked.data.one.of = 5
            asked.write()
            d.step(0.01)
            self.assertEqual(ticks.data, before + 11)
            told = echo.data
            self.assertEqual((told.from_, told.x[0], list(told.path), told.maybe), (math.inf, 1.5, [7], None))
            self.assertTrue(math.isnan(told.x[1]) and told.which.name == "NEAR")
            self.assertEqual((told.one.d.name, told.one.of), ("NEAR", 5))
            asked.data.maybe = 2.5
            d.step(0.01)
            self.assertIsNone(told.maybe, "it was not written")
            asked.write()
            d.step(0.01)
            self.assertEqual((told.maybe, echo.count), (2.5, 3))
            with self.refused(genom.RefusalError, "no_such_port", "tick"):
                d.port("arm/tick")
            asked.close()
            d.unload(loaded)
            d.step(0.01)
            with self.refused(genom.GenoMError, "ended", "arm/ticks is not there"):
                ticks.data
            used = [name for name in os.listdir("/dev/shm") if name.startswith(d._name)]
            self.assertTrue(used, "ports of cells are in shared memory")
        left = [name for name in os.listdir("/dev/shm") if name.startswith(d._name)]
        self.assertEqual(left, [])

    def test_a_loop_sees_the_same_wherever_the_component_runs(self):
        in_a_cell = run_of(0.5, cell="arm")
        self.assertEqual(in_a_cell, run_of(0.5, cell="arm"))
        self.assertEqual(in_a_cell, run_of(0.5))
        self.assertGreater(len(in_a_cell), 100)

    def test_a_value_that_is_none_is_refused_once_and_time_stays_in_all_processes(self):
        with arm() as description, genom.Daemon() as d:
            d.load(description)
            demos = [d.load(DEMO, name=f"demo_{cell}", cell=cell) for cell in ("aft", "bow")]
            gains = [d.port(demo.parameter) for demo in demos]
            asked, ticks = d.port("arm/asked"), d.port("arm/ticks")
            d.step(0.01)
            count = ticks.count
            for gain in gains:
                gain.write(0.5)
            asked.data.path.append(7)
            # More elements than the sequence holds, as a stray pointer might leave it.
            asked._memory[64:] = b"\xff" * (len(asked._memory) - 64)
            asked.write()
            with self.refused(genom.InputError, "bad_input", "arm/asked"):
                d.step(0.01)
            self.assertEqual([clock(d, cell) for cell in ("aft", "arm", "bow")], [10_000_000] * 3)
            d.step(0.01)
            self.assertEqual(ticks.count, count + 1)
            # Published with the value that was one: it is not lost by the refusal.
            reads = [demo.parameter.connected() for demo in demos]
            self.assertEqual(reads, ["demo_aft/parameter", "demo_bow/parameter"])

    def test_a_cell_that_dies_between_steps_is_waited_for_and_has_the_same_memory(self):
        with arm() as description, genom.Daemon() as d:
            d.load(description)
            asked, ticks, echo = d.port("arm/asked"), d.port("arm/ticks"), d.port("arm/echo")
            seen = ticks.data, echo.data
            for _ in range(20):
                d.step(0.01)
            self.assertGreaterEqual(ticks.data, 20)
            asked.data.from_ = 1.0
            asked.write()
            process = self.process_of(d, "arm")
            os.kill(process, signal.SIGKILL)
            self.assertTrue(ended(process))
            # What was written before the step is published by it, in the next process.
            d.step(0.01)
            self.assertNotEqual(self.process_of(d, "arm"), process)
            self.assertLess(ticks.data, 10)
            self.assertEqual((echo.data.from_, echo.count), (1.0, 1))
            self.assertIs(seen[1], echo.data)
            # Not again: it was published.
            d.step(0.01)
            d.kill("arm")
            d.step(0.01)
            self.assertEqual(echo.data.from_, 1.0, "codels have written nothing since")
            asked.write()
            d.step(0.01)
            self.assertEqual(echo.count, 1)

    def test_a_cell_that_failed_has_no_ports_until_it_is_started_again(self):
        with genom.Daemon(options=["--set", "cells.restart_most=1"]) as d:
            demo, other = d.load(DEMO, cell="arm"), d.load(DEMO, name="other")
            position, theirs = d.port(demo.position), d.port(other.position)
            d.step(0.01)
            while d._cell("arm")["state"] != "failed":
                process = self.process_of(d, "arm")
                if process is not None:
                    os.kill(process, signal.SIGKILL)
                    self.assertTrue(ended(process))
                    d.step(0.01)
            d.step(0.01)
            with self.refused(genom.GenoMError, "ended", "demo/position is not there"):
                position.data
            self.assertGreater(theirs.count, 0)
            d._transport.request("POST", "/cells/arm/restart")
            d.step(0.01)
            self.assertGreater(position.count, 0)

    def test_a_component_that_is_reloaded_or_moves_keeps_its_memory(self):
        with arm() as description, genom.Daemon() as d:
            loaded = d.load(description)
            ticks = d.port("arm/ticks")
            d.step(0.01)
            count = ticks.count
            script = os.path.join(os.path.dirname(description), "arm.py")
            with open(script, "w", encoding="utf-8") as file:
                file.write(SCRIPT.replace("n.value += 1", "n.value += 100"))
            loaded.reload()
            before = ticks.data
            d.step(0.01)
            self.assertEqual(ticks.data, before + 100)
            self.assertGreater(ticks.count, count)

            demo = d.load(DEMO, cell="aft")
            gain, position = d.port("demo/parameter"), d.port("demo/position")
            for cell in (None, "bow", "aft", None):
                gain.write(0.5)
                d.step(0.01)
                self.assertEqual(demo.parameter.connected(), "demo/parameter")
                demo.unload()
                # With the component or without it.
                d.step(0.01)
                with self.refused(genom.GenoMError, "ended", "demo/parameter is not there"):
                    gain.write(0.25)
                demo = d.load(DEMO, cell=cell)
                d.step(0.01)
                self.assertGreater(position.count, 0)
            # Another component of that name has no such port.
            demo.unload()
            d.load(MISSION, name="demo", cell="aft")
            d.step(0.01)
            with self.refused(genom.GenoMError, "ended", "demo/parameter is not there"):
                gain.write(0.25)


def clock(d, cell):
    """The time of a cell's clock."""
    client = genom.connect(socket=d._cell(cell)["socket"])
    try:
        return client._transport.request("GET", "/clock")["now"]
    finally:
        client.disconnect()


class Files(Case):
    def setUp(self):
        super().setUp()
        limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, limits)
        resource.setrlimit(resource.RLIMIT_NOFILE, (limits[1], limits[1]))

    def test_a_port_takes_one_file_of_each_process_and_gives_it_back(self):
        with genom.Daemon() as d:
            demo = d.load(DEMO, cell="arm")
            d.step(0.005)
            processes = [d.pid, d._cell("arm")["pid"]]
            for count in (1, 50, 500):
                ports = [d.port(demo.position) for _ in range(count)]
                d.step(0.005)
                self.assertEqual({port.count for port in ports}, {ports[0].count})
                self.assertEqual([files(process)[1] for process in processes], [count] * 2)
                for port in ports:
                    port.close()
                self.assertEqual([files(process)[1] for process in processes], [0, 0])
            # The next process of the cell has them, too, and the one before leaves nothing.
            ports = [d.port(demo.position) for _ in range(500)]
            d.kill("arm")
            d.step(0.005)
            self.assertEqual(files(d._cell("arm")["pid"])[1], 500)
            for port in ports:
                port.close()
            self.assertEqual([files(pid)[1] for pid in (d.pid, d._cell("arm")["pid"])], [0, 0])


if __name__ == "__main__":
    unittest.main()
