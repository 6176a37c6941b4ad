"""Codels in Python, without a daemon: C functions made of a script, called as genomd calls them."""

import ctypes
import threading
import unittest
from typing import Any, Dict, List

from genom.runner._where import where

from .scripts import IDS, WATCHDOG, Called, Handle, codel, data, pointer, port, refused


class Values(unittest.TestCase):
    def run_on_ids(self, body: str, memory: Any = None, direction: str = "inout") -> Any:
        text = "from demo_types import *\nimport demo_types\ndef f(ids):\n"
        text += "".join(f"    {line}\n" for line in body.splitlines())
        called = Called(text, codel(data("ids", direction, 10)))
        self.assertIn("functions", called.answer, called.answer)
        memory = memory or (ctypes.c_uint8 * IDS["size"])()
        event = called(pointer(memory))
        return memory, event, called

    def fine(self, body: str, memory: Any = None, direction: str = "inout") -> Any:
        memory, event, called = self.run_on_ids(body, memory, direction)
        self.assertEqual((event, called.logged), (None, []))
        return memory

    def test_members_are_attributes_in_the_memory_of_the_component(self) -> None:
        memory = self.fine(
            "ids.velocity = 1.5\nids.count = -3\nids.current.position = 2\n"
            "ids.current = state(position=ids.current.position, velocity=4)\nids.halted = True"
        )
        self.assertEqual(ctypes.c_double.from_buffer(memory, 0).value, 1.5)
        self.assertEqual(ctypes.c_int32.from_buffer(memory, 8).value, -3)
        self.assertEqual(ctypes.c_double.from_buffer(memory, 16).value, 2.0)
        self.assertEqual(ctypes.c_double.from_buffer(memory, 24).value, 4.0)
        self.assertTrue(ctypes.c_bool.from_buffer(memory, 152).value)
        self.fine("assert (ids.velocity, ids.count, ids.halted) == (1.5, -3, True)", memory)
        self.fine("assert ids.current == state(position=2, velocity=4)", memory)

    def test_enumerations_texts_and_keywords(self) -> None:
        memory = self.fine("ids.speed = FAST\nids.name = 'é'\nids.from_ = 7")
        self.assertEqual(ctypes.c_uint32.from_buffer(memory, 12).value, 1)
        self.assertEqual(ctypes.string_at(ctypes.addressof(memory) + 136), "é".encode())
        self.fine("assert ids.speed is speed.FAST and ids.name == 'é' and ids.from_ == 7", memory)
        self.fine("ids.speed = 'SLOW'\nassert ids.speed == 0 and LIMIT == 5", memory)

    def test_arrays_sequences_and_optional_values(self) -> None:
        memory = self.fine(
            "ids.joints[1] = 2.5\nids.path = [1, 2]\nids.path.append(3)\nids.maybe = 4\n"
            "ids.steps.append(state(position=1))\nids.steps.append({'velocity': 2})"
        )
        self.fine("assert list(ids.joints) == [0, 2.5, 0] and list(ids.path) == [1, 2, 3]", memory)
        self.fine("assert list(ids.path.array) == [1, 2, 3] and ids.path[-1] == 3", memory)
        self.fine("assert ids.maybe == 4\nids.maybe = None\nassert ids.maybe is None", memory)
        self.fine("assert ids.steps[1].velocity == 2 and len(ids.steps) == 2", memory)
        self.fine("ids.joints = [1, 2, 3]\nids.path.clear()\nassert len(ids.path) == 0", memory)
        self.fine("assert list(ids.joints) == [1, 2, 3]", memory)

    def test_what_is_stored_may_be_a_view_of_the_place_itself(self) -> None:
        memory = self.fine(
            "ids.path = [1, 2, 3]\nids.path = ids.path\nids.path = ids.path[1:]\n"
            "ids.steps = [state(position=1), state(position=2)]\nids.steps = ids.steps[::-1]\n"
            "ids.steps = ids.steps\nids.joints = [1, 2, 3]\nids.joints = ids.joints[::-1]"
        )
        self.fine("assert list(ids.path) == [2, 3] and list(ids.joints) == [3, 2, 1]", memory)
        self.fine("assert [one.position for one in ids.steps] == [2, 1]", memory)

    def test_what_cannot_be_stored_leaves_what_was_there(self) -> None:
        memory = self.fine("ids.path = [1, 2]\nids.joints = [1, 2, 3]\nids.name = 'axis'")
        for line in ["ids.path = [3, 2**31]", "ids.path = [3, 1.5]", "ids.path = [3, 'x']",
                     "ids.joints = [4]", "ids.joints = 4", "ids.joints = [4, 5, 'x']",
                     "ids.name = '\\ud800'", "ids.name = 'a\\0b'"]:
            _, event, called = self.run_on_ids(line, memory)
            self.assertEqual(event, "::genom::unkex", line)
            self.assertIn("Error: ", called.logged[0])
            self.fine("assert list(ids.path) == [1, 2] and ids.name == 'axis'", memory)
            self.fine("assert list(ids.joints) == [1, 2, 3]", memory)

    def test_what_does_not_fit_is_an_error_and_nothing_else(self) -> None:
        for line, told in [
            ("ids.count = 2**31", "a long is to be between -2147483648 and 2147483647"),
            ("ids.count = 1.0", "a long is to be an integer, not 1.0"),
            ("ids.velocity = 'fast'", "TypeError"),
            ("ids.speed = 2", "a demo::speed is to be between 0 and 1, not 2"),
            ("ids.name = 'longer than'", "name: 'longer than' is longer than 7 bytes"),
            ("ids.sped = 1", "'ids' object has no attribute 'sped'"),
            ("state(positon=1)", "demo::state has no member `positon`; did you mean `position`?"),
            ("ids.joints[3] = 1", "IndexError"),
            ("ids.path[0]", "there is no element 0, only 0"),
            ("ids.steps = [{}, {}, {}]", "3 elements: sequence<::demo::state, 2> has at most 2"),
        ]:
            memory, event, called = self.run_on_ids(line)
            self.assertEqual(event, "::genom::unkex", line)
            self.assertIn(told, called.logged[0], line)
            self.assertIn("demo.py\", line 4, in f", called.logged[0])
            self.assertEqual(len(called.details[0]), 128)

    def test_what_is_only_read_cannot_be_changed(self) -> None:
        for line in ["ids.velocity = 1", "ids.current.position = 1", "ids.joints[0] = 1",
                     "ids.path.append(1)", "ids.current = state()", "ids.steps[0] = state()"]:
            memory, event, called = self.run_on_ids(line, direction="in")
            self.assertEqual((event, bytes(memory)), ("::genom::unkex", bytes(IDS["size"])), line)

    def test_a_view_of_what_a_codel_made_itself_keeps_it(self) -> None:
        self.fine(
            "import gc\njoints = demo_types.ids(joints=[1, 2, 3]).joints\ngc.collect()\n"
            "other = [demo_types.ids() for _ in range(50)]\nassert list(joints) == [1, 2, 3]"
        )

    def test_scalars_go_by_value_and_come_out_by_their_place(self) -> None:
        one = codel(data("goal", "in", 0), data("speed", "in", 4), data("name", "in", 2),
                    data("n", "inout", 1), yields=["ether", "pause::main"])
        text = (
            "from demo_types import *\ndef f(n, goal, speed, name):\n"
            "    assert speed is FAST and name == 'axis'\n    n.value += int(goal)\n"
            "    return 'pause::main' if n.value > 5 else 'ether'\n"
        )
        called, n = Called(text, one), ctypes.c_int32(1)
        name = ctypes.create_string_buffer(b"axis", 8)
        for goal, event in [(2.5, "::demo::ether"), (3.5, "::demo::pause::main")]:
            got = called(ctypes.c_double(goal), ctypes.c_uint32(1), pointer(name), pointer(n))
            self.assertEqual((got, called.logged), (event, []))
        self.assertEqual(n.value, 6)


    def test_a_parameter_of_the_script_keeps_its_default(self) -> None:
        one = codel(data("a", "in", 1), data("b", "in", 1), data("n", "out", 1))
        text = "def f(a, own=7, b=1, *, n, more=[]):\n    n.value = a * 100 + own * 10 + b + len(more)\n"
        called, n = Called(text, one), ctypes.c_int32()
        event = called(ctypes.c_int32(1), ctypes.c_int32(2), pointer(n))
        self.assertEqual((event, called.logged, n.value), (None, [], 172))


class Events(unittest.TestCase):
    def test_declared_exceptions_are_recorded_with_their_detail(self) -> None:
        text = "from demo_types import *\ndef f():\n    raise OUT_OF_RANGE(value=3, what='goal')\n"
        called = Called(text, codel())
        self.assertEqual(called(), "::demo::OUT_OF_RANGE")
        self.assertEqual(called.details, [b"\0\0\0\0\0\0\x08@goal\0\0\0\0"])
        called = Called("from demo_types import *\ndef f():\n    raise MOVING\n", codel())
        self.assertEqual((called(), called.details, called.logged), ("::demo::MOVING", [], []))

    def test_another_exception_is_told_with_its_lines(self) -> None:
        called = Called("def g():\n    return 1 / 0\ndef f():\n    g()\n", codel())
        self.assertEqual(called(), "::genom::unkex")
        self.assertTrue(called.details[0].startswith(b"ZeroDivisionError: division by zero (demo.py:2)\0"))
        told = called.logged[0]
        for line in ["codel f (demo.gen:5) of service go", "line 4, in f", "g()", "line 2, in g"]:
            self.assertIn(line, told)
        called = Called("import sys\ndef f():\n    sys.exit(3)\n", codel())
        self.assertEqual(called(), "::genom::unkex")

    def test_what_is_returned_at_run_time_and_is_no_event_is_told(self) -> None:
        for value in ["'mian'", "3", "[]", "None"]:
            text = f"x = {value}\ndef f():\n    return x\n"
            called = Called(text, codel(yields=["main", "ether"]))
            self.assertEqual(called(), "::genom::unkex")
            self.assertIn("/nowhere/demo.py:2, returned", called.logged[0])
            self.assertIn("it may return 'main', 'ether'", called.logged[0])

    def test_threads_that_come_and_go_call_it(self) -> None:
        called = Called("def f():\n    pass\n", codel())
        # As threads that Python does not know.
        library, thread = ctypes.CDLL(None), ctypes.c_ulong()
        start = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)(called.answer["functions"]["f"])
        for _ in range(20):
            context = ctypes.addressof(called.context)
            self.assertEqual(library.pthread_create(ctypes.byref(thread), None, start, ctypes.c_void_p(context)), 0)
            self.assertEqual(library.pthread_join(thread, None), 0)
        self.assertEqual(called.logged, [])


    def test_a_codel_that_does_not_return_is_found(self) -> None:
        text = "def f():\n    ready.set()\n    end.wait()\n"
        text = "import threading\nready, end = threading.Event(), threading.Event()\n" + text
        called = Called(text, codel())
        scope = called.scope
        thread = threading.Thread(target=called)
        thread.start()
        scope["ready"].wait()
        told = where("f")
        scope["end"].set()
        thread.join()
        self.assertIn("codel f has not returned, and is here:", str(told))
        self.assertIn('demo.py", line 5, in f\n    end.wait()', str(told))
        self.assertIsNone(where("f"))


class Ports(unittest.TestCase):
    def test_an_out_port_publishes_what_is_in_its_buffer(self) -> None:
        buffer, written = (ctypes.c_double * 2)(), []
        handle = Handle(lambda _: ctypes.addressof(buffer), lambda _: written.append(list(buffer)))
        text = (
            "from demo_types import state\ndef f(where):\n    where.data.position = 1\n"
            "    where.write()\n    where.write(state(velocity=2))\n    where.data = {'position': 3}\n"
            "    where.write()\n"
        )
        called = Called(text, codel(port(0)))
        for _ in range(2):
            self.assertEqual((called(pointer(handle.table)), called.logged), (None, []))
        self.assertEqual(written[:3], [[1, 0], [0, 2], [3, 2]])

    def test_an_in_port_has_the_last_value_or_none(self) -> None:
        value, event = ctypes.c_double(2.5), ctypes.create_string_buffer(b"::genom::no_such_inport")
        seen: List[Any] = [0, None]
        handle = Handle(lambda _: seen[0], lambda _: seen[1])
        text = (
            "from genom.codel import Raised\ndef f(gain, n):\n"
            "    n.value = int(10 * (gain.latest() or -1))\n    gain.read()\n"
        )
        called, n = Called(text, codel(port(1), data("n", "out", 1))), ctypes.c_int32()
        for at, fails, got in [(0, False, -10), (ctypes.addressof(value), False, 25), (0, True, -10)]:
            seen[:] = [at, ctypes.addressof(event) if fails else None]
            # What a port raised is what the codel returns.
            prototype = ctypes.CFUNCTYPE(ctypes.c_void_p, *[ctypes.c_void_p] * 3)
            function = prototype(called.answer["functions"]["f"])
            arguments = pointer(handle.table), pointer(n), pointer(called.context)
            returned = function(*arguments)
            self.assertEqual((n.value, returned), (got, seen[1]))
        self.assertEqual(called.logged, [])

    def test_elements_of_a_multiple_port_are_opened_and_closed(self) -> None:
        buffers: Dict[bytes, Any] = {}
        written: List[Any] = []

        def place(name: bytes, _: int) -> int:
            return ctypes.addressof(buffers[name]) if name in buffers else 0

        handle = Handle(
            place,
            lambda name, _: written.append((name, buffers[name].value)),
            lambda name, _: buffers.update({name: ctypes.c_double()}),
            lambda name, _: buffers.pop(name) and None,
            named=True,
        )
        text = (
            "def f(ranges):\n    ranges.open('left')\n    ranges['left'].write(1.5)\n"
            "    ranges['left'].data = 2\n    ranges['left'].write()\n    ranges.close('left')\n"
            "    ranges['left'].data\n"
        )
        called = Called(text, codel(port(2)))
        self.assertEqual(called(pointer(handle.table)), "::genom::unkex")
        self.assertIn("port ranges has no element 'left': open it", called.logged[0])
        self.assertEqual(written, [(b"left", 1.5), (b"left", 2.0)])


class Remotes(unittest.TestCase):
    def test_a_service_of_another_component_is_a_function_with_named_inputs(self) -> None:
        prototype = ctypes.CFUNCTYPE(
            ctypes.c_void_p, ctypes.c_double, ctypes.c_uint32, *[ctypes.c_void_p] * 4
        )
        seen: List[Any] = []
        refusal = ctypes.create_string_buffer(b"::demo::OUT_OF_RANGE")

        def ask(goal: float, speed: int, begin: int, path: int, end: int, _: int) -> int:
            if goal < 0:
                return ctypes.addressof(refusal)
            buffer = ctypes.c_void_p.from_address(path + 8).value or 0
            seen.append((goal, speed, ctypes.c_double.from_address(begin).value, buffer != 0))
            ctypes.c_int32.from_address(buffer).value = 9
            ctypes.c_double.from_address(end + 8).value = 4.0
            return 0

        made = prototype(ask)
        table = ctypes.c_void_p(ctypes.cast(made, ctypes.c_void_p).value)
        parameter = {
            "name": "ask", "place": "demo.gen:7", "from": "remote", "rank": 0, "direction": "in",
            "type": 5,
        }
        text = (
            "from demo_types import *\ndef f(ask, goal):\n    told = ask(goal=goal, speed=FAST, "
            "from_=state(position=3), path=[1, 2])\n    assert list(told.path) == [9, 2]\n"
            "    assert told.end.velocity == 4\n    try: ask(goal=1, sped=1)\n"
            "    except TypeError as error: assert 'did you mean `speed`' in str(error)\n"
        )
        called = Called(text, codel(parameter, data("goal", "in", 0)))
        self.assertEqual((called(pointer(table), ctypes.c_double(2)), called.logged), (None, []))
        self.assertEqual(seen, [(2.0, 1, 3.0, True)])
        text = (
            "from demo_types import *\ndef f(ask, goal):\n    try:\n        ask(goal=goal, speed=0, "
            "from_={}, path=[])\n    except OUT_OF_RANGE as error:\n"
            "        assert (error.value, error.what) == (0.0, 'goal')\n        raise MOVING\n"
        )
        called = Called(text, codel(parameter, data("goal", "in", 0)))
        detail = ctypes.create_string_buffer(b"\0" * 8 + b"goal", 16)
        called.recorded = (ctypes.addressof(refusal), ctypes.addressof(detail))
        event = called(pointer(table), ctypes.c_double(-2))
        self.assertEqual((event, called.logged), ("::demo::MOVING", []))


class Refused(unittest.TestCase):
    def assert_refused(self, text: str, one: Dict[str, Any], *told: str, **more: Any) -> None:
        self.assertEqual(refused(text, one, **more), list(told))

    def test_names_and_parameters(self) -> None:
        one = codel(data("goal", "in", 0), yields=["ether"])
        head = "codel `f` (demo.gen:5)"
        self.assert_refused("def g(): pass\n", one, f"{head} is not defined; there are: g")
        self.assert_refused("f = 3\n", one, f"{head} is a int here, not a function (def)")
        self.assert_refused(
            "\ndef f(gaol):\n    return 'ether'\n", one,
            f"{head}, line 2: the description has no parameter `gaol`; did you mean `goal`?",
            f"{head}, line 2: it does not take parameter `goal` (demo.gen:7)",
        )
        self.assert_refused(
            "def f(goal, *rest):\n    return 'ether'\n", one,
            f"{head}, line 1: it takes any number of arguments (`*rest`): name those of the description",
        )
        self.assertIn("functions", Called("def f(goal, gain=2, *, x=1):\n    return 'ether'\n", one).answer)

    def test_annotations(self) -> None:
        one = codel(data("goal", "in", 0), data("state", "inout", 5), data("n", "out", 1), yields=["ether"])
        head = "codel `f` (demo.gen:5), line 2"
        text = "from demo_types import state as S, ids\ndef f(goal: {}, state: {}, n: {}):\n    return 'ether'\n"
        self.assertIn("functions", Called(text.format("float", "S", "object"), one).answer)
        self.assertIn("functions", Called(text.format("'float'", "'S'", "'object'"), one).answer)
        self.assert_refused(
            text.format("str", "ids", "int"), one,
            f"{head}: parameter `goal` is annotated str, and is a double (demo.gen:7)",
            f"{head}: parameter `state` is annotated ids, and is a demo::state (demo.gen:7)",
            f"{head}: parameter `n` is annotated int, and is a place for a long: use its member "
            "`value` (demo.gen:7)",
        )

    def test_what_is_seen_to_be_returned(self) -> None:
        one, head = codel(yields=["main", "ether"]), "codel `f` (demo.gen:5), line"
        may = "it may yield main, ether"
        self.assert_refused("def f():\n    return 'mian'\n", one, f"{head} 2: it returns 'mian'; {may}")
        self.assert_refused(
            "def f():\n    if 1:\n        return\n    return 'x' if 2 else 'main'\n", one,
            f"{head} 3: it returns None; {may}", f"{head} 4: it returns 'x'; {may}",
        )
        ends = f"{head} 1: it may end without a `return`; {may}"
        for body in ["pass", "if x: return 'main'", "for i in x: return 'main'",
                     "while True: break", "try: return 'main'\n    except E: pass"]:
            self.assert_refused(f"def f():\n    {body}\n", one, ends)
        for body in ["while True: x()", "raise E", "with x: return 'main'",
                     "if x: return 'main'\n    else: return 'ether'",
                     "try: x()\n    finally: return 'main'"]:
            self.assertIn("functions", Called(f"def f():\n    {body}\n", one).answer, body)
        self.assert_refused(
            "def f():\n    return 'ok'\n", codel(),
            f"{head} 2: it returns 'ok'; it may return nothing: what is refused is raised",
        )

    def test_a_literal_of_the_result_names_events_that_it_may_yield(self) -> None:
        head = "codel `f` (demo.gen:5), line 2: its annotation says that it returns"
        text = "from typing import Literal\ndef f() -> {}:\n    return g()\n"
        one = codel(yields=["main", "ether"])
        for fits in ["Literal['ether']", "\"Literal['main', 'ether']\"", "str"]:
            self.assertIn("functions", Called(text.format(fits), one).answer, fits)
        self.assert_refused(
            text.format("Literal['mian', 'ether', None]"), one,
            f"{head} 'mian'; it may yield main, ether", f"{head} None; it may yield main, ether",
        )
        self.assert_refused(
            text.format("\"Literal['ether']\""), codel(),
            f"{head} 'ether'; it may return nothing: what is refused is raised",
        )

    def test_what_would_return_no_event_at_once(self) -> None:
        head = "codel `f` (demo.gen:5), line 1: it"
        waits = f"{head} is `async`: a codel returns its event at once"
        yields = f"{head} has a `yield`: a codel returns its event, and is called again"
        one = codel(yields=["ether"])
        self.assert_refused("async def f():\n    return 'ether'\n", one, waits)
        self.assert_refused("async def f():\n    yield 1\n    raise E\n", one, waits)
        self.assert_refused("def f():\n    yield 'main'\n    return 'ether'\n", one, yields)
        # Of a function inside, it is none of the codel's.
        inner = "def f():\n    def inner():\n        yield 1\n    return 'ether'\n"
        self.assertIn("functions", Called(inner, one).answer)

    def test_a_script_that_does_not_run_through(self) -> None:
        told = (
            "line 2: the script is here after 0.2 s (start_timeout), and has not run through: what "
            "takes longer, or goes on, belongs into a codel"
        )
        self.assert_refused("\nwhile True: pass\ndef f(): pass\n", codel(), told, seconds=0.2)
        # Nothing of it goes on.
        for one in threading.enumerate():
            if one.name == "script":
                one.join(WATCHDOG)
                self.assertFalse(one.is_alive())

    def test_a_script_that_does_not_run(self) -> None:
        self.assert_refused("\ndef f(:\n", codel(), "line 2: invalid syntax")
        self.assert_refused("\nimport nothing_at_all\n", codel(), "line 2: ModuleNotFoundError: No module named 'nothing_at_all'")
        self.assert_refused("import sys\nsys.exit(3)\n", codel(), "line 2: SystemExit: 3")
        self.assert_refused("async def f(): pass\n", codel(), "codel `f` (demo.gen:5), line 1: it is `async`: a codel returns its event at once")


if __name__ == "__main__":
    unittest.main()
