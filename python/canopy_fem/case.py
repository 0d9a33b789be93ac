"""Cases: from files, from dictionaries, with other values."""

from __future__ import annotations

import html
import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._core import Case as CoreCase
from ._core import Mesh as CoreMesh
from .errors import CaseError, Fault

if TYPE_CHECKING:
    from .results import Result
    from .typed import CaseSource

__all__ = ["Case", "as_case"]

Overrides = Mapping[str, Any]
_DEEPEST = 60


class Case:
    """A case that was read and has no faults.

    Args:
        source: a case file, a dictionary with the same keys (arrays and meshes may stand for lists), or a case.
        overrides: other values by dotted path, e.g. ``{"time.step": 1e-3}``; None removes a key.
        base: folder to which paths in a dictionary are relative; the present one if left out.
        at_rest: whether the `time` section may be missing, as for `static`.

    Raises:
        CaseError: the case has faults; ``faults`` lists all of them, each with its place and what is allowed there.
        OSError: the file cannot be read.
        TypeError: `source` is none of these.

    >>> swing = {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}}
    >>> case = Case({"name": "swing", "system": swing, "time": {"end": 1, "step": 1e-3, "method": "rk4"}})
    >>> case.with_overrides({"time.step": 1e-2}).step
    0.01
    """

    __slots__ = ("__weakref__", "_base", "_core", "_file", "_overrides")

    _core: CoreCase
    _file: Path | None
    _base: Path
    _overrides: list[tuple[str, str]]

    def __init__(
        self,
        source: CaseSource | Case,
        overrides: Overrides | None = None,
        *,
        base: str | os.PathLike[str] | None = None,
        at_rest: bool = False,
    ) -> None:
        changes = _assignments(overrides)
        self._file = None
        self._overrides = changes
        if isinstance(source, Case):
            self._core = source._core.with_overrides(changes)
            self._file, self._base = source._file, source._base
            self._overrides = source._overrides + changes
        elif isinstance(source, Mapping):
            self._base = Path(base if base is not None else ".")
            text = json.dumps(plain(source))
            self._core = CoreCase.from_text(text, "case", self._base, changes, at_rest=at_rest)
        elif isinstance(source, (str, os.PathLike)):
            self._file = Path(os.fspath(source))
            self._base = self._file.parent
            self._core = CoreCase.from_file(self._file, changes, at_rest=at_rest)
        else:
            raise TypeError(f"a case is a file, a dictionary or a Case, not {type(source).__name__}")

    @property
    def name(self) -> str:
        """Its name, after which results are called."""
        return self._core.name

    @property
    def method(self) -> str:
        """Name of its method."""
        return self._core.method

    @property
    def end(self) -> float:
        """[s] End of the simulated time."""
        return self._core.end

    @property
    def step(self) -> float | None:
        """[s] Its fixed step; None if steps are adaptive."""
        return self._core.step

    @property
    def warnings(self) -> list[str]:
        """What is doubtful about it and not acknowledged, a sentence each."""
        return self._core.warnings

    def to_dict(self) -> Any:
        """The case as it is run, overrides included: a dictionary."""
        return self._core.to_dict()

    def with_overrides(self, overrides: Overrides) -> Case:
        """The same case with other values; the mesh is made again only if its section changes.

        Raises:
            CaseError: as the class does.
        """
        return Case(self, overrides)

    def static(self, out: str | os.PathLike[str] | None = None, **options: Any) -> Result:
        """Its equilibrium: `canopy_fem.static` of this case, with its options."""
        from .runs import static

        return static(self, out, **options)

    def __eq__(self, other: object) -> bool:
        """Whether the content is the same, and that of the files that it names."""
        if not isinstance(other, Case):
            return NotImplemented
        return self._core.digest == other._core.digest and self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash(self._core.digest)

    def __reduce__(self) -> tuple[Any, ...]:
        # With the content of its file, which may have changed by then, or be on another machine.
        return _restored, (type(self), self._core.text, os.path.abspath(self._base))

    def __copy__(self) -> Case:
        # It never changes.
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Case:
        return self

    def __repr__(self) -> str:
        step = "adaptive steps" if self.step is None else f"step {self.step:g} s"
        return f"<Case {self.name!r}: {self.method}, {step}, end {self.end:g} s>"

    def _repr_html_(self) -> str:
        text = html.escape(json.dumps(_short(self.to_dict()), indent=2))
        return f"<b>{html.escape(repr(self))}</b><details><summary>case</summary><pre>{text}</pre></details>"


def _restored(kind: type[Case], text: str, base: str) -> Case:
    """The case of a pickle."""
    case = kind.__new__(kind)
    case._file, case._base, case._overrides = None, Path(base), []
    case._core = CoreCase.from_text(text, "case", case._base, [])
    return case


def as_case(source: Any, *, at_rest: bool = False) -> Case:
    """The case itself, or one made of a file or dictionary."""
    return source if isinstance(source, Case) else Case(source, at_rest=at_rest)


def _assignments(overrides: Overrides | None) -> list[tuple[str, str]]:
    if overrides is None:
        return []
    if not isinstance(overrides, Mapping):
        raise TypeError(f"overrides are a dictionary of dotted paths and values, not {type(overrides).__name__}")
    for key in overrides:
        if not isinstance(key, str):
            raise TypeError(f"overrides have dotted paths as keys, not {key!r}")
    return [(key, json.dumps(plain(value, "/" + key.replace(".", "/")))) for key, value in overrides.items()]


def plain(value: Any, at: str = "", depth: int = 0) -> Any:
    """A value as JSON has it: arrays as lists, paths as texts, meshes as explicit ones.

    Raises:
        CaseError: what JSON cannot hold, with its place.
    """
    if depth > _DEEPEST:
        raise _fault(at, "…", f"at most {_DEEPEST} levels; does it contain itself?")
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, (float, np.floating)):
        if not math.isfinite(value):
            raise _fault(at, repr(float(value)), "a finite number")
        return float(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, CoreMesh):
        return {"explicit": _explicit(value)}
    if isinstance(value, np.ndarray):
        return _list_of(np.asarray(value), at)
    if isinstance(value, Mapping):
        return {_key(key, at): plain(entry, f"{at}/{key}", depth + 1) for key, entry in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, (bytes, bytearray, memoryview)):
        return [plain(entry, f"{at}/{place}", depth + 1) for place, entry in enumerate(value)]
    raise _fault(at, type(value).__name__, "numbers, texts, lists, dictionaries, arrays and meshes")


def _list_of(array: np.ndarray[Any, Any], at: str) -> Any:
    if array.size > 50_000_000:
        raise _fault(at, f"an array of {array.size} numbers", "at most 50 million")
    if array.size and array.dtype.kind not in "biuf":
        raise _fault(at, f"an array of {array.dtype}", "an array of real numbers")
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        place = "/".join(str(index) for index in np.argwhere(~np.isfinite(array))[0])
        raise _fault(f"{at}/{place}", "not finite", "a finite number")
    return array.tolist()


def _explicit(mesh: CoreMesh) -> dict[str, Any]:
    groups = {
        name: {kind: numbers.tolist() for kind, numbers in members.items()} for name, members in mesh.groups.items()
    }
    section = {"nodes": mesh.nodes.tolist(), "springs": mesh.edges.tolist(), "triangles": mesh.triangles.tolist()}
    return {**section, "groups": groups} if groups else section


def _key(key: Any, at: str) -> str:
    if not isinstance(key, str):
        raise _fault(at, repr(key), "keys that are texts")
    return key


def _fault(at: str, value: str, allowed: str) -> CaseError:
    fault = Fault(at, value, allowed)
    return CaseError(f"case: 1 fault in the case\n\n{at or '/'}: {value}\n  allowed: {allowed}", [fault])


def _short(value: Any) -> Any:
    """The same with long lists cut, for people."""
    if isinstance(value, dict):
        return {key: _short(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return f"{len(value)} entries" if len(value) > 24 else [_short(entry) for entry in value]
    return value
