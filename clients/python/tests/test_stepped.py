"""A daemon with a virtual clock: `genomd --clock virtual`."""

import unittest

import genom

from .support import WATCHDOG, DemoCase


class Stepped(DemoCase):
    def test_time_goes_on_by_steps(self):
        self.demo.set_speed(2.0)
        activity = self.demo.goto(0.1, ack=True)
        begun = now = self.g.step(0.0)
        while activity.status == genom.Status.SENT:
            before, now = now, self.g.step(0.005)
            self.assertAlmostEqual(now - before, 0.005)
        self.assertEqual(activity.wait(WATCHDOG), {})
        # Not earlier than at 2 m/s.
        self.assertGreaterEqual(now - begun, 0.0499)
        self.assertEqual(self.demo.position.read()["position"], 0.1)


if __name__ == "__main__":
    unittest.main()
