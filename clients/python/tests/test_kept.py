"""Views that codels keep after their calls are told, once, with the line."""

import ctypes
import threading
import unittest
from typing import List

from .scripts import IDS, Called, codel, data, pointer, port


class Kept(unittest.TestCase):
    def said(self, body: str, calls: int = 1, *, before: str = "", direction: str = "inout") -> List[str]:
        """What is logged of a codel that gets the IDS."""
        text = before + "\n\ndef f(ids):\n" + "".join(f"    {line}\n" for line in body.splitlines())
        called = Called(text, codel(data("ids", direction, 10)))
        self.assertIn("functions", called.answer, called.answer)
        memory = (ctypes.c_uint8 * IDS["size"])()
        for _ in range(calls):
            self.assertIsNone(called(pointer(memory)))
        return called.logged

    def told(self, body: str, *parts: str, before: str = "kept = []") -> None:
        logged = self.said(body, 40, before=before)
        self.assertEqual(len(logged), 1, logged)
        self.assertIn("codel f (demo.gen:5) of service go, /nowhere/demo.py:", logged[0])
        for one in parts:
            self.assertIn(one, logged[0])

    def test_a_view_of_an_argument_is_told_with_the_line_that_keeps_it(self) -> None:
        self.told("ids.velocity = 1\nkept.append(ids)", "demo.py:5, keeps a view of `ids` in `kept` after")
        self.told("global kept\nkept = ids", "demo.py:5, keeps a view of `ids` in `kept` after its call")

    def test_so_is_a_struct_in_it(self) -> None:
        self.told("kept[:] = [ids.current]", "demo.py:4, keeps a view of `ids` in `kept`")
        self.told("kept.add(ids.current)", "a view of `ids` in `kept`", before=KEEPER)

    def test_so_are_arrays_sequences_and_their_elements(self) -> None:
        for one in ["ids.joints", "ids.path", "ids.steps", "ids.steps[0]"]:
            self.told(
                f"ids.steps = [{{}}]\nids.path = [1]\nkept[:] = [{one}]",
                "demo.py:6, keeps a view of a part of its arguments in `kept`",
            )

    def test_what_a_function_defined_in_it_refers_to_is_kept_with_it(self) -> None:
        self.told("kept.append(lambda: ids.velocity)", "keeps a view of `ids` after its call")

    def test_values_and_what_is_over_with_the_call_are_not_told(self) -> None:
        body = (
            "ids.joints = [1, 2, 3]\nids.path = [1]\nids.steps = [{}]\n"
            "kept[:] = [ids.velocity, list(ids.joints), list(ids.path), ids.speed, ids.name, ids.maybe]\n"
            "def again(count):\n    return again(count - 1) if count else ids.joints[0]\n"
            "again(3)\n"
            "try:\n    ids.count = 'x'\nexcept TypeError as error:\n    cycle = [error]\n    cycle.append(cycle)\n"
            "inner, element = ids.current, ids.steps[0]"
        )
        self.assertEqual(self.said(body, 100, before="kept = []"), [])

    def test_calls_in_other_threads_are_none_that_keep(self) -> None:
        called = Called("import time\ndef f(ids):\n    time.sleep(0)\n    ids.joints[0] += 1\n",
                        codel(data("ids", "inout", 10)))
        memory = (ctypes.c_uint8 * IDS["size"])()

        def call() -> None:
            for _ in range(500):
                called(pointer(memory))

        threads = [threading.Thread(target=call) for _ in range(4)]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
        self.assertEqual(called.logged, [])

    def test_a_port_that_is_kept_is_told(self) -> None:
        text = "kept = []\ndef f(where):\n    kept.append(where)\n"
        called = Called(text, codel(port(0)))
        prototype = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)
        functions = [prototype(lambda _: None) for _ in range(2)]
        table = (ctypes.c_void_p * 2)(*(ctypes.cast(one, ctypes.c_void_p).value for one in functions))
        self.assertIsNone(called(pointer(table)))
        self.assertEqual(len(called.logged), 1, called.logged)
        self.assertIn("keeps a view of `where` in `kept`", called.logged[0])


KEEPER = """
class Keeper:
    def add(self, one):
        self.one = one


kept = Keeper()"""


