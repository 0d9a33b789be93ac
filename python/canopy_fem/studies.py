"""Studies, by the program that is part of the module, and many runs at once."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from . import _core
from .batch import Batch, run_batch
from .case import Case, as_case, plain
from .errors import CanopyError, CaseError

if TYPE_CHECKING:
    from .typed import CaseSource, Initial, Kept

__all__ = ["Sample", "check", "gradient", "program", "rollout", "sample", "stability", "sweep", "tradeoff"]

# [s] for the program to end after an interrupt.
_PATIENCE = 10.0

# Starts the program of this very package, wherever it is, and whatever modules the working folder has.
_START = (
    f"import sys; sys.path[:] = [{str(Path(__file__).parent.parent)!r}, *filter(None, sys.path)]; "
    "from canopy_fem.__main__ import main; sys.exit(main())"
)


@overload
def rollout(  # type: ignore[overload-overlap]  # a text is a case here, and none of several
    cases: Case | CaseSource,
    *,
    overrides: Iterable[Mapping[str, Any]] | None = None,
    times: npt.ArrayLike | None = None,
    every: float | None = None,
    keep: Sequence[Kept] | None = None,
    out: Mapping[str, npt.NDArray[Any]] | None = None,
    nodes: Sequence[int] | npt.NDArray[Any] | None = None,
    initial: Initial | None = None,
    forces: Mapping[Any, npt.ArrayLike] | None = None,
    rest_scale: Mapping[Any, npt.ArrayLike] | None = None,
    loads: Mapping[str, npt.ArrayLike] | None = None,
    wind: npt.ArrayLike | None = None,
    threads: int | None = None,
    progress: bool | Callable[[int, int], object] = False,
) -> Batch: ...
@overload
def rollout(
    cases: Iterable[Case | CaseSource],
    *,
    times: npt.ArrayLike,
    keep: Sequence[Kept] | None = None,
    out: Mapping[str, npt.NDArray[Any]] | None = None,
    nodes: Sequence[int] | npt.NDArray[Any] | None = None,
    initial: Initial | None = None,
    forces: Mapping[Any, npt.ArrayLike] | None = None,
    rest_scale: Mapping[Any, npt.ArrayLike] | None = None,
    loads: Mapping[str, npt.ArrayLike] | None = None,
    wind: npt.ArrayLike | None = None,
    threads: int | None = None,
    progress: bool | Callable[[int, int], object] = False,
) -> Batch: ...
@overload
def rollout(
    cases: Iterable[Case | CaseSource],
    *,
    threads: int | None = None,
    nodes: Sequence[int] | npt.NDArray[Any] | None = None,
    every: float | None = None,
) -> list[_core.Rollout]: ...
def rollout(
    cases: Any,
    *,
    overrides: Iterable[Mapping[str, Any]] | None = None,
    times: npt.ArrayLike | None = None,
    every: float | None = None,
    keep: Sequence[Kept] | None = None,
    out: Mapping[str, npt.NDArray[Any]] | None = None,
    nodes: Sequence[int] | npt.NDArray[Any] | None = None,
    initial: Initial | None = None,
    forces: Mapping[Any, npt.ArrayLike] | None = None,
    rest_scale: Mapping[Any, npt.ArrayLike] | None = None,
    loads: Mapping[str, npt.ArrayLike] | None = None,
    wind: npt.ArrayLike | None = None,
    threads: int | None = None,
    progress: bool | Callable[[int, int], object] = False,
) -> Batch | list[_core.Rollout]:
    """Many runs at once on a pool of threads, a run a thread, in memory; results do not depend on their number. The
    threads stay for the next call.

    Of one case, and of several with `times`, it returns a `Batch`: arrays (runs, times, …). A time within a step shows
    the state interpolated there, as frames do. Of several cases without `times` it returns a list with a `Rollout` of
    each, whose states are those at the ends of steps.

    What is set on the way, `forces`, `rest_scale`, `loads` and `wind`, has an axis for the runs and one for the times,
    or spreads to them as numpy's arrays do. A value acts from the end of the first step that reaches its time until
    that of the next one, as if the simulation were set there; a row shows what is before that. A value that is what it
    was costs nothing.

    Args:
        cases: one case, case file or dictionary, or several.
        overrides: variants of one case, a run each: other values by dotted path. Its text is not read again, and its
            mesh is made again only where its section changes.
        times: [s] (times,), ascending. A run makes no step after the first that reaches the last of them.
        every: [s] times at its multiples up to the end of the longest case; the start and the end if both are left
            out. Of a list of cases without `times`: a state at the end of the first step that reaches each multiple.
        keep: what is kept: "positions", "velocities", "gauges", "energies", "peaks", "peak_times"; gauges and energies
            if left out. For peaks every step is measured.
        out: arrays of float64 to be filled, by those names, which are kept as well.
        nodes: nodes of positions and velocities, (n,); all if left out.
        initial: positions [m] and velocities [m/s], a pair or a dictionary, each (n, 3) or (runs, n, 3); or snapshots
            of a `Simulation`, one for all runs or one each, from whose times the runs go on.
        forces: [N] by group or numbers of nodes: (runs, times, 3), on each of its nodes, or (runs, times, k, 3).
        rest_scale: [-] by group or numbers of edges: (runs, times).
        loads: [-] by name, as `Simulation.loads`: (runs, times).
        wind: [m/s] (runs, times, 3).
        threads: number of threads; that of the processors if left out.
        progress: True for a line on standard error, in a notebook a bar; or a function of the runs made and of all
            runs.

    Raises:
        CaseError: a case with faults.
        ValueError, TypeError, KeyError: nodes that do not exist, arrays of another shape, and other arguments out of
            range.

    A run that diverges or cannot be solved is no exception here: its `status` and `failure` say so.

    >>> swing = {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}}
    >>> case = {"name": "swing", "system": swing, "time": {"end": 0.1, "step": 1e-3, "method": "rk4"}}
    >>> batch = rollout(case, overrides=[{"system.pendulum.angle": angle} for angle in (0.1, 0.2)], every=0.05)
    >>> batch.energies.shape
    (2, 3, 6)
    """
    workers = threads or os.cpu_count() or 1
    numbers = None if nodes is None else _whole(nodes)
    more: dict[str, Any] = {"overrides": overrides, "keep": keep, "out": out, "initial": initial, "forces": forces}
    more |= {"rest_scale": rest_scale, "loads": loads, "wind": wind}
    if times is not None or isinstance(cases, (str, os.PathLike, Mapping, Case)):
        return run_batch(
            cases,
            times=times,
            every=every,
            nodes=numbers,
            threads=workers,
            progress=progress,
            **more,
        )
    given = [name for name, value in more.items() if value is not None] + (["progress"] if progress else [])
    if given:
        raise TypeError(f"{', '.join(given)}: of several cases these need times")
    made = [as_case(case)._core for case in cases]
    whole = None if numbers is None else [int(node) for node in numbers]
    return _core.rollout(made, threads=workers, nodes=whole, every=every)


def _whole(nodes: Any) -> Any:
    array = np.asarray(nodes)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise TypeError(f"nodes are whole numbers, (k,), not an array of {array.dtype} with shape {array.shape}")
    if array.size and (array.min() < 0 or array.max() >= 2**32):
        raise ValueError("nodes are numbers from 0 to 4294967295")
    return array


def check(case: Any, *, within: float | str | None = None, quantities: Sequence[str] = ()) -> dict[str, Any]:
    """What ``canopy-fem check --json`` prints: the model, critical steps of all methods, what the case's own run costs
    and what its numbers are worth (``this_case``), the cheapest runs within an accuracy (``recommended``), warnings.

    Args:
        case: a `Case`, a case file or a dictionary.
        within: the accuracy, a share of the numbers such as 0.01 or "1%", or with a unit, "20N".
        quantities: names of the numbers that are asked for, such as ``"riser.tension.peak"``.

    Raises:
        CaseError: the case has faults, or the accuracy is out of range.
    """
    given = [] if within is None else ["--within", within if isinstance(within, str) else repr(float(within))]
    for name in quantities:
        given += ["--quantity", name]
    with _file_of(as_case(case)) as arguments:
        return dict(json.loads(_call(["check", *arguments, "--json", *given])))


def gradient(
    case: Any,
    of: str | Sequence[str] = (),
    *,
    by: str | Sequence[str],
    verify: bool = False,
    threads: int = 1,
    states: int | None = None,
) -> dict[str, dict[str, Any]]:
    """Exact derivatives of the numbers of a run: those of ``canopy-fem gradient``, by quantity and key.

    Args:
        case: a `Case`, a case file or a dictionary. Its steps are fixed.
        of: names of quantities, such as ``"riser.tension.peak"``; those of the case, else those of the report, if left
            out.
        by: keys of numbers of the case, as for `--set`; or unique ends of keys, or keys that hold numbers; or what each
            spring or node has: ``"each.stiffness"``, ``"each.rest_length"``, ``"each.mass"``, ``"each.force"``,
            ``"each.position"``, ``"each.velocity"``.
        verify: compare with differences of whole runs; a derivative that differs by more than 1e-3 of it then raises.
        threads: threads of a scene above 2,000 nodes.
        states: steps that are kept at once for derivatives by each spring or node, at least 2; with fewer than the run
            has, parts of it are made again.

    Returns:
        Of each quantity, each key with its derivative, in the unit of the quantity over that of the key; the most
        important key first. By each spring or node the derivatives are an array: ``(n_edges,)``, NaN on an edge without
        spring, ``(n_nodes,)`` for masses, or ``(n_nodes, 3)``.

    Raises:
        CaseError: the case has faults, or a quantity, a key or the method has no derivative.
        CanopyError: the run fails, or derivatives are not those of whole runs.
    """
    quantities, keys = ([one] if isinstance(one, str) else list(one) for one in (of, by))
    given = ["--threads", str(int(threads)), *(["--verify"] if verify else [])]
    given += [] if states is None else ["--states", str(int(states))]
    for flag, names in (("--of", quantities), ("--by", keys)):
        for name in names:
            given += [flag, name]
    with _file_of(as_case(case)) as arguments:
        report = json.loads(_call(["gradient", *arguments, "--json", *given]))
    found: dict[str, dict[str, Any]] = {}
    for quantity in report["quantities"]:
        for one in quantity["derivatives"]:
            value, by_runs = one["value"], one.get("by_runs")
            if by_runs is not None and abs(value - by_runs) > 1e-3 * max(abs(value), abs(by_runs)):
                raise CanopyError(
                    f"{quantity['name']} by {one['by']}: {value} is not {by_runs}, the difference of whole runs"
                )
            found.setdefault(quantity["name"], {})[one["by"]] = value
        for all_of in quantity.get("each", ()):
            values = np.array(all_of["values"], dtype=float)
            shape = (-1, 3) if all_of["components"] == 3 else (-1,)
            found.setdefault(quantity["name"], {})[all_of["by"]] = values.reshape(shape)
    return found


def tradeoff(
    case: Any,
    out: str | os.PathLike[str] | None = None,
    *,
    arguments: list[str] | tuple[str, ...] = (),
    replace: bool = False,
) -> list[dict[str, Any]]:
    """The study of ``canopy-fem tradeoff``: a dictionary a run, with the columns of tradeoff.csv.

    Args:
        case: a `Case`, a case file or a dictionary.
        out: folder for tradeoff.csv, .json, .svg and .html; they are not kept if left out.
        arguments: further arguments of the command, e.g. ``["--methods", "rk4,newmark", "--budget", "30s"]``.
        replace: replace an earlier study in the folder.

    Raises:
        CaseError: the case has faults, or the arguments do not fit.
    """
    return _study("tradeoff", case, out, arguments, replace)


def stability(
    case: Any,
    out: str | os.PathLike[str] | None = None,
    *,
    arguments: list[str] | tuple[str, ...] = (),
    replace: bool = False,
) -> list[dict[str, Any]]:
    """The study of ``canopy-fem stability``: a dictionary a method with its predicted and measured largest stable step
    [s], None where there is no limit. Arguments and exceptions are those of `tradeoff`."""
    return _study("stability", case, out, arguments, replace)


def sweep(
    case: Any,
    vary: Mapping[str, Any],
    out: str | os.PathLike[str] | None = None,
    *,
    arguments: list[str] | tuple[str, ...] = (),
    replace: bool = False,
) -> list[dict[str, Any]]:
    """The study of ``canopy-fem sweep``: the case once for every value of its keys, a dictionary a run with the columns
    of sweep.csv. A run that fails is a row whose `status` and `note` say so.

    Args:
        case: a `Case`, a case file or a dictionary.
        vary: values by dotted path: a list or an array, or a range as the command has it, ``"log:1..100:9"``. Several
            keys make a grid.
        out: folder for sweep.csv, .json, .svg and .html; they are not kept if left out.
        arguments: further arguments of the command, e.g. ``["--plot", "max_speed", "--threads", "1"]``.
        replace: replace an earlier sweep in the folder. Without it an unfinished sweep of the same runs goes on.

    Raises:
        CaseError: the case has faults with one of the values, or the arguments do not fit.
        TypeError: `vary` is no dictionary of lists.

    >>> swing = {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}}
    >>> case = {"name": "swing", "system": swing, "time": {"end": 0.1, "step": 1e-3, "method": "rk4"}}
    >>> rows = sweep(case, {"time.method": ["rk4", "newmark"]})
    >>> [(row["time.method"], row["steps"]) for row in rows]
    [('rk4', 100), ('newmark', 100)]
    """
    if not isinstance(vary, Mapping):
        raise TypeError(f"vary is a dictionary of dotted paths and values, not {type(vary).__name__}")
    varied = [f"--vary={key}={_values(key, values)}" for key, values in vary.items()]
    if isinstance(arguments, str):
        raise TypeError(f"arguments are a list of texts, such as {arguments.split()!r}, not one text")
    return _study("sweep", case, out, [*varied, *arguments], replace)


@dataclass(frozen=True)
class Sample:
    """What `sample` returns."""

    rows: list[dict[str, Any]]
    """a dictionary a run, with the columns of sweep.csv"""
    summary: dict[str, Any]
    """what they say, as `scatter` in sweep.json has it: `quantities` with mean, deviation, percentiles and indices,
    `failed`, `landing`"""


def sample(
    case: Any,
    vary: Mapping[str, Any],
    samples: int,
    quantities: Sequence[str] = (),
    *,
    sampling: str = "lhs",
    seed: int = 1,
    out: str | os.PathLike[str] | None = None,
    arguments: list[str] | tuple[str, ...] = (),
    replace: bool = False,
) -> Sample:
    """The study of ``canopy-fem sweep --samples``: values of the case are drawn from distributions, and the scatter of
    its numbers is measured.

    Args:
        case: a `Case`, a case file or a dictionary.
        vary: distributions by dotted path, ``"normal:45±5"``, ``"uniform:1..3"``, ``"lognormal:2±10%"`` or
            ``"table:file.csv"``; a list has equally likely values. The key ``"rows"`` names a csv file whose rows are
            drawn as a whole.
        samples: number of runs.
        quantities: names of the numbers that are asked for, such as ``"riser.tension.peak"``.
        sampling: ``"lhs"``, ``"sobol"`` or ``"random"``.
        seed: of the random numbers; the same seed has the same rows.
        out: folder for sweep.csv, .json, .svg and .html; they are not kept if left out.
        arguments: further arguments of the command, e.g. ``["--until", "2% of p99 riser.tension.peak"]``.
        replace: replace an earlier sweep in the folder.

    Raises:
        CaseError: the case has faults with one of the values, or the arguments do not fit.
        TypeError: `vary` is no dictionary.

    >>> swing = {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}}
    >>> case = {"name": "swing", "system": swing, "time": {"end": 0.1, "step": 1e-3, "method": "rk4"}}
    >>> found = sample(case, {"system.pendulum.angle": "uniform:0.4..0.6"}, 8)
    >>> len(found.rows), found.summary["quantities"][0]["runs"]
    (8, 8)
    """
    if not isinstance(vary, Mapping):
        raise TypeError(f"vary is a dictionary of dotted paths and distributions, not {type(vary).__name__}")
    if isinstance(arguments, str) or isinstance(quantities, str):
        raise TypeError("arguments and quantities are lists of texts, not one text")
    drawn = [f"rows:{law}" if key == "rows" else f"{key}={_values(key, law)}" for key, law in vary.items()]
    asked = [f"--quantity={name}" for name in quantities]
    design = [f"--samples={samples}", f"--sampling={sampling}", f"--seed={seed}"]
    more = [*(f"--vary={text}" for text in drawn), *asked, *design, *arguments]
    with tempfile.TemporaryDirectory(prefix="canopy-fem-") as scratch:
        folder = Path(scratch) / "sample" if out is None else Path(os.fspath(out))
        rows = _study("sweep", case, folder, more, replace)
        told = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))
    return Sample(rows, told["scatter"])


def _values(key: Any, values: Any) -> str:
    """Values of a key as the command takes them."""
    if isinstance(values, str):
        return values
    listed = plain(values, f"/{key}")
    if not isinstance(listed, list) or not listed:
        raise TypeError(f'{key}: give a list of values, or a range such as "log:1..100:9"')
    return ",".join(json.dumps(value) for value in listed)


def _study(command: str, case: Any, out: Any, more: list[str] | tuple[str, ...], replace: bool) -> list[dict[str, Any]]:
    if isinstance(more, str):
        raise TypeError(f"arguments are a list of texts, such as {more.split()!r}, not one text")
    with tempfile.TemporaryDirectory(prefix="canopy-fem-") as scratch, _file_of(as_case(case)) as arguments:
        folder = Path(scratch) / command if out is None else Path(os.fspath(out))
        force = ["--force"] if replace else []
        _call([command, *arguments, "--out", str(folder), "--quiet", *force, *map(str, more)])
        with (folder / f"{command}.csv").open(encoding="utf-8", newline="") as file:
            return [{name: _value(text) for name, text in row.items()} for row in csv.DictReader(file)]


def _value(text: str) -> Any:
    if text in ("", "true", "false"):
        return {"": None, "true": True, "false": False}[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


def program() -> Path:
    """The command ``canopy-fem`` of this installation: a small script that starts the program of the module.

    Raises:
        CanopyError: it is not there.
    """
    name = "canopy-fem.exe" if sys.platform == "win32" else "canopy-fem"
    schemes = [sysconfig.get_path("scripts")]
    schemes += [sysconfig.get_path("scripts", scheme) for scheme in sysconfig.get_scheme_names() if "user" in scheme]
    # Next to a folder that pip was given with --target.
    folders = [*map(Path, schemes), Path(__file__).parent.parent / "bin"]
    found = next((folder / name for folder in folders if (folder / name).exists()), None) or shutil.which(name)
    if found is None:
        raise CanopyError(f"the program {name} is not in {', '.join(map(str, folders))}; install canopy-fem again")
    return Path(found)


@contextmanager
def _file_of(case: Case) -> Iterator[list[str]]:
    """The case as arguments of a command. A case without a file is written next to the files that it names."""
    if case._file is not None:
        yield [str(case._file), *(f"--set={key}={value}" for key, value in case._overrides)]
        return
    handle, name = tempfile.mkstemp(prefix=".canopy-fem-", suffix=".json", dir=case._base)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            json.dump(case.to_dict(), file)
        yield [name]
    finally:
        os.unlink(name)


def _call(arguments: Sequence[str]) -> str:
    pipe = subprocess.PIPE
    # What it says becomes the message of an exception, without colours and breaks of lines.
    plain = {name: value for name, value in os.environ.items() if name not in {"COLUMNS", "CLICOLOR_FORCE"}}
    started = subprocess.Popen(
        [sys.executable, "-c", _START, *arguments], stdout=pipe, stderr=pipe, text=True, encoding="utf-8", env=plain
    )
    with started as process:
        try:
            out, told = process.communicate()
        except BaseException:
            _interrupt(process)
            raise
    if process.returncode == 0:
        return out
    message = told.strip().removeprefix("error: ")
    raise (CaseError if process.returncode == 2 else CanopyError)(message)


def _interrupt(process: subprocess.Popen[str]) -> None:
    """Lets the program save what it has, as after Ctrl-C, and ends it if it does not end by itself."""
    process.send_signal(signal.SIGTERM if sys.platform == "win32" else signal.SIGINT)
    try:
        process.communicate(timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
