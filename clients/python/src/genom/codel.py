"""For codels in Python: what a script may import besides the types of its component.

    from genom.codel import Raised      # the base of all exceptions of codels
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterator, List, Tuple, TypeVar

__all__ = ["Raised"]

if TYPE_CHECKING:
    # For the stubs that `genomctl header --lang python` writes.
    from typing import Protocol, overload

    T = TypeVar("T")

    class View:
        """A struct in memory."""

    class Union:
        """A union in memory."""

        d: Any

    class Elements(Protocol[T]):
        """An array or a sequence; only a sequence has another length later."""

        def __len__(self) -> int: ...
        def __iter__(self) -> Iterator[T]: ...
        @overload
        def __getitem__(self, rank: int) -> T: ...
        @overload
        def __getitem__(self, rank: slice) -> List[T]: ...
        def __setitem__(self, rank: int, value: T) -> None: ...
        def append(self, value: T) -> None: ...
        def extend(self, values: Any) -> None: ...
        def clear(self) -> None: ...
        def resize(self, count: int) -> None: ...
        @property
        def array(self) -> Any: ...


class Raised(Exception):
    """An exception of the description, or of a port. Its members are attributes.

    A codel raises the classes of its component's types: ``raise OUT_OF_RANGE(value=goal)``. What a
    port raises may be caught, or left to end the activity.
    """

    #: Its name in IDL: ``::demo::OUT_OF_RANGE``.
    event: str = "::genom::unkex"
    _kind: Any = None
    # Of one that a port raised: what the codel is to return, recorded already.
    _recorded: int = 0

    def __init__(self, **members: Any) -> None:
        self.detail = self._detail(members)
        super().__init__(self.event)

    def _detail(self, members: Any) -> Any:
        if self._kind is None:
            if members:
                raise AttributeError(f"{self.event} has no members")
            return None
        return self._kind.view(False)(**members)

    def __getattr__(self, name: str) -> Any:
        detail = self.__dict__.get("detail")
        if detail is None or name.startswith("_"):
            raise AttributeError(f"{self.event} has no member `{name}`")
        return getattr(detail, name)

    def __reduce__(self) -> Tuple[Any, ...]:
        return (Raised, ())

    def __str__(self) -> str:
        return self.event if self.detail is None else f"{self.event}: {self.detail!r}"
