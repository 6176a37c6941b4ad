"""What the tests share: a component of its own for each test, and a watchdog."""

import faulthandler
import itertools
import os
import unittest

import genom

# Nothing takes so long unless it hangs; then it is told where.
WATCHDOG = 50.0
_numbers = itertools.count()


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

    def start_slow(self):
        """A motion that is under way and does not end by itself in time."""
        with self.g.events() as events:
            activity = self.demo.goto(goal=10.0, ack=True)
            for event in events:
                if event.get("activity") == activity.number and event.get("state") == "main":
                    return activity
        self.fail("the stream of events ended")
