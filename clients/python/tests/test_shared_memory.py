"""Ports directly over shared memory, with the package iceoryx2."""

import os
import time
import unittest

import genom

from .support import WATCHDOG, DemoCase, p50_p99, tell


class SharedMemory(DemoCase):
    def test_the_demo_is_read_by_a_peer_that_is_no_genomd(self):
        with self.demo.position.subscribe(fast=True) as positions:
            self.assertTrue(positions.fast)
            seen = self.moved(positions)
        steps = [after - before for before, after in zip(seen, seen[1:])]
        # No sample was lost: at 2 m/s none is more than a period of 5 ms further on.
        self.assertLess(max(steps), 0.0101)
        self.assertGreaterEqual(min(steps), 0.0)

    def test_a_fast_publisher_feeds_the_codels(self):
        with self.demo.parameter.publisher() as p:
            self.assertTrue(p.fast)
            self.feed(p)
            self.assertEqual(self.demo.parameter.read(), 2.0)
            with self.assertRaises(genom.InputError):
                p("fast")
        self.assertIsNone(self.demo.parameter.connected())
        # The address is free: the daemon itself publishes there now.
        self.demo.parameter.publish(1.0)
        # And closes its publisher when this process opens one again.
        with self.demo.parameter.publisher(fast=True) as p:
            p(0.25)

    def test_the_newest_value_of_a_burst_arrives_when_the_reader_was_held_up(self):
        with self.demo.parameter.publisher(fast=True) as p:
            self.burst(p, 50_000, stopped=True)

    def test_two_publishers_do_not_share_a_port(self):
        with self.demo.parameter.publisher(fast=True) as p:
            p(1.0)
            with self.assertRaises(genom.RefusalError) as caught:
                self.demo.parameter.publisher(fast=True)
            self.assertEqual(caught.exception.name, "taken")
            with self.assertRaises(genom.RefusalError) as caught:
                self.demo.parameter.publish(0.5)
            self.assertEqual(caught.exception.name, "taken")
            self.assertEqual(self.demo.parameter.connected(), f"{self.demo.name}/parameter")

    def test_samples_go_to_another_process_and_come_back_in_order(self):
        count = 5000
        with self.echoed("shm", count) as exchange:
            begin = time.perf_counter()
            for number in range(count):
                exchange(float(number))
            rate = count / (time.perf_counter() - begin)
        tell(f"round trips between two processes: {rate:.0f}/s")

    def test_a_simulator_gets_the_command_to_each_state_in_each_step(self):
        # Set GENOM_STEPS=10000 for a longer run.
        steps = int(os.environ.get("GENOM_STEPS", "1000"))

        def run(step):
            """Runs a loop at 1 kHz; returns the number of late steps, and the times between steps.
            """
            rate, begun = genom.Rate(1000), []
            for number in rate:
                begun.append(time.perf_counter())
                if number == steps:
                    break
                step(number)
            self.assertEqual(rate.steps, steps)
            periods = [after - before for before, after in zip(begun, begun[1:])]
            return f"{rate.late} of {steps} steps late, period {p50_p99(periods)} us p50 / p99"

        bare = run(lambda number: None)
        with self.echoed("shm", steps) as exchange:
            # The command for this state, in this step: none is lost, none is out of order.
            ours = run(lambda number: exchange(float(number)))
        tell(f"1 kHz, bare: {bare}")
        tell(f"1 kHz, state and command by shared memory: {ours}")

    def test_a_simulator_drives_the_codels_and_reads_them_at_each_step(self):
        seen = []
        with self.demo.parameter.publisher() as state, self.demo.position.subscribe() as command:
            state(0.0)
            self.demo.goto(10.0, ack=True)
            command.wait(WATCHDOG)
            for step in genom.Rate(1000):
                state(1.0)
                seen.append(command.read()["position"])
                # It moves by what it reads from here; when it begins is not tested.
                if seen[-1] > 0.05:
                    break
        self.assertEqual(seen, sorted(seen))


class Layouts(unittest.TestCase):
    """Types that the demo does not have, in the form of the daemon's description."""

    def codec(self, *types):
        from genom._layout import Codec

        return Codec({"types": list(types)})

    def test_values_of_every_kind_go_in_and_come_out(self):
        import ctypes

        codec = self.codec(
            {"kind": "struct", "name": "::m::all", "full_name": "::m::all", "size": 56, "align": 8,
             "members": [
                 {"name": "mode", "offset": 0, "type": 1},
                 {"name": "text", "offset": 4, "type": 2},
                 {"name": "list", "offset": 12, "type": 3},
                 {"name": "maybe", "offset": 32, "type": 5},
                 {"name": "either", "offset": 40, "type": 7},
             ]},
            {"kind": "enum", "name": "::m::mode", "size": 4, "align": 4, "enumerators": ["OFF", "ON"]},
            {"kind": "string", "name": "string<8>", "size": 8, "align": 1, "bound": 8},
            {"kind": "sequence", "name": "sequence<long,3>", "size": 20, "align": 4, "bound": 3,
             "element": 4, "offsets": [0, 4, 8]},
            {"kind": "long", "name": "long", "size": 4, "align": 4},
            {"kind": "optional", "name": "optional<short>", "size": 4, "align": 2, "element": 6,
             "offsets": [2]},
            {"kind": "short", "name": "short", "size": 2, "align": 2},
            {"kind": "union", "name": "::m::either", "size": 16, "align": 8, "discriminant": 1,
             "members": [
                 {"name": "i", "offset": 8, "type": 4, "labels": [0]},
                 {"name": "d", "offset": 8, "type": 8, "labels": [None]},
             ]},
            {"kind": "double", "name": "double", "size": 8, "align": 8},
        )
        self.assertEqual(codec.type.type_name(), "m::all")
        room = codec.type()
        at = ctypes.addressof(room)
        value = {
            "mode": "ON", "text": "héllo", "list": [1, -2], "maybe": -3,
            "either": {"d": "ON", "u": {"d": 0.5}},
        }
        codec.put(at, value)
        self.assertEqual(codec.get(at), value)
        codec.put(at, {"maybe": None, "list": [7, 8, 9], "mode": "::m::OFF"})
        self.assertEqual(
            codec.get(at), {**value, "maybe": None, "list": [7, 8, 9], "mode": "OFF"}
        )
        for wrong in ({"mode": "BOTH"}, {"text": "too long!"}, {"list": [1, 2, 3, 4]},
                      {"maybe": 70000}, {"nothing": 1}, {"either": {"d": "OFF", "u": {"d": 1.0}}}):
            with self.assertRaises(ValueError, msg=str(wrong)):
                codec.put(at, wrong)

    def test_a_layout_that_differs_here_is_refused(self):
        with self.assertRaisesRegex(TypeError, "aligned to"):
            self.codec({"kind": "double", "name": "double", "size": 8, "align": 4})


if __name__ == "__main__":
    unittest.main()
