"""Codels in Python where NumPy is: arrays are arrays of NumPy that lie in the memory of genomd.

Without NumPy this file fails.
"""

import ctypes
import unittest
from typing import Any

import numpy

from .scripts import DOUBLE, IDS, Called, Handle, codel, data, pointer, port

# What each type of numbers is in NumPy.
NUMBERS = {
    "octet": numpy.uint8, "short": numpy.int16, "unsigned short": numpy.uint16, "long": numpy.int32,
    "unsigned long": numpy.uint32, "long long": numpy.int64, "unsigned long long": numpy.uint64,
    "float": numpy.float32, "double": numpy.float64, "boolean": numpy.bool_,
}
# Where the members of the IDS lie.
AT = {one["name"]: one["offset"] for one in IDS["members"]}
SIZE = IDS["size"]


class Arrays(unittest.TestCase):
    def of(self, memory: Any, at: int, count: int, dtype: Any = float) -> Any:
        """The numbers at a place in memory, as a test sees them."""
        return numpy.frombuffer(memory, dtype, count, at)

    def view(self, one: Any, memory: Any, dtype: Any, shape: Any, writeable: bool = True) -> None:
        """Checks that it is an array of NumPy, whose numbers are in this memory and nowhere else."""
        self.assertIsInstance(one, numpy.ndarray)
        self.assertEqual((one.dtype, one.shape), (numpy.dtype(dtype), shape))
        self.assertTrue(numpy.shares_memory(one, numpy.frombuffer(memory, numpy.uint8)))
        self.assertEqual(one.flags.writeable, writeable)

    def run_fine(self, called: Called, *arguments: Any, seen: Any = None) -> None:
        """Calls the codel, with a function `seen` of the test that it may call."""
        called.scope["seen"] = seen
        self.assertEqual((called(*arguments), called.logged), (None, []))

    def test_an_array_of_the_ids_is_one_of_numpy_in_their_memory(self) -> None:
        memory = (ctypes.c_uint8 * SIZE)()
        joints = self.of(memory, AT["joints"], 3)
        joints[:] = 1, 2, 3
        called = Called(
            "def f(ids):\n    seen(ids.joints)\n    ids.joints *= 2\n    ids.joints[ids.joints > 5] = 0\n",
            codel(data("ids", "inout", 10)),
        )
        self.run_fine(
            called, pointer(memory), seen=lambda one: self.view(one, memory, "f8", (3,))
        )
        self.assertEqual(joints.tolist(), [2, 4, 0])

    def test_an_array_of_an_input_is_read_only(self) -> None:
        memory = (ctypes.c_uint8 * SIZE)()
        called = Called("def f(ids):\n    seen(ids.joints)\n", codel(data("ids", "in", 10)))
        self.run_fine(
            called, pointer(memory), seen=lambda one: self.view(one, memory, "f8", (3,), False)
        )

    def test_the_numbers_of_a_sequence_are_an_array_until_it_grows(self) -> None:
        memory = (ctypes.c_uint8 * SIZE)()

        def seen(one: Any) -> None:
            at = ctypes.c_void_p.from_buffer(memory, AT["path"] + 8).value or 0
            self.view(one, (ctypes.c_int32 * 3).from_address(at), "i4", (3,))

        called = Called(
            "import numpy\ndef f(ids):\n    ids.path = numpy.arange(3)\n    seen(ids.path.array)\n"
            "    ids.path.array[1:] += 10\n    assert numpy.asarray(ids.path).tolist() == [0, 11, 12]\n"
            "    ids.path.append(1)\n    assert ids.path.array.shape == (4,)\n",
            codel(data("ids", "inout", 10)),
        )
        self.run_fine(called, pointer(memory), seen=seen)

    def test_a_parameter_of_several_dimensions_has_their_shape(self) -> None:
        memory = (ctypes.c_double * 6)(*range(6))
        called = Called("def f(m):\n    seen(m)\n    m[:, 1] *= -1\n", codel(data("m", "inout", 12)))
        self.run_fine(called, pointer(memory), seen=lambda one: self.view(one, memory, "f8", (2, 3)))
        self.assertEqual(list(memory), [0, -1, 2, 3, -4, 5])

    def test_each_type_of_numbers_is_the_same_in_numpy(self) -> None:
        for kind, dtype in NUMBERS.items():
            size = numpy.dtype(dtype).itemsize
            of = {**DOUBLE, "kind": kind, "name": kind, "size": size, "align": size}
            row = {
                "kind": "array", "name": f"{kind}[4]", "size": 4 * size, "align": size,
                "fixed": True, "length": 4, "element": 0,
            }
            # The request of these tests names types up to number 11, which do not matter here.
            types = [of, *[DOUBLE] * 11, row]
            memory = (ctypes.c_uint8 * (4 * size))()
            one = codel(data("row", "inout", 12))
            called = Called("def f(row):\n    seen(row)\n    row[2] = 1\n", one, types=types)
            self.run_fine(
                called, pointer(memory), seen=lambda one: self.view(one, memory, dtype, (4,))
            )
            self.assertEqual(self.of(memory, 0, 4, dtype).tolist(), [0, 0, 1, 0])

    def test_the_values_of_ports_are_arrays_in_their_buffers(self) -> None:
        out, read = (ctypes.c_double * 6)(), (ctypes.c_double * 6)(*range(6))
        written = []
        poses = Handle(lambda _: ctypes.addressof(out), lambda _: written.append(list(out)))
        grid = Handle(lambda _: ctypes.addressof(read), lambda _: None)

        def seen(mine: Any, theirs: Any) -> None:
            self.view(mine, out, "f8", (2, 3))
            self.view(theirs, read, "f8", (2, 3), False)

        called = Called(
            "def f(poses, grid):\n    seen(poses.data, grid.read())\n"
            "    poses.data[:] = grid.data.T.reshape(2, 3)\n    poses.write()\n"
            "    poses.write(grid.data + 1)\n",
            codel(port(3), port(4)),
        )
        self.run_fine(called, pointer(poses.table), pointer(grid.table), seen=seen)
        self.assertEqual(written, [[0, 3, 1, 4, 2, 5], [1, 2, 3, 4, 5, 6]])

    def test_what_numpy_would_repeat_round_or_wrap_around_is_refused(self) -> None:
        memory = (ctypes.c_uint8 * SIZE)()
        for line in ["ids.joints = numpy.zeros(1)", "ids.joints = numpy.zeros((3, 1))",
                     "ids.path = numpy.array([0.5])", "ids.path = numpy.array([2**31])"]:
            called = Called(f"import numpy\ndef f(ids):\n    {line}\n", codel(data("ids", "inout", 10)))
            self.assertEqual(called(pointer(memory)), "::genom::unkex", line)
        self.assertEqual(bytes(memory), bytes(len(memory)))


if __name__ == "__main__":
    unittest.main()
