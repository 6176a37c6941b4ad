"""Ports of a daemon that is a part of the program, and codels in its cells, where NumPy is: arrays of
NumPy that lie in the memory which both share.

Without NumPy this file fails.
"""

import contextlib
import os
import sys
import tempfile
import unittest

import numpy

import genom

from .test_embedded import SIGHTS, Case

DESCRIPTION = """component arm {
  lang "python";
  typedef double row_t[3];
  typedef row_t grid_t[2];
  typedef float pair_t[2];
  ids { grid_t sum; };
  port in grid_t push;
  port out grid_t moved;
  task main {
    period 10 ms;
    codel<start> arm_tick(inout sum, in push, out moved) yield pause::start;
    codel<stop> arm_end() yield ether;
  };
  function scaled(in pair_t by, out pair_t gains) {
    codel arm_scale(in by, out gains);
  };
};
"""

# What only arrays of NumPy can do: arithmetic, and columns.
SCRIPT = """
import numpy


def arm_tick(sum, push, moved):
    if push.latest() is not None:
        assert isinstance(push.data, numpy.ndarray) and not push.data.flags.writeable
        sum += push.data
        moved.data[:] = sum
        moved.data[:, 0] *= -1
        moved.write()
    return "pause::start"


def arm_end():
    return "ether"


def arm_scale(by, gains):
    assert (by.dtype, gains.dtype) == (numpy.float32, numpy.float32)
    gains[...] = numpy.sqrt(by)
"""


class Numpy(Case):
    def view(self, one, port, dtype, shape, writeable):
        """Checks that it is an array of NumPy, whose numbers are in the memory of the port."""
        self.assertIsInstance(one, numpy.ndarray)
        self.assertEqual((one.dtype, one.shape), (numpy.dtype(dtype), shape))
        self.assertTrue(numpy.shares_memory(one, numpy.frombuffer(port._memory, numpy.uint8)))
        self.assertEqual(one.flags.writeable, writeable)

    def test_arrays_of_ports_are_arrays_of_numpy_in_the_shared_memory(self):
        with genom.Daemon() as d:
            sights = d.load(SIGHTS)
            wave, picture = d.port(sights.wave), d.port(sights.picture)
            row = wave.data.row
            self.view(row, wave, numpy.float64, (3,), writeable=False)
            d.step(0.001)
            # The same array shows what the step brought.
            self.assertEqual(row.tolist(), [1.0, 2.0, 3.0])
            with self.assertRaises(ValueError):
                row[0] = 5.0
            picture.data.data = numpy.arange(6, dtype=numpy.uint8)
            pixels = picture.data.data.array
            self.view(pixels, picture, numpy.uint8, (6,), writeable=True)
            pixels.reshape(2, 3)[:, 1] += 100
            picture.write()
            d.step(0.001)
            self.assertEqual(sights.picture.read()["data"], [0, 101, 2, 3, 104, 5])

    def test_codels_in_python_and_the_program_compute_on_the_same_arrays(self):
        interpreter = ["--set", f'cells.python="{sys.executable}"']
        with contextlib.ExitStack() as ends:
            place = ends.enter_context(tempfile.TemporaryDirectory())
            for name, text in (("arm.gen", DESCRIPTION), ("arm.py", SCRIPT)):
                with open(os.path.join(place, name), "w", encoding="utf-8") as file:
                    file.write(text)
            d = ends.enter_context(genom.Daemon(options=interpreter))
            arm = d.load(os.path.join(place, "arm.gen"))
            push, moved = d.port(arm.push), d.port(arm.moved)
            self.view(push.data, push, numpy.float64, (2, 3), writeable=True)
            self.view(moved.data, moved, numpy.float64, (2, 3), writeable=False)
            for _ in range(3):
                push.data += [[1.0, 0.0, 0.0], [0.0, 0.0, 2.0]]
                push.write()
                d.step(0.01)
            self.assertEqual(moved.data.tolist(), [[-6.0, 0.0, 0.0], [0.0, 0.0, 12.0]])
            self.assertEqual(moved.count, 3)
            told = arm.scaled(by=numpy.array([4.0, 9.0]))
            self.assertEqual(told["gains"], [2.0, 3.0])


if __name__ == "__main__":
    unittest.main()
