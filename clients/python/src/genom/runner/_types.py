"""All types of a component, from what the daemon says of their memory."""

from __future__ import annotations

import ctypes
from typing import Any, Dict, List

from ._kinds import Char, Enum, Kind, Number, Optional_, Text, Unsupported
from ._lists import Array, SequenceKind
from ._numbers import NUMBERS
from ._records import Record, Union_


class Types:
    """The types of a component, by the numbers that the daemon gives them."""

    def __init__(self, listed: List[Dict[str, Any]]) -> None:
        self._listed = listed
        self.kinds: List[Kind] = []
        for one in listed:
            self.kinds.append(self._make(one))
        self._places: Dict[int, Any] = {}

    def __getitem__(self, rank: int) -> Kind:
        return self.kinds[rank]

    def _make(self, one: Dict[str, Any]) -> Kind:
        keyword = one["kind"]
        if keyword in NUMBERS:
            return Number(one)
        simple: Dict[str, Any] = {"char": Char, "enum": Enum, "string": Text}
        if keyword in simple:
            made: Kind = simple[keyword](one)
            return made
        several: Dict[str, Any] = {
            "struct": Record, "exception": Record, "union": Union_, "array": Array,
            "sequence": SequenceKind, "optional": Optional_,
        }
        if keyword not in several:
            return _Other(one)
        made = several[keyword](one, self.kinds)
        return made

    def argument(self, rank: int, const: bool) -> Any:
        """What makes the argument of a codel of an address."""
        kind = self.kinds[rank]
        if isinstance(kind, _Other):
            raise Unsupported(f"a {kind.keyword} is known to codels in C only")
        if isinstance(kind, (Number, Char, Enum, Text, Optional_)) and not const:
            # A value that cannot be changed in Python needs a place that can.
            place = self._places.get(rank)
            if place is None:
                member = {"name": "value", "offset": 0, "type": rank}
                place = Record(
                    {
                        "kind": "struct", "name": kind.name, "size": kind.size,
                        "align": kind.align, "fixed": kind.fixed, "members": [member],
                    },
                    self.kinds,
                )
                self._places[rank] = place
            kind = place
        return kind


class _Other(Kind):
    """What codels in Python cannot use."""

    def ctype(self, const: bool) -> Any:
        return ctypes.c_uint64 if self.align == 8 else super().ctype(const)

    def get(self, address: int, const: bool, owner: Any) -> Any:
        raise Unsupported(f"a {self.keyword} is known to codels in C only")

    def put(self, address: int, value: Any) -> None:
        raise Unsupported(f"a {self.keyword} is known to codels in C only")
