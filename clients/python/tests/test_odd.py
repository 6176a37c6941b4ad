"""What codels print is counted, on standard output and standard error, and told with its line."""

import io
import unittest
from typing import Any, List
from unittest import mock

from genom.runner import _odd


class Printed(unittest.TestCase):
    def setUp(self) -> None:
        self.logged: List[str] = []
        self.now = 0.0
        clock = mock.patch.object(_odd.time, "monotonic", lambda: self.now)
        clock.start()
        self.addCleanup(clock.stop)
        places, count = _odd.Places(self.logged.append), _odd.Count()
        self.plain = [io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2)]
        self.out, self.error = [_odd.Output(one, count, places) for one in self.plain]

    def written(self) -> List[int]:
        """How much has arrived."""
        return [len(one.buffer.getvalue()) for one in self.plain]  # type: ignore[attr-defined]

    def print(self, stream: Any, count: int) -> None:
        print("x" * count, file=stream, end="")

    def test_both_streams_count_together_and_nothing_is_left_out(self) -> None:
        self.print(self.out, 600_000)
        self.assertEqual(self.logged, [])
        for _ in range(3):
            self.print(self.error, 600_000)
        self.assertEqual(len(self.logged), 1, "once for each place")
        self.assertIn("more than 1 MiB is printed in a second:\n", self.logged[0])
        self.assertIn("test_odd.py", self.logged[0])
        self.assertIn("in print", self.logged[0].splitlines()[-2])
        self.assertEqual(self.written(), [600_000, 1_800_000])

    def test_a_second_that_is_over_does_not_count(self) -> None:
        for _ in range(5):
            self.print(self.out, 600_000)
            self.now += 1.5
        self.assertEqual((self.logged, self.written()), ([], [3_000_000, 0]))

    def test_the_streams_of_the_process_are_watched(self) -> None:
        streams = {"stdout": self.plain[0], "stderr": self.plain[1]}
        with mock.patch.multiple(_odd.sys, **streams), mock.patch.object(_odd.os, "register_at_fork"):
            _odd.watch(self.logged.append)
            self.print(_odd.sys.stdout, 600_000)
            self.print(_odd.sys.stderr, 600_000)
            # As scripts do to print elsewhere; what was there before may be put back.
            _odd.sys.stdout = _odd.sys.stderr = None
        self.assertEqual(len(self.logged), 1)
        self.assertEqual(self.written(), [600_000, 600_000])


if __name__ == "__main__":
    unittest.main()
