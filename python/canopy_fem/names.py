"""Values by names, which say what is there when a name is not."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

__all__ = ["Named", "unknown"]

_Value = TypeVar("_Value")


def unknown(kind: str, name: Any, known: Iterable[str]) -> KeyError:
    """The exception for a name that is not there."""
    return KeyError(f"there is no {kind} {name!r}; there are: {', '.join(known) or 'none'}")


class Named(dict[str, _Value]):
    """A dictionary whose `KeyError` lists the names that are there.

    >>> Named("gauge", {"riser tension_max": 4.0})["riser"]
    Traceback (most recent call last):
    KeyError: "there is no gauge 'riser'; there are: riser tension_max"
    """

    def __init__(self, kind: str, values: Mapping[str, _Value]) -> None:
        super().__init__(values)
        self.kind = kind

    def __missing__(self, name: Any) -> _Value:
        raise unknown(self.kind, name, self)

    def __reduce__(self) -> tuple[Any, ...]:
        return Named, (self.kind, dict(self))
