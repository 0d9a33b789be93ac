"""Values of a case from measured curves, by the program that is part of the module."""

from __future__ import annotations

import csv
import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .case import Case, as_case
from .studies import _call, _file_of

if TYPE_CHECKING:
    from .typed import CaseSource

__all__ = ["Fit", "fit"]

Curve: TypeAlias = str | os.PathLike[str] | Sequence[npt.ArrayLike]
"""a csv file, or arrays: times [s] and values, and perhaps the standard deviation of each value"""


@dataclass(frozen=True, repr=False)
class Fit:
    """What `fit` returns. Values are by key, in the order of `vary`; an offset of times comes last, as ``"offset"``."""

    values: dict[str, float]
    """the values with which the gauges come nearest to the data"""
    errors: dict[str, float | None]
    """standard errors by the noise; None at an end of a range, and where the data do not determine a value"""
    intervals: dict[str, tuple[float, float] | None]
    """which hold the value with 95 % confidence, as far as the model is linear there; None as in `errors`"""
    correlation: npt.NDArray[np.float64]
    """[-] of the errors, (n, n), in the order of `values`; NaN where a value has no error"""
    residuals: npt.NDArray[Any]
    """the points of all data, a structured array: ``of`` (gauge and column), ``t`` [s] as in the data, ``data``,
    ``model`` and ``residual``, data less model"""
    doubts: list[str]
    """what to know before the values are used: what is not determined, known together only, or at an end of its range
    """
    case: Case
    """the case with the values"""
    report: dict[str, Any]
    """what fit.json holds"""

    def to_pandas(self, table: str = "values") -> Any:
        """A pandas.DataFrame: ``"values"``, a row a key with value, standard_error and the ends of its interval, low
        and high, or ``"residuals"``, a row a point.

        Raises:
            KeyError: there is no such table.
        """
        import pandas

        if table == "residuals":
            return pandas.DataFrame({name: self.residuals[name] for name in self.residuals.dtype.names or ()})
        if table != "values":
            raise KeyError(f'a fit has the tables "values" and "residuals", not {table!r}')
        ends = [self.intervals[key] or (float("nan"), float("nan")) for key in self.values]
        columns = {
            "value": list(self.values.values()),
            "standard_error": [float("nan") if error is None else error for error in self.errors.values()],
            "low": [low for low, _ in ends],
            "high": [high for _, high in ends],
        }
        return pandas.DataFrame(columns, index=pandas.Index(list(self.values), name="key"))

    def __repr__(self) -> str:
        told = (
            f"{key}={value:.6g}" + ("" if (error := self.errors[key]) is None else f"±{error:.2g}")
            for key, value in self.values.items()
        )
        return f"Fit({', '.join(told)})"


def fit(
    case: Case | CaseSource,
    data: Mapping[str, Curve],
    vary: Mapping[str, str | Sequence[float]],
    *,
    offset: Sequence[float] | None = None,
    starts: int = 1,
    seed: int = 1,
    out: str | os.PathLike[str] | None = None,
    arguments: Sequence[str] = (),
    replace: bool = False,
) -> Fit:
    """Values of a case with which its gauges come nearest to measured curves, by least squares: ``canopy-fem fit``.

    The sum over all points of ((data - model)/noise)² becomes least. The noise of a curve without standard deviations
    follows from its residuals.

    Args:
        case: a `Case`, a case file or a dictionary, with the gauges in its output.
        data: curves by gauge and column, such as ``"line.tension"``: a csv file, or arrays of times [s] and values, and
            perhaps the standard deviation of each value. ``"line.tension*1000"`` multiplies them, for other units.
        vary: ranges by dotted path, ``(low, high)``, or ``"log:0.1..10"`` for a value that may be wrong by factors.
        offset: range [s] of an offset that is added to the times of the data, and fitted too.
        starts: number of starts of the search: the case itself, and others spread over the ranges.
        seed: of the other starts.
        out: folder for fit.json, .csv, .svg, .html and fitted.json, and for the data that are arrays; they are not kept
            if left out.
        arguments: further arguments of the command, e.g. ``["--threads", "1"]``.
        replace: replace an earlier fit in the folder.

    Raises:
        CaseError: the case has faults, or data, keys or ranges do not fit.
        CanopyError: no start has a run.
        TypeError, ValueError: data or ranges of another type or shape.

    >>> swing = {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}}
    >>> case = {"name": "swing", "system": swing, "time": {"end": 1, "step": 0.01, "method": "rk4"}}
    >>> case["output"] = {"gauges": [{"name": "bob", "on": {"ids": [0]}, "of": "position"}]}
    >>> times = np.linspace(0.1, 1.0, 10)
    >>> seen = np.sin(0.4 * np.cos(np.sqrt(9.81) * times))
    >>> found = fit(case, {"bob.position_x": (times, seen)}, {"system.pendulum.angle": (0.1, 1.0)})
    >>> round(found.values["system.pendulum.angle"], 2)
    0.4
    """
    for what, named in (("data", data), ("vary", vary)):
        if not isinstance(named, Mapping):
            raise TypeError(f"{what} is a dictionary, not {type(named).__name__}")
    if isinstance(arguments, str):
        raise TypeError(f"arguments are a list of texts, such as {arguments.split()!r}, not one text")
    made = as_case(case)
    with tempfile.TemporaryDirectory(prefix="canopy-fem-") as scratch, _file_of(made) as of_case:
        folder = Path(scratch) / "fit" if out is None else Path(os.fspath(out))
        # An earlier fit, which the program does not replace, keeps its data too.
        kept = not replace and (folder / "fit.json").exists()
        files = [_file(folder, number, of, curve, kept) for number, (of, curve) in enumerate(data.items(), 1)]
        given = [f"--data={file}:{of}" for file, of in zip(files, data, strict=True)]
        given += [f"--vary={key}={_range(key, ends)}" for key, ends in vary.items()]
        given += [] if offset is None else [f"--offset={_range('offset', offset)}"]
        given += [f"--starts={starts}", f"--seed={seed}", *(["--force"] if replace else []), *map(str, arguments)]
        report = json.loads(_call(["fit", *of_case, "--out", str(folder), "--json", *given]))
        residuals = _points(folder / "fit.csv")
    return _fit(made, report, residuals)


def _fit(case: Case, report: dict[str, Any], residuals: npt.NDArray[Any]) -> Fit:
    found = {one["key"]: one for one in report["values"]}
    values = {key: one["value"] for key, one in found.items()}
    return Fit(
        values=values,
        errors={key: one["standard_error"] for key, one in found.items()},
        intervals={key: one["interval"] and tuple(one["interval"]) for key, one in found.items()},
        correlation=np.array(report["correlation"], dtype=float).reshape(len(values), len(values)),
        residuals=residuals,
        doubts=report["doubts"],
        case=case.with_overrides({key: value for key, value in values.items() if key != "offset"}),
        report=report,
    )


def _file(folder: Path, number: int, of: str, curve: Curve, kept: bool) -> str:
    """The file of a curve; arrays become one in the folder."""
    if isinstance(curve, (str, os.PathLike)):
        return os.fspath(curve)
    columns = [np.asarray(column, dtype=float) for column in curve]
    if len(columns) not in (2, 3) or any(column.ndim != 1 for column in columns):
        raise TypeError(f"data of {of} are a file, or arrays (n,) of times, values and perhaps standard deviations")
    if len({column.size for column in columns}) > 1:
        raise ValueError(f"data of {of}: arrays of {', '.join(str(column.size) for column in columns)} numbers")
    file = folder / f"data-{number}.csv"
    if not kept:
        folder.mkdir(parents=True, exist_ok=True)
        with file.open("w", encoding="utf-8", newline="") as opened:
            csv.writer(opened).writerows(zip(*(column.tolist() for column in columns), strict=True))
    return str(file)


def _range(key: str, ends: Any) -> str:
    """A range as the command takes it."""
    if isinstance(ends, str):
        return ends
    if len(ends) != 2:
        raise ValueError(f'{key}: a range is (low, high), or a text such as "log:0.1..10"')
    low, high = map(float, ends)
    return f"{low!r}..{high!r}"


def _points(path: Path) -> npt.NDArray[Any]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    numbers = ("t", "data", "model", "residual")
    made = [(row["of"], *(float(row[name]) for name in numbers)) for row in rows]
    longest = max((len(row["of"]) for row in rows), default=1)
    return np.array(made, dtype=[("of", f"U{longest}"), *((name, "f8") for name in numbers)])
