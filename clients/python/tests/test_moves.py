"""Ports that move to another middleware, and components that are reloaded: direct readers and
publishers follow, or get an error. With the packages iceoryx2 and eclipse-zenoh.
"""

import contextlib
import os
import threading
import unittest
from unittest import mock

import genom

from .support import WATCHDOG, DemoCase


class Moves(DemoCase):
    def reload(self):
        """Reloads the component as in a new process: it has no connections."""
        genom.Component.unload(self.demo)
        return self.g.load(os.environ["GENOM_DEMO"], "-i", self.demo.name)

    def at(self, position):
        """The value read after a motion to that position has ended."""
        self.demo.set_speed(2.0)
        self.demo.goto(position)
        return {"position": position, "velocity": 0.0}

    def until(self, values, wanted):
        while values.wait(WATCHDOG) != wanted:
            pass

    def test_a_subscription_goes_where_its_port_goes(self):
        with self.demo.position.subscribe() as positions:
            self.until(positions, self.at(0.1))
            for number, (backend, fast) in enumerate(
                [("zenoh", True), ("local", False), ("shm", False), ("zenoh", False)], 2
            ):
                self.demo.move(backend)
                self.until(positions, self.at(number / 10))
                self.assertEqual(positions.fast, fast, backend)
        with self.assertRaises(genom.GenoMError):
            positions.wait(WATCHDOG)

    def test_what_was_written_before_a_move_is_read_before_it(self):
        with self.demo.position.subscribe() as positions:
            wanted = self.at(0.05)
            self.demo.move("zenoh")
            self.until(positions, wanted)
            wanted = self.at(0.1)
            seen = []
            while not seen or seen[-1] != wanted:
                seen.append(positions.wait(WATCHDOG))
        places = [one["position"] for one in seen]
        self.assertEqual(places, sorted(places))

    def test_who_waits_goes_with_the_port(self):
        with self.demo.position.subscribe(fast=True) as positions:
            self.until(positions, self.at(0.1))
            seen = []
            waiter = threading.Thread(target=lambda: seen.append(positions.wait(WATCHDOG)))
            waiter.start()
            self.demo.move("zenoh")
            # The last value is received again on the new middleware.
            waiter.join(WATCHDOG)
            self.assertEqual(seen, [{"position": 0.1, "velocity": 0.0}])
            self.until(positions, self.at(0.2))

    def test_a_reader_of_an_in_port_goes_where_its_writer_goes(self):
        parameter = self.demo.parameter
        with parameter.publisher(fast=True) as p, parameter.subscribe(fast=True) as gain:
            p(0.25)
            p(0.5)
            self.until(gain, 0.5)
            parameter.disconnect()
            self.told(p, "ended")
            parameter.connect(parameter.address(), backend="zenoh")
            with parameter.publisher(fast=True) as q:
                q(0.75)
                self.until(gain, 0.75)
            self.told(p, "ended")

    def test_insisting_on_the_fast_way_raises_where_there_is_none(self):
        with self.demo.position.subscribe(fast=True) as positions:
            self.until(positions, self.at(0.1))
            self.demo.move("local")
            with self.assertRaisesRegex(genom.RefusalError, "it is on local, not on shm"):
                positions.wait(WATCHDOG)
            self.demo.move("zenoh")
            self.until(positions, self.at(0.2))

    def test_a_subscription_is_told_of_an_unload_and_goes_on_after_a_reload(self):
        for backend, fast in (("shm", True), ("zenoh", True), ("shm", False)):
            with self.subTest(backend=backend, fast=fast):
                self.demo.move(backend)
                with self.demo.position.subscribe(fast=fast) as positions:
                    self.until(positions, self.at(0.1))
                    genom.Component.unload(self.demo)
                    with self.assertRaisesRegex(genom.GenoMError, "no component") as caught:
                        positions.wait(WATCHDOG)
                    self.assertEqual(caught.exception.name, "ended")
                    self.assertEqual(list(positions), [])
                    self.demo = self.g.load(os.environ["GENOM_DEMO"], "-i", self.demo.name)
                    self.demo.move(backend)
                    wanted = self.at(0.2)
                    seen = None
                    while seen != wanted:
                        try:
                            seen = positions.wait(WATCHDOG)
                        except genom.GenoMError as error:
                            # This client has not been notified yet.
                            self.assertEqual(error.name, "ended")

    def test_a_publisher_feeds_its_component_again_after_a_reload(self):
        for backend in ("shm", "zenoh"):
            with self.subTest(backend=backend):
                self.demo.move(backend)
                with self.demo.parameter.publisher(fast=True) as p:
                    p(0.0)
                    with self.g.events() as events:
                        self.demo = self.reload()
                        # Without a request of this client.
                        while next(events)["event"] != "connected":
                            pass
                    self.feed(p)

    def test_a_component_that_is_back_has_the_value_published_last(self):
        for backend in ("shm", "zenoh"):
            with self.subTest(backend=backend):
                self.demo.move(backend)
                with self.demo.parameter.publisher(fast=True) as p:
                    p(0.0)
                    self.demo = self.reload()
                    activity = self.demo.goto(goal=0.1, ack=True)
                    with self.demo.parameter.subscribe(fast=False) as gain:
                        self.until(gain, 0.0)
                    p(2.0)
                    activity.wait(WATCHDOG)

    def test_a_publisher_is_told_when_something_else_feeds_its_port(self):
        with self.demo.parameter.publisher(fast=True) as p:
            p(0.5)
            self.demo.parameter.connect("elsewhere/gain", wait=True)
            self.told(p, "connected")
        # The port stays connected to what feeds it now.
        self.assertEqual(self.demo.parameter.connected(), "elsewhere/gain")
        self.demo.parameter.disconnect()
        with self.demo.parameter.publisher(fast=True) as p:
            p(0.5)
            self.demo.parameter.disconnect()
            self.told(p, "ended")

    def told(self, publisher, name):
        """Checks that publishing raises this error as soon as the change is known."""
        with self.assertRaises(genom.GenoMError) as caught:
            while True:
                publisher(0.5)
        self.assertEqual(caught.exception.name, name)

    def test_all_ends_of_a_client_share_one_stream(self):
        from genom._watch import Watch

        self.demo.move("zenoh")
        with mock.patch.object(Watch, "_open", autospec=True, side_effect=Watch._open) as opened:
            ends = [self.demo.position.subscribe(fast=True) for _ in range(5)]
            self.assertEqual(opened.call_count, 1)
        # A disconnected client monitors changes again when needed.
        self.g.disconnect()
        self.demo.move("shm")
        wanted = self.at(0.1)
        for end in ends:
            self.until(end, wanted)
        for end in ends:
            end.close()
        self.assertFalse(self.g._watch._ears)

    def test_where_no_stream_is_free_ends_ask_for_themselves(self):
        with contextlib.ExitStack() as streams:
            with self.assertRaises(genom.RefusalError) as caught:
                while True:
                    streams.enter_context(self.g.events())
            self.assertEqual(caught.exception.name, "too_many_streams")
            with self.demo.position.subscribe(fast=True) as positions:
                self.demo.move("zenoh")
                self.until(positions, self.at(0.1))

    def test_who_waits_for_a_stopped_daemon_is_told(self):
        with genom.connect(timeout=1.0) as g:
            demo = g.component(self.demo.name)
            with demo.position.subscribe(fast=True) as positions:
                self.until(positions, self.at(0.1))
                with self.asleep(), self.assertRaises(genom.DaemonError) as caught:
                    positions.wait(WATCHDOG)
                self.assertEqual(caught.exception.name, "no_answer")
                # It follows again when it is awake.
                wanted, seen = self.at(0.2), None
                while seen != wanted:
                    with contextlib.suppress(genom.DaemonError):
                        seen = positions.wait(WATCHDOG)

    def test_why_names_who_was_left_behind(self):
        from genom import _shm

        # A program that does not follow the port, like those that know the middleware only.
        left = _shm.Reader(self.demo.position, self.demo.position.address(), 1, False)
        self.demo.move("zenoh")
        found = " ".join(one["what"] for one in self.demo.position.why())
        self.assertIn(f"somebody reads {self.demo.name}/position on shm", found)
        left.close()
        here = self.demo.parameter.address()
        self.demo.parameter.connect(here, backend="shm")
        left = _shm.Writer(self.demo.parameter, here)
        self.demo.parameter.disconnect()
        found = self.demo.parameter.why()
        told = " ".join(one["what"] for one in found)
        self.assertIn(f"somebody publishes {here} on shm, and it is not connected", told)
        self.assertIn(f"`genomctl connect {here} shm:{here}`", " ".join(one["fix"] for one in found))
        left.close()


if __name__ == "__main__":
    unittest.main()
