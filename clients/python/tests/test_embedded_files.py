"""What the ports of an embedded daemon take: open files and mappings, until they are closed."""

import contextlib
import faulthandler
import os
import resource
import sys
import unittest

import genom

from .support import WATCHDOG

DEMO = os.environ["GENOM_DEMO"]


def files(process="self"):
    """How many files a process has open, and how many of them are memory of ports. Libraries are
    left out: libffi opens its own file with the first callback, and keeps it."""
    names = []
    for number in os.listdir(f"/proc/{process}/fd"):
        with contextlib.suppress(FileNotFoundError):
            names.append(os.readlink(f"/proc/{process}/fd/{number}"))
    names = [name for name in names if ".so" not in os.path.basename(name)]
    return len(names), sum("genom-port" in name for name in names)


def mapped():
    """How many ports of daemons are mapped here."""
    with open("/proc/self/maps", encoding="utf-8") as maps:
        return sum("genom-port" in line for line in maps)


class Files(unittest.TestCase):
    def setUp(self):
        limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, limits)
        resource.setrlimit(resource.RLIMIT_NOFILE, (limits[1], limits[1]))
        self.addCleanup(faulthandler.cancel_dump_traceback_later)

    def test_a_port_takes_one_file_of_each_side_and_gives_it_back(self):
        # Python maps files without keeping them open since 3.13.
        kept = 0 if sys.version_info >= (3, 13) else 1
        before, _ = files()
        with genom.Daemon() as d:
            demos = []
            for components in (1, 50, 500):
                faulthandler.dump_traceback_later(2 * WATCHDOG, exit=True)
                demos += [d.load(DEMO, name=f"demo{n}") for n in range(len(demos), components)]
                d.step(0.005)
                (here, _), (there, _) = files(), files(d.pid)
                ports = [d.port(demo.position) for demo in demos]
                d.step(0.005)
                self.assertEqual(files()[0], here + kept * components)
                self.assertEqual(mapped(), components)
                # Of what the daemon opens for itself meanwhile, such as a connection, not much.
                total, shared = files(d.pid)
                self.assertEqual(shared, components)
                self.assertLess(total - there - shared, 16)
                for port in ports:
                    port.close()
                del port, ports
                self.assertEqual((mapped(), files()[0], files(d.pid)[1]), (0, here, 0))
        self.assertEqual(files()[0], before)


if __name__ == "__main__":
    unittest.main()
