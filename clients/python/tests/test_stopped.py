"""A daemon whose process is stopped, as by Ctrl-Z or a debugger: everybody who asks gets an error.
"""

import contextlib
import unittest
from concurrent.futures import ThreadPoolExecutor

import genom

from .support import WATCHDOG, DemoCase

# A running daemon reports that it is alive within this many seconds.
SHORT = 1.0


class Stopped(DemoCase):
    def test_whoever_asks_is_told_why_there_is_no_answer(self):
        g = genom.connect(timeout=SHORT)
        self.addCleanup(g.disconnect)
        demo = g.component(self.demo.name)
        activity = demo.goto(goal=10.0, ack=True)
        with g.events() as events, demo.position.subscribe(fast=False) as positions:
            positions.wait(WATCHDOG)

            def follow():
                while True:
                    positions.wait()

            asks = (
                g.components,
                lambda: genom.connect(timeout=SHORT),
                lambda: demo.set_speed(velocity=1.0),
                lambda: demo.goto(goal=0.0, send=True).wait(),
                activity.wait,
                activity.abort,
                lambda: list(events),
                follow,
            )
            with self.asleep(), ThreadPoolExecutor(len(asks)) as pool:
                for asked in [pool.submit(ask) for ask in asks]:
                    with self.assertRaises(genom.DaemonError) as caught:
                        asked.result(WATCHDOG)
                    self.assertEqual(caught.exception.name, "no_answer")
                    self.assertIn("its process is stopped", str(caught.exception))
        # When it runs again, so does this request; the motion was asked to stop.
        activity.abort()
        with contextlib.suppress(self.demo.interrupted):
            activity.wait(WATCHDOG)
        self.assertIn(activity.status, (genom.Status.DONE, genom.Status.ERROR))

    def test_what_takes_long_is_waited_for(self):
        g = genom.connect(timeout=SHORT)
        self.addCleanup(g.disconnect)
        demo = g.component(self.demo.name)
        # More than twice the timeout, with no message of the daemon.
        demo.set_speed(2.0)
        self.assertEqual(demo.goto(goal=5.0), {})


if __name__ == "__main__":
    unittest.main()
