"""A daemon as a part of a notebook: its cells run in a kernel of Jupyter."""

import os
import unittest

from jupyter_client.manager import start_new_kernel

from .support import WATCHDOG
from .test_embedded import ended

DEMO = os.environ["GENOM_DEMO"]


class Notebook(unittest.TestCase):
    def setUp(self):
        self.manager, self.client = start_new_kernel(startup_timeout=WATCHDOG)
        self.addCleanup(self.end)
        self.addCleanup(self.client.stop_channels)

    def end(self):
        if self.manager.has_kernel:
            self.manager.shutdown_kernel()

    def run_cell(self, code):
        """What a cell of the notebook prints, and its exception."""
        printed = []

        def hear(message):
            if message["msg_type"] == "stream":
                printed.append(message["content"]["text"])

        reply = self.client.execute_interactive(code, timeout=WATCHDOG, output_hook=hear)["content"]
        return "".join(printed), reply.get("ename")

    def test_its_cells_step_a_daemon_and_have_its_ports(self):
        self.assertEqual(self.run_cell("import genom\nd = genom.Daemon()"), ("", None))
        told = self.run_cell(f"demo = d.load({DEMO!r})\nposition = d.port(demo.position)")
        self.assertEqual(told, ("", None))
        told = self.run_cell("demo.goto(1.0, ack=True)\nd.step(0.1)\nprint(d.now, position.data.position > 0)")
        self.assertEqual(told, ("0.1 True\n", None))
        self.assertEqual(self.run_cell("d.step(-1.0)"), ("", "ValueError"))
        # With the kernel, the daemon ends.
        process = int(self.run_cell("print(d.pid)")[0])
        self.manager.shutdown_kernel()
        self.assertTrue(ended(process))


if __name__ == "__main__":
    unittest.main()
