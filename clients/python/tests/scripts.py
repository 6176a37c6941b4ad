"""Scripts with one codel, which is called as genomd calls it: for tests without a daemon."""

import ctypes
import json
from typing import Any, Dict, List, Optional

from genom.runner._loader import Loader

# Only a hanging test takes so many seconds.
WATCHDOG = 50.0

DOUBLE = {"kind": "double", "name": "double", "size": 8, "align": 8, "fixed": True}
LONG = {"kind": "long", "name": "long", "size": 4, "align": 4, "fixed": True}
TEXT = {"kind": "string", "name": "string<8>", "size": 8, "align": 1, "fixed": True, "bound": 8}
BOOLEAN = {"kind": "boolean", "name": "boolean", "size": 1, "align": 1, "fixed": True}
SPEED = {
    "kind": "enum", "name": "::demo::speed", "full_name": "::demo::speed", "size": 4, "align": 4,
    "fixed": True, "enumerators": ["SLOW", "FAST"],
}
STATE = {
    "kind": "struct", "name": "::demo::state", "full_name": "::demo::state", "size": 16, "align": 8,
    "fixed": True,
    "members": [
        {"name": "position", "offset": 0, "type": 0},
        {"name": "velocity", "offset": 8, "type": 0},
    ],
}
JOINTS = {
    "kind": "array", "name": "double[3]", "size": 24, "align": 8, "fixed": True, "length": 3,
    "element": 0,
}
PATH = {
    "kind": "sequence", "name": "sequence<long>", "size": 24, "align": 8, "fixed": False,
    "bound": None, "element": 1, "offsets": [0, 4, 8, 16],
}
STEPS = {
    "kind": "sequence", "name": "sequence<::demo::state, 2>", "size": 40, "align": 8, "fixed": True,
    "bound": 2, "element": 5, "offsets": [0, 4, 8],
}
MAYBE = {
    "kind": "optional", "name": "optional<double>", "size": 16, "align": 8, "fixed": True,
    "element": 0, "offsets": [8],
}
IDS: Dict[str, Any] = {
    "kind": "struct", "name": "::demo::ids", "full_name": "::demo::ids", "size": 168, "align": 8,
    "fixed": False,
    "members": [
        {"name": "velocity", "offset": 0, "type": 0},
        {"name": "count", "offset": 8, "type": 1},
        {"name": "speed", "offset": 12, "type": 4},
        {"name": "current", "offset": 16, "type": 5},
        {"name": "joints", "offset": 32, "type": 6},
        {"name": "path", "offset": 56, "type": 7},
        {"name": "steps", "offset": 80, "type": 8},
        {"name": "maybe", "offset": 120, "type": 9},
        {"name": "name", "offset": 136, "type": 2},
        {"name": "from", "offset": 144, "type": 0},
        {"name": "halted", "offset": 152, "type": 3},
        {"name": "last", "offset": 160, "type": 0},
    ],
}
RANGE = {
    "kind": "exception", "name": "::demo::OUT_OF_RANGE", "full_name": "::demo::OUT_OF_RANGE",
    "size": 16, "align": 8, "fixed": True,
    "members": [{"name": "value", "offset": 0, "type": 0}, {"name": "what", "offset": 8, "type": 2}],
}
MATRIX = {
    "kind": "array", "name": "double[2][3]", "size": 48, "align": 8, "fixed": True, "length": 2,
    "element": 6,
}
TYPES: List[Dict[str, Any]] = [
    DOUBLE, LONG, TEXT, BOOLEAN, SPEED, STATE, JOINTS, PATH, STEPS, MAYBE, IDS, RANGE, MATRIX,
]


PORTS = [
    {"name": "where", "out": True, "multiple": False, "type": 5},
    {"name": "gain", "out": False, "multiple": False, "type": 0},
    {"name": "ranges", "out": True, "multiple": True, "type": 0},
    {"name": "poses", "out": True, "multiple": False, "type": 12},
    {"name": "grid", "out": False, "multiple": False, "type": 12},
]


REMOTE = {
    "name": "ask",
    "parameters": [
        {"name": "goal", "direction": "in", "type": 0},
        {"name": "speed", "direction": "in", "type": 4},
        {"name": "from", "direction": "in", "type": 5},
        {"name": "path", "direction": "inout", "type": 7},
        {"name": "end", "direction": "out", "type": 5},
    ],
}


def port(rank: int) -> Dict[str, Any]:
    one = PORTS[rank]
    return {
        "name": one["name"], "place": "demo.gen:7", "from": "port", "rank": rank,
        "direction": "out" if one["out"] else "in", "type": one["type"],
    }


def data(name: str, direction: str, rank: int) -> Dict[str, Any]:
    return {
        "name": name, "place": "demo.gen:7", "from": "data", "rank": None, "direction": direction,
        "type": rank,
    }


def codel(*parameters: Dict[str, Any], yields: Optional[List[str]] = None) -> Dict[str, Any]:
    return {
        "name": "f", "place": "demo.gen:5", "owner": "service go", "yields": yields,
        "parameters": list(parameters),
    }


def request(
    text: str, one: Dict[str, Any], types: List[Dict[str, Any]] = TYPES, seconds: float = 60.0
) -> bytes:
    """A request to load a script, which has to run through in so many seconds."""
    return json.dumps(
        {
            "path": "/nowhere/demo.py", "text": text, "component": "demo", "place": "demo.gen:1",
            "seconds": seconds,
            "codels": [one], "ports": PORTS, "remotes": [REMOTE],
            "exceptions": [
                {"event": "::demo::OUT_OF_RANGE", "name": ["demo", "OUT_OF_RANGE"], "type": 11},
                {"event": "::demo::MOVING", "name": ["demo", "MOVING"], "type": None},
            ],
            "declared": [
                {"name": ["demo", "speed"], "type": 4}, {"name": ["demo", "state"], "type": 5},
                {"name": ["demo", "ids"], "type": 10},
            ],
            "constants": [{"name": ["demo", "LIMIT"], "value": 5}],
            "types": types,
        }
    ).encode()


class Context(ctypes.Structure):
    """What genomd passes to codels, recording what is raised."""

    _fields_ = [("raise_", ctypes.c_void_p), ("raised", ctypes.c_void_p), ("data", ctypes.c_void_p)]


class Called:
    """A script with one codel, to be called with memory of its own."""

    def __init__(self, text: str, one: Dict[str, Any], **more: Any) -> None:
        self.logged: List[str] = []
        self.loader = Loader(self.logged.append)
        self.answer = json.loads(self.loader.load(request(text, one, **more)))
        self.details: List[bytes] = []
        prototype = ctypes.CFUNCTYPE(
            ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p
        )

        def record(event: int, detail: int, size: int, _: int) -> int:
            self.details.append(ctypes.string_at(detail, size))
            return event

        def raised(event: int, _: int) -> Any:
            ctypes.c_void_p.from_address(event).value = self.recorded[0]
            return self.recorded[1]

        self.recorded: Any = (None, None)
        self._record = prototype(record)
        self._raised = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(raised)
        places = (ctypes.cast(one, ctypes.c_void_p).value for one in (self._record, self._raised))
        self.context = Context(*places, None)

    @property
    def scope(self) -> Dict[str, Any]:
        """What the script has defined, to which a test may add."""
        scope: Dict[str, Any] = self.loader._kept[self.answer["number"]][-1]
        return scope

    def __call__(self, *arguments: Any) -> Optional[str]:
        classes = [type(one) for one in arguments]
        prototype = ctypes.CFUNCTYPE(ctypes.c_void_p, *classes, ctypes.c_void_p)
        function = prototype(self.answer["functions"]["f"])
        event = function(*arguments, ctypes.addressof(self.context))
        if event:
            within = self.answer["events"]
            assert within["start"] <= event < within["end"]
        return ctypes.string_at(event).decode() if event else None


class Handle:
    """The handle of a port, whose functions do what a test says."""

    def __init__(self, *functions: Any, named: bool = False) -> None:
        classes = [ctypes.c_char_p, ctypes.c_void_p] if named else [ctypes.c_void_p]
        prototype = ctypes.CFUNCTYPE(ctypes.c_void_p, *classes)
        self._made = [prototype(function) for function in functions]
        places = (ctypes.cast(one, ctypes.c_void_p).value for one in self._made)
        self.table = (ctypes.c_void_p * len(functions))(*places)


def refused(text: str, one: Dict[str, Any], **more: Any) -> List[str]:
    return list(Called(text, one, **more).answer["errors"])


def pointer(memory: Any) -> ctypes.c_void_p:
    return ctypes.c_void_p(ctypes.addressof(memory))
