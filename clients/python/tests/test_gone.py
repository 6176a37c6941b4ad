"""A daemon that is killed: everybody who waits gets an error. This test ends the daemon."""

import os
import signal
import threading
import unittest

import genom

from .support import WATCHDOG, DemoCase


class Gone(DemoCase):
    def test_who_waits_is_told_that_the_daemon_went_away(self):
        activity = self.start_slow()
        events = self.g.events()
        ends = []

        def wait():
            try:
                activity.wait(WATCHDOG)
            except genom.DaemonError as error:
                ends.append(error.name)

        waiter = threading.Thread(target=wait)
        waiter.start()
        os.kill(self.g.about()["pid"], signal.SIGKILL)
        waiter.join(WATCHDOG)
        self.assertEqual(len(ends), 1)
        self.assertIn(ends[0], ("lost", "unreachable"))
        list(events)
        with self.assertRaises(genom.DaemonError):
            self.demo.get_speed()

    def load(self):
        # The component ends with the daemon: nothing to unload.
        return self.g.load(os.environ["GENOM_DEMO"])


if __name__ == "__main__":
    unittest.main()
