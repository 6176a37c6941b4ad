"""Structs and unions as views of their memory: attributes are their members."""

from __future__ import annotations

import ctypes
import difflib
import keyword
from operator import attrgetter
from typing import Any, Callable, Dict, List, Sequence, Tuple

from . import _kept
from ._kinds import Enum, Kind, Made, Number


def python_name(name: str) -> str:
    """A valid Python name: keywords get an underscore."""
    return name + "_" if keyword.iskeyword(name) else name


class View(ctypes.Structure):
    """A struct in memory. It has no other attributes than its members."""

    __slots__ = ("_owner",)
    _names: Tuple[str, ...] = ()
    _kind: Any = None

    def __init__(self, **members: Any) -> None:
        """A value of its own, empty but for the members given."""
        super().__init__()
        for name, value in members.items():
            if name not in self._names:
                raise AttributeError(f"{self._kind.name} has no member `{name}`{meant(name, self._names)}")
            setattr(self, name, value)

    def __eq__(self, other: Any) -> bool:
        if not isinstance(other, View) or self._kind is not other._kind:
            return NotImplemented
        return all(_same(getattr(self, name), getattr(other, name)) for name in self._names)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        members = ", ".join(f"{name}={getattr(self, name)!r}" for name in self._names)
        return f"{self._kind.name.rsplit('::', 1)[-1]}({members})"


def _same(one: Any, other: Any) -> bool:
    equal = one == other
    return bool(equal.all()) if hasattr(equal, "all") else bool(equal)


def meant(typed: str, names: Sequence[str]) -> str:
    """A suggestion to append to a message."""
    near = difflib.get_close_matches(typed, names, 1)
    if near:
        return f"; did you mean `{near[0]}`?"
    return f"; there are: {', '.join(names)}" if names else "; there is none"


class Record(Kind):
    """A struct, or the detail of an exception."""

    def __init__(self, one: Dict[str, Any], kinds: Sequence[Kind]) -> None:
        super().__init__(one)
        self._kinds = kinds
        self.members: List[Tuple[str, int, int]] = [
            (python_name(m["name"]), m["offset"], m["type"]) for m in one["members"]
        ]
        # As the description has them.
        self.given_names: List[str] = [m["name"] for m in one["members"]]
        self._classes: Dict[bool, Any] = {}

    def ctype(self, const: bool) -> Any:
        return self.view(const)

    def view(self, const: bool) -> Any:
        """The class of views; with `const`, of such as cannot be changed."""
        made = self._classes.get(const)
        if made is None:
            made = self._classes[const] = self._make(const)
        return made

    def _make(self, const: bool) -> Any:
        fields, body = [], {"__slots__": (), "_kind": self}
        body["_names"] = tuple(name for name, _, _ in self.members)
        for name, offset, rank in self.members:
            kind = self._kinds[rank]
            plain = isinstance(kind, Number) and kind.range is None and not const
            # ctypes checks these itself, and nothing is faster.
            private = name if plain else f"_{name}_in_c"
            fields.append((private, kind.ctype(const)))
            if not plain:
                body[name] = _member(kind, name, private, offset, const)
        made = type(self.name.rsplit("::", 1)[-1], (View,), body)
        made._fields_ = fields  # type: ignore[attr-defined]
        for (private, _), (name, offset, _) in zip(fields, self.members):
            if getattr(made, private).offset != offset:
                raise TypeError(f"{self.name}.{name} lies elsewhere here")
        if (ctypes.sizeof(made), ctypes.alignment(made)) != (self.size, self.align):
            raise TypeError(f"{self.name} has another size here")
        return made

    def get(self, address: int, const: bool, owner: Any) -> Any:
        made = self.view(const).from_address(address)
        made._owner = owner
        return _kept.give(made) if owner is None and _kept.watching else made

    def put(self, address: int, value: Any) -> None:
        if isinstance(value, View) and value._kind is self:
            if self.fixed:
                ctypes.memmove(address, ctypes.addressof(value), self.size)
                return
            value = {name: getattr(value, name) for name in value._names}
        if not isinstance(value, dict):
            raise TypeError(f"a {self.name} is needed, or a dict of its members, not {value!r}")
        places = {name: (offset, rank) for name, offset, rank in self.members}
        for name, one in value.items():
            if name not in places:
                raise ValueError(f"{self.name} has no member `{name}`{meant(name, list(places))}")
            offset, rank = places[name]
            self._kinds[rank].put(address + offset, one)

    def empty(self, address: int) -> None:
        for _, offset, rank in self.members:
            self._kinds[rank].empty(address + offset)

    def annotation(self) -> Any:
        return self.view(False)


def _member(kind: Kind, name: str, private: str, offset: int, const: bool) -> property:
    """The attribute for a member that ctypes alone cannot read or write."""
    address_of = ctypes.addressof
    if isinstance(kind, (Number, Record)):
        read: Callable[[Any], Any] = attrgetter(private)
    elif isinstance(kind, Enum):
        number, given = attrgetter(private), kind.given

        def read(view: Any) -> Any:
            return given(number(view))
    else:

        def read(view: Any) -> Any:
            try:
                owner = view if view._owner is not None else None
            except AttributeError:
                # Neither a view of memory elsewhere, nor a part of one: it owns its memory.
                owner = view
            return kind.get(address_of(view) + offset, const, owner)

    if const:
        return property(read)
    if isinstance(kind, (Number, Enum)):
        checked = kind.checked

        def write_number(view: Any, value: Any) -> None:
            setattr(view, private, checked(value))

        return property(read, write_number)

    def write(view: Any, value: Any) -> None:
        try:
            kind.put(address_of(view) + offset, value)
        except (TypeError, ValueError) as error:
            # Subclasses may want other arguments.
            base = TypeError if isinstance(error, TypeError) else ValueError
            raise base(f"{name}: {error}") from None

    return property(read, write)


class UnionView:
    """A union in memory: `d` says which member it has."""

    __slots__ = ("_kind", "_at", "_const", "_owner")

    def __init__(self, kind: "Union_", at: int, const: bool, owner: Any) -> None:
        for name, value in zip(self.__slots__, (kind, at, const, owner)):
            object.__setattr__(self, name, value)
        if owner is None and _kept.watching:
            _kept.give(self)

    def __getattr__(self, name: str) -> Any:
        kind, const = self._kind, self._const
        if name == "d":
            return kind.switch.get(self._at, const, self._owner)
        return kind.member(self._at, name).get(self._at + kind.inner_at, const, self._owner)

    def __setattr__(self, name: str, value: Any) -> None:
        if self._const:
            raise TypeError("an `in` argument cannot be changed")
        kind = self._kind
        if name == "d":
            kind.choose(self._at, value)
            return
        kind.member(self._at, name).put(self._at + kind.inner_at, value)


class Union_(Kind):
    """One of several values, chosen by a discriminant."""

    def __init__(self, one: Dict[str, Any], kinds: Sequence[Kind]) -> None:
        super().__init__(one)
        self._kinds: Sequence[Kind] = kinds
        self._switch: int = one["discriminant"]
        self.inner_at: int = one["members"][0]["offset"]
        self._members: Dict[str, int] = {
            python_name(m["name"]): m["type"] for m in one["members"]
        }
        self._chosen = {
            label: python_name(m["name"]) for m in one["members"] for label in m["labels"]
        }

    @property
    def switch(self) -> Kind:
        return self._kinds[self._switch]

    def chosen(self, address: int) -> Any:
        """Name of the member that it has."""
        value = self.switch.get(address, True, None)
        value = ord(value) if isinstance(value, str) else int(value)
        return self._chosen.get(value, self._chosen.get(None))

    def member(self, address: int, name: str) -> Kind:
        """The type of a member, if the union has that one now."""
        if name not in self._members:
            raise AttributeError(f"{self.name} has no member `{name}`{meant(name, list(self._members))}")
        if name != self.chosen(address):
            raise AttributeError(f"{self.name} has `{self.chosen(address)}` now, not `{name}`: set d")
        return self._kinds[self._members[name]]

    def choose(self, address: int, value: Any) -> None:
        """Sets the discriminant; another member is empty."""
        before = self.chosen(address)
        if before is not None:
            self._kinds[self._members[before]].empty(address + self.inner_at)
        self.switch.put(address, value)
        ctypes.memset(address + self.inner_at, 0, self.size - self.inner_at)

    def get(self, address: int, const: bool, owner: Any) -> Any:
        return UnionView(self, address, const, owner)

    def put(self, address: int, value: Any) -> None:
        if isinstance(value, UnionView) and value._kind is self:
            name = self.chosen(value._at)
            value = {"d": value.d, **({} if name is None else {name: getattr(value, name)})}
        if not isinstance(value, dict) or "d" not in value:
            raise TypeError(f"a {self.name} is needed, or a dict with `d`, not {value!r}")
        # Made elsewhere first: the value may be a view of this union, or not be stored.
        made = Made(self, 1)
        try:
            self.choose(made.address, value["d"])
            for name, one in value.items():
                if name != "d":
                    self.member(made.address, name).put(made.address + self.inner_at, one)
        except BaseException:
            self.empty(made.address)
            raise
        self.empty(address)
        made.move_to(address)

    def annotation(self) -> Any:
        return UnionView

    def empty(self, address: int) -> None:
        self.choose(address, self.switch.get(address, True, None))
