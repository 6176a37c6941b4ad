"""Ports directly over zenoh, with the package eclipse-zenoh."""

import contextlib
import json
import statistics
import struct
import tempfile
import time
import unittest

import genom

from .support import WATCHDOG, DemoCase, process, tell


def bare_session(mode, endpoint):
    import zenoh

    config = zenoh.Config()
    for key, value in (
        ("scouting/multicast/enabled", False),
        ("scouting/gossip/enabled", False),
        ("listen/endpoints", [endpoint] if mode == "listen" else []),
        ("connect/endpoints", [endpoint] if mode == "connect" else []),
    ):
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def bare_echo(endpoint, count):
    """The same as `echo`, with zenoh only."""
    with bare_session("connect", endpoint) as session:
        commands = session.declare_subscriber("command")
        states = session.declare_publisher("state")
        while count > 0:
            message = commands.recv().payload.to_bytes()
            states.put(message)
            count -= 1
        # Until the last sample was received.
        session.declare_subscriber("end").recv()


class Zenoh(DemoCase):
    def test_a_port_is_followed_sample_by_sample(self):
        with self.demo.position.subscribe(fast=True, depth=1000) as positions:
            self.assertTrue(positions.fast)
            seen = self.moved(positions)
            with self.assertRaises(TimeoutError):
                positions.wait(0.01)
        self.assertEqual(sorted(seen), seen)
        with self.assertRaises(genom.GenoMError):
            positions.wait(WATCHDOG)

    def test_a_fast_publisher_feeds_the_codels(self):
        with self.demo.parameter.publisher() as p:
            self.assertTrue(p.fast)
            self.feed(p)
            self.assertEqual(self.demo.parameter.read(), 2.0)
            with self.assertRaises(genom.InputError):
                p("fast")
            with self.assertRaises(genom.RefusalError) as caught:
                self.demo.parameter.publisher(fast=True)
            self.assertEqual(caught.exception.name, "taken")
        self.assertIsNone(self.demo.parameter.connected())

    def test_the_newest_value_of_a_burst_arrives_when_the_reader_was_held_up(self):
        with self.demo.parameter.publisher(fast=True) as p:
            self.burst(p, 50_000, stopped=True)

    def test_samples_go_to_another_process_and_come_back_in_order(self):
        blocks, size = 10, 300
        count = blocks * size

        def rate_of(exchange, values):
            begin = time.perf_counter()
            for value in values:
                exchange(float(value))
            return size / (time.perf_counter() - begin)

        # Alternating, so that both run under the same conditions.
        with self.bare(count) as bare, self.echoed("zenoh", count) as exchange:
            rates = []
            for begin in range(0, count, size):
                values = range(begin, begin + size)
                rates.append((rate_of(bare, values), rate_of(exchange, values)))
        bares, ours = zip(*rates)
        bare, ours = statistics.median(bares), statistics.median(ours)
        tell(f"round trips by zenoh alone: {bare:.0f}/s, at best {max(bares):.0f}/s")
        tell(f"round trips between two processes: {ours:.0f}/s, {ours / bare:.2f} x bare")

    @contextlib.contextmanager
    def bare(self, count):
        """The same as `echoed`, with zenoh only."""
        directory = tempfile.TemporaryDirectory()
        endpoint = f"unixsock-stream/{directory.name}/bare"
        with directory, bare_session("listen", endpoint) as session:
            commands = session.declare_publisher("command")
            states = session.declare_subscriber("state")
            end = session.declare_publisher("end")

            def exchange(value):
                commands.put(struct.pack("<d", value))
                self.assertEqual(states.recv().payload.to_bytes(), struct.pack("<d", value))

            def until_matching(publisher):
                while not publisher.matching_status.matching:
                    time.sleep(0.001)

            with process(bare_echo, endpoint, count):
                until_matching(commands)
                yield exchange
                until_matching(end)
                end.put(b"")


class Messages(unittest.TestCase):
    """Types that the demo does not have, in the form of the daemon's description."""

    def test_values_of_every_kind_go_in_and_come_out(self):
        from genom._cdr import Cdr

        cdr = Cdr({"types": [
            {"kind": "struct", "name": "::m::all", "members": [
                {"name": "count", "type": 1}, {"name": "gain", "type": 2},
                {"name": "text", "type": 3}, {"name": "list", "type": 4},
                {"name": "maybe", "type": 5}, {"name": "row", "type": 6},
                {"name": "either", "type": 7}, {"name": "mode", "type": 8}]},
            {"kind": "octet", "name": "octet"},
            {"kind": "double", "name": "double"},
            {"kind": "string", "name": "string<6>", "bound": 6},
            {"kind": "sequence", "name": "sequence<double>", "element": 2, "bound": None},
            {"kind": "optional", "name": "optional<double>", "element": 2},
            {"kind": "array", "name": "double[3]", "element": 2, "length": 3},
            {"kind": "union", "name": "::m::either", "discriminant": 8, "members": [
                {"name": "i", "type": 1, "labels": [0]},
                {"name": "d", "type": 2, "labels": [None]}]},
            {"kind": "enum", "name": "::m::mode", "enumerators": ["OFF", "ON"]},
        ]})
        zero = cdr.zero()
        self.assertEqual(cdr.decode(cdr.encode(zero)), zero)
        value = cdr.merge(zero, {
            "count": 3, "gain": 0.5, "text": "h\u00e9", "list": [1.0, 2.0], "maybe": 7.0,
            # Elements of an array may be given by index.
            "row": {"1": 4.0}, "either": {"d": "ON", "u": {"d": 2.5}}, "mode": "ON",
        })
        self.assertEqual(value["row"], [0.0, 4.0, 0.0])
        message = cdr.encode(value)
        # Header, octet with padding, double, text with its NUL.
        self.assertEqual(message[:8], b"\0\1\0\0\3\0\0\0")
        self.assertEqual(message[20:28], b"\4\0\0\0h\xc3\xa9\0")
        self.assertEqual(cdr.decode(message), value)
        for wrong in ({"nothing": 1}, {"row": {"3": 1.0}}):
            with self.assertRaises(ValueError, msg=str(wrong)):
                cdr.merge(zero, wrong)
        with self.assertRaises(ValueError):
            cdr.encode({**value, "text": "too long"})


if __name__ == "__main__":
    unittest.main()
