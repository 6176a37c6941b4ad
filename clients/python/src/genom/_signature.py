"""Python signatures and documentation of services, from a component's description."""

from __future__ import annotations

import difflib
import inspect
import json
import keyword
from typing import Any, Dict, Iterable, List, Tuple

# Options of a call besides the inputs.
FLAGS = ("ack", "send", "zero", "callback")
_BASIC = {
    "boolean": bool,
    "char": str,
    "octet": int,
    "short": int,
    "long": int,
    "unsigned": int,
    "float": float,
    "double": float,
}


class _Kept:
    """Stands for a default: inputs of an attribute that are left out keep their present values."""

    def __repr__(self) -> str:
        return "?"


KEPT: Any = _Kept()


def annotation(idl: str) -> Any:
    """The Python type for an IDL type."""
    if "[" in idl or idl.startswith("sequence<"):
        return list
    if idl.startswith("string"):
        return str
    return _BASIC.get(idl.split(" ", 1)[0], Any)


def python_name(name: str) -> str:
    """A valid Python name: keywords get an underscore."""
    return name + "_" if keyword.iskeyword(name) else name


def inputs(service: Dict[str, Any]) -> List[Dict[str, Any]]:
    """The parameters that a caller passes."""
    return [one for one in service["parameters"] if one["direction"] in ("in", "inout")]


def _default(service: Dict[str, Any], parameter: Dict[str, Any]) -> Any:
    """The value of an input that is left out; None if it is required."""
    return KEPT if service["kind"] == "attribute" else parameter.get("default")


def signature(service: Dict[str, Any]) -> inspect.Signature:
    """The signature of the service."""
    listed = []
    optional = False
    for one in inputs(service):
        default = _default(service, one)
        optional = optional or default is not None
        # After a parameter with a default, Python requires those without to be keyword-only.
        by_name = optional and default is None
        listed.append(
            inspect.Parameter(
                python_name(one["name"]),
                inspect.Parameter.KEYWORD_ONLY if by_name else inspect.Parameter.POSITIONAL_OR_KEYWORD,
                default=inspect.Parameter.empty if default is None else default,
                annotation=annotation(one["type"]),
            )
        )
    listed.sort(key=lambda one: one.kind)
    taken = {one.name for one in listed}
    for flag in FLAGS:
        if flag not in taken:
            default = None if flag == "callback" else False
            listed.append(inspect.Parameter(flag, inspect.Parameter.KEYWORD_ONLY, default=default))
    return inspect.Signature(listed)


def document(service: Dict[str, Any]) -> str:
    """The documentation of a service."""
    lines = [service.get("doc") or f"{service['kind'].capitalize()} {service['name']}.", ""]
    for title, directions in (("Inputs", ("in", "inout")), ("Outputs", ("inout", "out"))):
        chosen = [one for one in service["parameters"] if one["direction"] in directions]
        if chosen:
            lines.append(title + ":")
            for one in chosen:
                line = f"    {one['name']}: {one['type']}"
                default = _default(service, one)
                if title == "Inputs" and default is not None:
                    line += " = ?" if default is KEPT else f" = {json.dumps(default)}"
                if one.get("doc"):
                    line += f"  ({one['doc']})"
                lines.append(line)
            lines.append("")
    if service.get("throws"):
        lines += ["Raises: " + ", ".join(service["throws"]), ""]
    if service.get("interrupts"):
        lines += ["Interrupts: " + ", ".join(service["interrupts"]), ""]
    return "\n".join(lines).rstrip() + "\n"


def bind(
    service: Dict[str, Any], args: Tuple[Any, ...], given: Dict[str, Any], zero: bool = False
) -> Dict[str, Any]:
    """The inputs of a call, by their names in the description.

    A single dict holds all inputs by name, unless it has other keys: it is then the value of the
    first input. With `zero` any input may be left out.
    """
    parameters = inputs(service)
    names = [one["name"] for one in parameters]
    if len(args) == 1 and not given and isinstance(args[0], dict) and set(args[0]) <= set(names):
        return dict(args[0])
    what = f"{service['name']}()"
    if len(args) > len(names):
        raise TypeError(f"{what} takes {len(names)} inputs, {len(args)} were given")
    values = dict(zip(names, args))
    known = {python_name(name): name for name in names}
    for key, value in given.items():
        name = known.get(key, key if key in names else None)
        if name is None:
            raise TypeError(f"{what} has no input `{key}`{meant(key, names)}")
        if name in values:
            raise TypeError(f"{what} got input `{name}` twice")
        values[name] = value
    for one in parameters:
        if one["name"] not in values and _default(service, one) is None and not zero:
            raise TypeError(f"{what} wants input `{one['name']}`, a {one['type']}")
    return values


def meant(typed: str, names: Iterable[str]) -> str:
    """A suggestion to append to a message."""
    listed = list(names)
    near = difflib.get_close_matches(typed, listed, 1)
    if near:
        return f"; did you mean `{near[0]}`?"
    return f"; there are: {', '.join(listed)}" if listed else "; there is none"
