"""Ports through the daemon: values, publishing, subscribing."""

import os
import unittest

import genom

from .support import WATCHDOG, DemoCase


class Ports(DemoCase):
    def test_a_publisher_feeds_the_codels(self):
        with self.demo.parameter.publisher(fast=False) as p:
            self.assertFalse(p.fast)
            self.feed(p)
            self.assertEqual(self.demo.parameter.connected(), f"{self.demo.name}/parameter")
        self.assertIsNone(self.demo.parameter.connected())

    def test_the_newest_value_of_a_burst_arrives(self):
        with self.demo.parameter.publisher(fast=False) as p:
            self.burst(p, 200)

    def test_following_a_port_gives_its_values_in_order(self):
        self.demo.set_speed(2.0)
        with self.demo.position.subscribe(fast=False) as positions:
            self.assertEqual(positions.wait(WATCHDOG)["position"], 0.0)
            activity = self.demo.goto(0.2, ack=True)
            last = 0.0
            for value in positions:
                self.assertGreaterEqual(value["position"], last)
                last = value["position"]
                if last == 0.2 and value["velocity"] == 0.0:
                    break
            self.assertEqual(positions.read()["position"], 0.2)
            activity.wait(WATCHDOG)

    def test_following_ends_with_the_component(self):
        other = self.g.load(os.environ["GENOM_DEMO"], "-i", "passing")
        positions = other.position.subscribe(fast=False)
        positions.wait(WATCHDOG)
        genom.Component.unload(other)
        self.assertEqual(list(positions), [])

    def test_what_is_no_value_of_the_port_is_refused(self):
        with self.assertRaises(genom.InputError):
            self.demo.parameter.publish("fast")
        with self.assertRaisesRegex(genom.RefusalError, "is an out port"):
            self.demo.position.publisher()
        with self.assertRaisesRegex(genom.RefusalError, "has no fast path"):
            self.demo.parameter.publisher(fast=True)
        self.assertIsNone(self.demo.parameter.connected())

    def test_a_port_that_something_feeds_is_not_taken_away(self):
        self.demo.parameter.connect("elsewhere/gain", wait=True, backend="shm")
        with self.assertRaisesRegex(genom.RefusalError, "reads elsewhere/gain"):
            self.demo.parameter.publisher()
        self.demo.parameter.disconnect()
        self.demo.parameter.publisher()(1.0)


if __name__ == "__main__":
    unittest.main()
