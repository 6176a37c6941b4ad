"""A daemon that is a part of the program, which steps its clock."""

import contextlib
import ctypes
import faulthandler
import mmap
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest

import genom

from .support import WATCHDOG

DEMO = os.environ["GENOM_DEMO"]
MISSION = os.environ["GENOM_MISSION"]
BLOCKS = os.environ["GENOM_BLOCKS"]
SIGHTS = os.path.join(os.environ["GENOM_FIXTURES"], "sights.gen")
TEXTS = os.path.join(os.environ["GENOM_FIXTURES"], "texts.gen")


def ended(process):
    """Waits for the end of a process, of which this one need not be the parent."""
    try:
        file = os.pidfd_open(process)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([file], [], [], WATCHDOG)[0])
    finally:
        os.close(file)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def run_of(gain_later, cell=None):
    """What the axis does on its way to 1 m, if the program sets this gain when it is at 0.5 m."""
    with genom.Daemon() as d:
        demo = d.load(DEMO, cell=cell)
        gain, position = d.port(demo.parameter), d.port(demo.position)
        gain.write(1.0)
        moves = demo.goto(1.0, ack=True)
        seen = []
        while moves.status == genom.Status.SENT:
            d.step(0.005)
            seen.append((position.data.position, position.data.velocity, position.count))
            gain.write(1.0 if seen[-1][0] < 0.5 else gain_later)
        assert moves.wait(WATCHDOG) == {}
        assert seen[-1][:2] == (1.0, 0.0)
        return seen


class Case(unittest.TestCase):
    def setUp(self):
        faulthandler.dump_traceback_later(WATCHDOG, exit=True)
        self.addCleanup(faulthandler.cancel_dump_traceback_later)

    @contextlib.contextmanager
    def refused(self, kind, name, *told):
        with self.assertRaises(kind) as caught:
            yield
        self.assertEqual(caught.exception.name, name)
        for one in told:
            self.assertIn(one, str(caught.exception))


class Steps(Case):
    def test_a_loop_with_a_component_runs_the_same_twice(self):
        first = run_of(0.5)
        self.assertEqual(first, run_of(0.5))
        # The axis hears what the program says of what it sees.
        self.assertGreater(len(first), len(run_of(1.0)))

    def test_it_needs_neither_the_main_thread_nor_standard_streams(self):
        seen = []

        def notebook():
            with genom.Daemon() as d:
                d.load(DEMO)
                seen.append(d.step(0.1))

        streams, sys.stdout, sys.stderr = (sys.stdout, sys.stderr), None, None
        try:
            thread = threading.Thread(target=notebook)
            thread.start()
            thread.join(WATCHDOG)
        finally:
            sys.stdout, sys.stderr = streams
        self.assertEqual(seen, [0.1])

    def test_the_real_time_factor_is_what_was_stepped_by_the_time_that_passed(self):
        with genom.Daemon() as d:
            d.load(DEMO)
            self.assertEqual(d.real_time_factor, 0.0)
            before = time.perf_counter()
            d.step(0.005)
            begun = time.perf_counter()
            for _ in range(100):
                d.step(0.005)
            asked = time.perf_counter()
            factor = d.real_time_factor
            told = time.perf_counter()
        # It counts from some time within the first step to some time within the question.
        stepped = 101 * 0.005
        self.assertLessEqual(stepped / (told - before), factor * (1 + 1e-9))
        self.assertLessEqual(factor, stepped / (asked - begun) * (1 + 1e-9))

    def test_fifty_components_are_stepped_together(self):
        with genom.Daemon() as d:
            names = [f"demo{number}" for number in range(50)]
            demos = [d.load(DEMO, name=name) for name in names]
            positions = [d.port(f"{name}/position") for name in names]
            gains = [d.port(demo.parameter) for demo in demos]
            for demo, gain, rank in zip(demos, gains, range(50)):
                demo.set_speed(1.0)
                demo.goto(10.0, ack=True)
                gain.write(rank / 500)
            for _ in range(20):
                d.step(0.005)
            seen = [position.data.position for position in positions]
            self.assertEqual(seen, sorted(seen))
            self.assertEqual(len(set(seen)), 50)

    def test_daemons_of_one_program_do_not_disturb_each_other(self):
        with contextlib.ExitStack() as all_of_them:
            daemons = [all_of_them.enter_context(genom.Daemon()) for _ in range(8)]
            demos = [d.load(DEMO) for d in daemons]
            gains = [d.port(demo.parameter) for d, demo in zip(daemons, demos)]
            positions = [d.port(demo.position) for d, demo in zip(daemons, demos)]
            for rank, (demo, gain) in enumerate(zip(demos, gains)):
                demo.set_speed(1.0)
                demo.goto(10.0, ack=True)
                gain.write(rank / 80)
            for _ in range(20):
                for rank, d in enumerate(daemons):
                    d.step(0.005 * (rank % 2))
            moved = [position.data.position for position in positions]
            self.assertEqual(moved[0::2], [0.0] * 4, "their time stood still")
            self.assertEqual(moved[1::2], sorted(moved[1::2]))
            self.assertEqual(len(set(moved[1::2])), 4)


class Ports(Case):
    def test_views_stay_where_they_are_while_values_change(self):
        with genom.Daemon() as d:
            d.load(SIGHTS)
            wave = d.port("sights/wave")
            d.step(0.001)
            value, row = wave.data, wave.data.row
            counts = []
            for _ in range(5):
                d.step(0.001)
                counts.append(value.count)
                self.assertEqual(value.count, wave.count)
            self.assertEqual(counts, list(range(counts[0], counts[0] + 5)))
            self.assertEqual(list(row), [1.0, 2.0, 3.0])
            self.assertIs(wave.read(), value)
            # Codels write it, nobody else.
            with self.assertRaises((TypeError, AttributeError)):
                value.count = 1
            with self.assertRaises((TypeError, ValueError)):
                row[0] = 5.0
        # Views outlive the daemon.
        self.assertEqual((value.count, list(row)), (counts[-1], [1.0, 2.0, 3.0]))

    def test_what_is_written_in_place_is_published_with_the_next_step(self):
        with genom.Daemon() as d:
            sights = d.load(SIGHTS)
            picture = d.port(sights.picture)
            image = picture.data
            image.width, image.height, image.encoding = 2, 1, "mono8"
            image.data.resize(2)
            pixels = image.data.array
            pixels[0], pixels[1] = 7, 9
            d.step(0.001)
            self.assertIsNone(sights.picture.read(), "nothing was written yet")
            picture.write()
            d.step(0.001)
            seen = sights.picture.read()
            self.assertEqual((seen["width"], seen["encoding"], seen["data"]), (2, "mono8", [7, 9]))
            pixels[1] = 10
            picture.write()
            d.step(0.001)
            self.assertEqual(sights.picture.read()["data"], [7, 10])

    def test_a_value_that_is_none_is_refused_once_and_time_stays(self):
        with genom.Daemon() as d:
            sights = d.load(SIGHTS)
            photo = d.port(sights.photo)
            photo.data = {"format": "png"}
            photo.write()
            before = d.step(0.001)
            # More elements than the sequence holds, as a stray pointer might leave it.
            ctypes.memset(photo._at, 0xFF, photo._kind.size)
            photo.write()
            with self.refused(genom.InputError, "bad_input", "sights/photo"):
                d.step(0.001)
            self.assertEqual(d.step(0.0), before)
            self.assertEqual(sights.photo.read()["format"], "png")
            with self.assertRaises(ValueError):
                photo.data = {"format": "x" * 40}

    def test_a_port_whose_component_is_gone_says_so_and_comes_back_with_it(self):
        with genom.Daemon() as d:
            demo = d.load(DEMO)
            gain, position = d.port(demo.parameter), d.port(demo.position)
            gain.write(1.0)
            d.step(0.01)
            demo.unload()
            d.step(0.01)
            with self.refused(genom.GenoMError, "ended", "demo/position"):
                position.read()
            gain._written.value += 1
            with self.refused(genom.RefusalError, "no_such_port", "demo/parameter"):
                d.step(0.01)
            demo = d.load(DEMO)
            d.step(0.01)
            gain.write(0.25)
            d.step(0.01)
            self.assertEqual(demo.parameter.connected(), "demo/parameter")
            demo.goto(1.0, ack=True)
            for _ in range(10):
                d.step(0.005)
            self.assertGreater(position.data.position, 0.0)

    def test_a_port_that_reads_another_one_is_not_taken_from_it(self):
        with genom.Daemon() as d:
            demo, _ = d.load(DEMO), d.load(MISSION)
            gain = d.port(demo.parameter)
            demo.parameter.connect("mission/gain")
            gain.write(1.0)
            with self.refused(genom.RefusalError, "connected", "mission/gain", "demo/parameter"):
                d.step(0.01)
            demo.parameter.disconnect()
            gain.write(0.5)
            d.step(0.01)
            self.assertEqual(demo.parameter.connected(), "demo/parameter")

    def test_what_cannot_be_shared_is_told(self):
        with genom.Daemon() as d:
            d.load(DEMO)
            d.load(TEXTS)
            for address, kind, name, told in [
                ("demo/positon", genom.RefusalError, "no_such_port", "position"),
                ("dmo/position", genom.RefusalError, "no_such_component", "demo"),
                ("demo", genom.InputError, "bad_input", "demo"),
                ("", genom.InputError, "bad_input", ""),
                ("demo/position/left", genom.InputError, "bad_input", "single"),
                ("texts/heard", genom.InputError, "bad_input", "not of one size"),
                ("x" * 5000, genom.RefusalError, "malformed", "4096"),
            ]:
                with self.refused(kind, name, told):
                    d.port(address)
            ports = [d.port("demo/position") for _ in range(100)]
            for port in ports:
                port.close()
            with self.refused(genom.GenoMError, "ended", "closed"):
                ports[0].read()

    def test_a_thousand_ports_are_the_most(self):
        with genom.Daemon() as d:
            d.load(DEMO)
            numbers = []
            for _ in range(1024):
                number, _, _, _, file = d._door.open("demo/position")
                os.close(file)
                numbers.append(number)
            with self.refused(genom.RefusalError, "too_many_streams", "1024"):
                d.port("demo/position")
            d._door.close_port(numbers[0])
            d.port("demo/position").close()


class Wrong(Case):
    def test_steps_that_are_none_are_refused(self):
        with genom.Daemon() as d:
            for seconds in (-1.0, 1e30, float("nan")):
                with self.assertRaises(ValueError):
                    d.step(seconds)
            with self.refused(genom.InputError, "bad_input", "3600 s"):
                d.step(3601.0)
            self.assertEqual(d.step(0.5), 0.5)

    def test_messages_that_are_none_are_answered_and_told_once(self):
        with genom.Daemon() as d:
            d.load(DEMO)
            end = d._door._socket
            head = struct.pack("=I", 5)
            for message in (
                [b"x", b"12345", head, head + b"\xff\xff\xff\xff", head + struct.pack("=I", 1) + b"123"]
                + [head + struct.pack("=II", 0, 0), head + struct.pack("=I", 2) + b"\xff\xfe"]
                + [head + struct.pack("=I", 3), head + struct.pack("=II", 3, 77), os.urandom(4000)]
                + [b"\0" * 4097, b"\xff" * 60000]
            ):
                end.send(message)
                number, status = struct.unpack_from("=II", end.recv(65536))
                known = struct.unpack_from("=I", message)[0] if len(message) >= 4 else 0
                self.assertEqual((number, status), (known, 1), message[:20])
            # A reply that nobody waits for any more, as after Ctrl-C.
            end.send(struct.pack("=IIQ", 0xFFFFFF, 1, 1_000_000_000))
            self.assertEqual(d.step(0.5), 1.5)
            with open(d.log, encoding="utf-8") as log:
                self.assertEqual(log.read().count("a request of the program is none"), 1)

    def test_whatever_is_on_the_slate_is_answered_and_time_stays(self):
        with genom.Daemon() as d:
            d.load(DEMO)
            end = d._door._socket
            # From now on this is the one that the daemon looks at.
            d._door._slate = None
            end.send(struct.pack("=II", 1, 6))
            reply, (file,), _, _ = socket.recv_fds(end, 64, 1)
            self.assertEqual(reply, struct.pack("=II", 1, 0))
            with open(file, "r+b") as opened, mmap.mmap(file, 192) as slate:
                with self.assertRaises(OSError):
                    opened.truncate(64)
                most = 2**32 - 1
                for number, verb, argument in [(5, 99, 1), (6, 1, 2**64 - 1), (7, 0, 0), (most, most, 5)]:
                    slate[:16] = struct.pack("=IIQ", number, verb, argument)
                    # Told once.
                    for there in (True, False):
                        end.send(struct.pack("=III", 8, 7, number))
                        reply = end.recv(4096)
                        self.assertEqual(struct.unpack_from("=II", reply), (8, 1))
                        self.assertEqual(b"the last request on the slate is not" in reply, not there)
                    self.assertEqual(struct.unpack_from("=II", slate, 64), (number, 1))
                for _ in range(50):
                    slate[:] = os.urandom(8) + b"\xff" * 184
                self.assertEqual(d.step(0.5), 0.5)

    def test_a_socket_with_a_name_embeds_no_daemon(self):
        # Others could have connected to it.
        with tempfile.TemporaryDirectory() as place, socket.socket(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        ) as named, socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as caller:
            named.bind(os.path.join(place, "named"))
            named.listen()
            caller.connect(named.getsockname())
            accepted, _ = named.accept()
            with accepted:
                for end in (named, caller, accepted):
                    refused = subprocess.run(
                        [os.environ["GENOMD"], "--embedded", "--socket", os.path.join(place, "genomd.sock")],
                        stdin=end.fileno(), stderr=subprocess.PIPE, text=True, timeout=WATCHDOG,
                    )
                    self.assertEqual(refused.returncode, 2, refused.stderr)
                    self.assertIn("pair of sockets", refused.stderr)

    def test_a_socket_that_is_closed_during_a_step_ends_the_daemon(self):
        with tempfile.TemporaryDirectory() as place:
            let_go = os.path.join(place, "go")
            with genom.Daemon() as d:
                blocks = d.load(BLOCKS)
                blocks.hang_until(let_go, ack=True)
                # Both are asked in one go, and nobody is there for the replies.
                head = struct.Struct("=IIQ")
                d._door._socket.send(head.pack(1, 1, 10_000_000))
                d._door._socket.send(head.pack(2, 1, 10_000_000))
                d._door.close()
                with open(let_go, "wb"):
                    pass
                self.assertEqual(d._process.wait(WATCHDOG), 0)

    def test_ctrl_c_ends_the_wait_for_a_codel_and_the_daemon_goes_on(self):
        # Who is started in the background of a shell ignores the signal at first.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        options = ["--set", "stuck_after=1"]
        with tempfile.TemporaryDirectory() as place, genom.Daemon(options=options) as d:
            let_go = os.path.join(place, "go")
            blocks = d.load(BLOCKS)
            blocks.hang_until(let_go, ack=True)
            main = threading.main_thread().ident

            def interrupt():
                while "codel blocks_hang_until of" not in read(d.log):
                    os.sched_yield()
                signal.pthread_kill(main, signal.SIGINT)

            interrupting = threading.Thread(target=interrupt)
            interrupting.start()
            with self.assertRaises(KeyboardInterrupt):
                d.step(0.01)
            interrupting.join(WATCHDOG)
            # It was not the codel that ended the step.
            self.assertNotIn("returned after", read(d.log))
            with open(let_go, "wb"):
                pass
            # The step that nobody waited for is done, then the next one.
            self.assertEqual(d.step(0.01), 0.02)

    def test_a_codel_that_does_not_return_does_not_keep_the_daemon(self):
        with genom.Daemon(options=["--set", "stop_timeout=1"]) as d:
            blocks = d.load(BLOCKS)
            blocks.hang_steady(ack=True)
            stepping = threading.Thread(target=lambda: self.assertRaises(genom.DaemonError, d.step, 0.01))
            stepping.start()
            while "blocks_hang_steady" not in read(d.log):
                os.sched_yield()
            d._door._socket.shutdown(socket.SHUT_RDWR)
            stepping.join(WATCHDOG)
            # 4: a codel that did not return was left behind.
            self.assertEqual(d._process.wait(WATCHDOG), 4)

    def test_a_daemon_that_dies_is_an_exception(self):
        with genom.Daemon() as d:
            demo = d.load(DEMO)
            position = d.port(demo.position)
            os.kill(d.pid, signal.SIGKILL)
            for _ in range(2):
                with self.refused(genom.DaemonError, "ended", "signal 9 (SIGKILL)"):
                    d.step(0.01)
            with self.refused(genom.DaemonError, "ended", "SIGKILL"):
                d.port("demo/position")
            position.close()
        with self.refused(genom.DaemonError, "ended", "closed"):
            d.step(0.01)

    def test_a_daemon_ends_with_its_block_whatever_happens_there(self):
        with self.assertRaises(ZeroDivisionError):
            with genom.Daemon() as d:
                d.load(DEMO)
                1 / 0
        self.assertIsNotNone(d._process.poll())
        self.assertEqual(d._process.returncode, 0)
        self.assertFalse(os.path.exists(d.log))
        d.close()

    def test_a_daemon_ends_with_its_program_however_that_ends(self):
        # Nobody removes the files of a daemon whose program was killed.
        for end, left in (
            ("os._exit(0)", True),
            ("os.kill(os.getpid(), 9)", True),
            ("sys.exit(0)", False),
            ("raise ValueError", False),
        ):
            script = textwrap.dedent(f"""
                import genom, os, sys
                d = genom.Daemon()
                d.load({DEMO!r})
                print(d.pid, d.log, flush=True)
                d.step(0.01)
                {end}
            """)
            told = subprocess.run(
                [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                text=True, timeout=WATCHDOG,
            ).stdout
            process, log = told.split()
            self.assertTrue(ended(int(process)), end)
            self.assertEqual(os.path.exists(log), left, end)
            if left:
                with open(log, encoding="utf-8") as file:
                    self.assertIn("has closed its socket", file.read())

    def test_a_daemon_that_does_not_start_says_why(self):
        for options, told in [
            (["--nonsense"], "exit status 2"),
            (["--set", "max_activities=0"], "max_activities"),
            (["/nowhere/demo.so"], "/nowhere/demo.so"),
        ]:
            with self.refused(genom.DaemonError, "not_started", told):
                genom.Daemon(options=options)
        with self.refused(genom.DaemonError, "not_started", "/nowhere/genomd"):
            genom.Daemon(program="/nowhere/genomd")
        with self.assertRaises(ValueError):
            genom.Daemon(clock="monotonic")


if __name__ == "__main__":
    unittest.main()
