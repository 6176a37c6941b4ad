"""Stubs of components, for editors and type checkers: ``python -m genom.stubs demo -o typings``.

    from typing import TYPE_CHECKING, cast
    if TYPE_CHECKING:
        from demo import Demo        # typings/demo.pyi
    demo = cast("Demo", g.load("demo"))
"""

from __future__ import annotations

import argparse
import keyword
import os
import re
from typing import Any, Dict, List, Optional, Sequence

from . import _signature
from ._http import url
from .client import Client, connect
from .component import Component

_PLAIN = {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "null": "None"}
_HEAD = '''"""Component {name}, as `python -m genom.stubs` found it."""

from typing import Any, Callable, Dict, List, Literal, Optional, Sequence, Type, TypedDict, Union, overload

import genom
from genom.component import Described

'''
_CALLED = "callback: Callable[[genom.Activity], object]"


class Stub:
    """Generates the stub of one component."""

    def __init__(self, component: Component) -> None:
        self._description = component._description
        path = url("components", component.name, "schema")
        self._schema = component._client._transport.request("GET", path)
        # Types by their Python names, in the order of their definitions.
        self._types: Dict[str, List[str]] = {}

    def text(self) -> str:
        """The text of the stub."""
        services = [line for one in self._description["services"] for line in self._service(one)]
        ports: List[str] = []
        classes: List[str] = []
        for one in self._description["ports"]:
            name = _class(one["name"]) + "Port"
            ports.append(_member(f"{one['name']}: {name}", one["name"]))
            classes += self._port(name, one)
        thrown = {name for one in self._description["services"] for name in one["throws"]}
        errors = {name.rsplit("::", 1)[-1] for name in thrown}
        body = [f"    {name}: Type[genom.GenoMError]" for name in sorted(errors)]
        events = [f"    def {name}(self) -> None: ..." for name in self._description.get("events", [])]
        title = _class(self._description["name"])
        title = f"class {title}{'_' if title in self._types else ''}(Described):"
        doc = _doc(self._description.get("doc"), "    ")
        types = [line for lines in self._types.values() for line in lines]
        lines = [*types, *classes, title, *doc, *body, *ports, *events, *services]
        return _HEAD.format(name=self._description["name"]) + "\n".join(lines) + "\n"

    def _service(self, service: Dict[str, Any]) -> List[str]:
        schema = self._schema["services"].get(service["name"], {})
        given = schema.get("input", {})
        inputs = []
        for parameter in _signature.signature(service).parameters.values():
            if parameter.name in _signature.FLAGS and parameter.default in (False, None):
                continue
            name = next(
                one["name"] for one in _signature.inputs(service)
                if _signature.python_name(one["name"]) == parameter.name
            )
            annotation = self._type(given.get("properties", {}).get(name, {}), given, True)
            default = "" if parameter.default is parameter.empty else " = ..."
            # All parameters after a star are keyword-only.
            star = parameter.kind is parameter.KEYWORD_ONLY and "*" not in inputs
            inputs += ["*"] if star else []
            inputs.append(f"{parameter.name}: {annotation}{default}")
        star_too = [] if "*" in inputs else ["*"]
        result = self._type(schema.get("output", {}), schema.get("output", {}), False, service["name"])
        name = service["name"]
        lines = []
        for flags, returns in (
            (["ack: Literal[False] = ...", "send: Literal[False] = ...", "callback: None = ..."], result),
            (["ack: Literal[True]", "send: bool = ...", f"{_CALLED} = ..."], "genom.Activity"),
            (["send: Literal[True]", "ack: bool = ...", f"{_CALLED} = ..."], "genom.Activity"),
            ([_CALLED, "ack: bool = ...", "send: bool = ..."], "genom.Activity"),
        ):
            listed = ", ".join(["self", *inputs, *star_too, *flags, "zero: bool = ..."])
            lines.append("    @overload")
            # The first overload carries the documentation.
            doc = _doc(service.get("doc"), "        ") if not lines[1:] else []
            lines.append(_member(f"def {name}({listed}) -> {returns}:{'' if doc else ' ...'}", name))
            lines += doc
        return lines

    def _port(self, name: str, port: Dict[str, Any]) -> List[str]:
        schema = self._schema.get("ports", {}).get(port["name"], {})
        schema = schema.get("value", schema.get("schema", schema))
        value = self._type(schema, schema, False)
        element = "element: Optional[str] = ..."
        return [
            f"class {name}(genom.Port):",
            *_doc(port.get("doc"), "    "),
            f"    def read(self, {element}) -> Optional[{value}]: ...",
            "",
        ]

    def _type(
        self, schema: Dict[str, Any], whole: Dict[str, Any], given: bool, name: str = ""
    ) -> str:
        """The Python type for a schema; with `given`, as an input."""
        if "$ref" in schema:
            key = str(schema["$ref"]).rsplit("/", 1)[-1]
            spelled = _class(key)
            if spelled not in self._types:
                self._types[spelled] = []
                self._types[spelled] = self._record(spelled, whole["$defs"][key], whole)
            return spelled
        if "enum" in schema:
            values = [value for value in schema["enum"] if value is not None]
            return f"Literal[{', '.join(repr(value) for value in values)}]" if values else "None"
        for several in ("anyOf", "oneOf"):
            if several in schema:
                return self._union(schema[several], whole, given)
        kind = schema.get("type")
        if kind == "array":
            items = schema.get("items")
            inner = self._type(items, whole, given) if isinstance(items, dict) else "Any"
            return f"{'Sequence' if given else 'List'}[{inner}]"
        if kind == "object" and schema.get("properties"):
            spelled = _class(name) + "Outputs" if name else ""
            if not spelled:
                return "Dict[str, Any]"
            self._types.setdefault(spelled, self._record(spelled, schema, whole))
            return spelled
        return _PLAIN.get(str(kind), "Dict[str, Any]" if kind == "object" else "Any")

    def _union(self, schemas: Sequence[Dict[str, Any]], whole: Dict[str, Any], given: bool) -> str:
        # NaN and infinities, which JSON does not have, are numbers here.
        if any(one.get("type") == "number" for one in schemas):
            return "float"
        # Arrays may also be given by index; that form is left out.
        wanted = [one for one in schemas if "patternProperties" not in one]
        spelled = [self._type(one, whole, given) for one in wanted]
        others = list(dict.fromkeys(one for one in spelled if one != "None"))
        text = others[0] if len(others) == 1 else f"Union[{', '.join(others)}]"
        return f"Optional[{text}]" if len(others) < len(set(spelled)) else text

    def _record(self, name: str, schema: Dict[str, Any], whole: Dict[str, Any]) -> List[str]:
        if not schema.get("properties"):
            return [f"{name} = {self._type(schema, whole, False)}", ""]
        # The same class serves for inputs and outputs, so that any sequence is accepted.
        members = {key: self._type(one, whole, True) for key, one in schema["properties"].items()}
        if any(keyword.iskeyword(key) for key in members):
            listed = ", ".join(f"{key!r}: {kind}" for key, kind in members.items())
            return [f"{name} = TypedDict({name!r}, {{{listed}}}, total=False)", ""]
        lines = [f"class {name}(TypedDict, total=False):"]
        return [*lines, *(f"    {key}: {kind}" for key, kind in members.items()), ""]


def stub(component: Component) -> str:
    """The stub of a component, as text of a ``.pyi`` file."""
    return Stub(component).text()


def write(client: Client, names: Sequence[str], folder: str) -> List[str]:
    """Writes stubs of components (by default all running ones) to a directory; returns the files.
    """
    os.makedirs(folder, exist_ok=True)
    files = []
    for name in names or client.components():
        files.append(os.path.join(folder, f"{name}.pyi"))
        with open(files[-1], "w", encoding="utf-8") as file:
            file.write(stub(client.component(name)))
    return files


def _class(name: str) -> str:
    """The name of a class: ImageFrame for `image.frame`."""
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"\W+|_", name) if part)


def _doc(text: Optional[str], indent: str) -> List[str]:
    if not text:
        return []
    shown = text.replace("\\", "\\\\").replace('"""', "'''").replace("\n", "\n" + indent)
    return [f'{indent}"""{shown}"""']


def _member(text: str, name: str) -> str:
    """A member, whose name may be that of a member of every component."""
    clash = "  # type: ignore" if hasattr(Component, name) else ""
    return f"    {text}{clash}"


def main(words: Optional[Sequence[str]] = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m genom.stubs", description=__doc__.split("\n")[0])
    parser.add_argument("components", nargs="*", help="by default all that run")
    parser.add_argument("-o", "--output", default="typings", help="folder for the files")
    parser.add_argument("--daemon", help="as of genom.connect(); by default that of this user")
    given = parser.parse_args(words)
    with connect(given.daemon) as client:
        for file in write(client, given.components, given.output):
            print(file)


if __name__ == "__main__":
    main()
