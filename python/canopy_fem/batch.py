"""Many runs at the same times, in arrays, with what a program sets on the way."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core
from .case import Case, _assignments, as_case
from .logs import listen, log
from .names import unknown
from .progress import teller

if TYPE_CHECKING:
    from .typed import EnergyColumn, Kept

__all__ = ["ENERGIES", "Batch"]

_Array = npt.NDArray[np.float64]

ENERGIES: tuple[EnergyColumn, ...] = (
    "kinetic",
    "elastic",
    "gravity",
    "external_work",
    "dissipated",
    "numerical",
)
"""columns of an energy account, in the order of `Batch.energies`"""

_KEPT = ("positions", "velocities", "gauges", "energies", "peaks", "peak_times")


class Batch:
    """Runs of `rollout` at the same times. Arrays have the shape (runs, times, …).

    A row is NaN where its run did not come to that time: it ended or failed before. `status` and `failures` say so.
    """

    __slots__ = ("__weakref__", "_arrays", "_channels", "_nodes", "_runs", "_t", "_units")

    def __init__(self, t: _Array, nodes: Any, channels: list[tuple[str, str]], arrays: Mapping[str, _Array]) -> None:
        self._t, self._nodes, self._arrays = t, nodes, dict(arrays)
        self._channels, self._units = [name for name, _ in channels], [unit for _, unit in channels]
        self._runs: list[_core.Rollout] = []

    def _kept(self, name: str) -> _Array:
        if name not in self._arrays:
            raise AttributeError(f"{name} were not kept: give rollout keep=[{name!r}]")
        return self._arrays[name]

    @property
    def t(self) -> _Array:
        """[s] Times of the rows, (times,)."""
        return self._t

    @property
    def nodes(self) -> npt.NDArray[np.int64] | None:
        """Nodes that were kept, (n,); None for all."""
        return self._nodes  # type: ignore[no-any-return]

    @property
    def channels(self) -> list[str]:
        """Columns of the gauges, ``"name quantity"``."""
        return self._channels

    @property
    def units(self) -> list[str]:
        """Units of the columns."""
        return self._units

    @property
    def positions(self) -> _Array:
        """[m] (runs, times, n, 3)"""
        return self._kept("positions")

    @property
    def velocities(self) -> _Array:
        """[m/s] (runs, times, n, 3)"""
        return self._kept("velocities")

    @property
    def gauges(self) -> _Array:
        """(runs, times, channels) in the units of the channels; `gauge` has one column by its name."""
        return self._kept("gauges")

    @property
    def energies(self) -> _Array:
        """[J] (runs, times, 6): the energy account, with the columns `ENERGIES`; external_work, dissipated and
        numerical are sums since the start."""
        return self._kept("energies")

    @property
    def peaks(self) -> _Array:
        """(runs, channels) in the units of the channels: peaks of the gauges, as `Result.peaks` has them; of components
        the value of the largest magnitude. They are those over all steps that the rollout made, so from the snapshot on
        where a run begins from one, and up to the last of `times` where there are `times`.

        Raises:
            AttributeError: they were not kept; give `rollout` ``keep=["peaks"]``.
        """
        return self._kept("peaks")

    @property
    def peak_times(self) -> _Array:
        """[s] (runs, channels): when the peaks were."""
        return self._kept("peak_times")

    def __len__(self) -> int:
        return len(self._runs)

    @property
    def status(self) -> list[str]:
        """Of every run ``"completed"``, ``"diverged"`` or ``"not-converged"``."""
        return [run.status for run in self._runs]

    @property
    def failures(self) -> dict[int, dict[str, Any]]:
        """What went wrong in the runs that failed, by their number."""
        return {number: run.failure for number, run in enumerate(self._runs) if run.failure is not None}

    @property
    def steps(self) -> npt.NDArray[np.int64]:
        """accepted steps, (runs,)"""
        return np.array([run.steps for run in self._runs], dtype=np.int64)

    @property
    def t_end(self) -> _Array:
        """[s] times of the last states, (runs,)"""
        return np.array([run.t_end for run in self._runs], dtype=np.float64)

    @property
    def energy_error(self) -> _Array:
        """[-] energy that the scheme made or lost over the largest energy exchanged, (runs,)"""
        return np.array([run.energy_error for run in self._runs], dtype=np.float64)

    def gauge(self, name: str, quantity: str | None = None) -> _Array:
        """The values of one column of a gauge, (runs, times); a view.

        Raises:
            KeyError: no such gauge, or several quantities and none named.
        """
        own = [channel for channel in self.channels if channel.rsplit(" ", 1)[0] == name]
        if not own:
            raise unknown("gauge", name, sorted({channel.rsplit(" ", 1)[0] for channel in self.channels}))
        if quantity is None and len(own) == 1:
            return self.gauges[:, :, self.channels.index(own[0])]
        if f"{name} {quantity}" not in own:
            known = ", ".join(channel.rsplit(" ", 1)[1] for channel in own)
            raise KeyError(f"gauge {name!r} has the quantities {known}; name one of them")
        return self.gauges[:, :, self.channels.index(f"{name} {quantity}")]

    def energy(self, column: EnergyColumn) -> _Array:
        """[J] One column of the energy account, (runs, times); a view.

        Raises:
            KeyError: no such column.
        """
        if column not in ENERGIES:
            raise KeyError(f"an energy account has no {column!r}; it has: {', '.join(ENERGIES)}")
        return self.energies[:, :, ENERGIES.index(column)]

    def to_xarray(self) -> Any:
        """All that was kept as an xarray.Dataset with the dimensions run, time, node, axis, channel and energy.

        Raises:
            ImportError: xarray is not installed.
        """
        import xarray

        node = np.arange(self._node_count()) if self.nodes is None else self.nodes
        coordinates = {"run": np.arange(len(self)), "time": self.t, "node": node, "axis": list("xyz")}
        coordinates |= {"channel": self.channels, "energy": list(ENERGIES)}
        dimensions = {
            "positions": ("run", "time", "node", "axis"),
            "velocities": ("run", "time", "node", "axis"),
            "gauges": ("run", "time", "channel"),
            "energies": ("run", "time", "energy"),
            "peaks": ("run", "channel"),
            "peak_times": ("run", "channel"),
        }
        kept = {name: (dimensions[name], self._arrays[name]) for name in _KEPT if name in self._arrays}
        used = {dimension for names, _ in kept.values() for dimension in names} | {"run", "time"}
        own = {name: values for name, values in coordinates.items() if name in used}
        made = xarray.Dataset(kept, own)
        if "channel" in used:
            made = made.assign_coords(unit=("channel", self.units))
        return made

    def to_pandas(self) -> Any:
        """Gauges and energies, those that were kept, as a pandas.DataFrame: a row a run and time.

        Raises:
            ImportError: pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self._columns())

    def to_polars(self) -> Any:
        """The same as a polars.DataFrame, whose columns Arrow has.

        Raises:
            ImportError: polars is not installed.
        """
        import polars

        return polars.DataFrame(self._columns())

    def _columns(self) -> dict[str, npt.NDArray[Any]]:
        columns: dict[str, npt.NDArray[Any]] = {
            "run": np.repeat(np.arange(len(self)), len(self.t)),
            "t": np.tile(self.t, len(self)),
        }
        for array, names in (("gauges", self.channels), ("energies", ENERGIES)):
            if array in self._arrays:
                values = self._arrays[array]
                columns |= {name: values[:, :, place].ravel() for place, name in enumerate(names)}
        return columns

    def _node_count(self) -> int:
        kept = next((self._arrays[name] for name in ("positions", "velocities") if name in self._arrays), None)
        return 0 if kept is None else int(kept.shape[2])

    def __repr__(self) -> str:
        failed = len(self.failures)
        kept = ", ".join(name for name in _KEPT if name in self._arrays)
        return f"<Batch: {len(self)} runs, {len(self.t)} times, {failed} failed; {kept}>"


def run_batch(
    source: Any,
    *,
    overrides: Iterable[Mapping[str, Any]] | None,
    times: npt.ArrayLike | None,
    every: float | None,
    keep: Sequence[Kept] | None,
    out: Mapping[str, _Array] | None,
    nodes: Any,
    initial: Any,
    forces: Mapping[Any, npt.ArrayLike] | None,
    rest_scale: Mapping[Any, npt.ArrayLike] | None,
    loads: Mapping[str, npt.ArrayLike] | None,
    wind: npt.ArrayLike | None,
    threads: int,
    progress: bool | Callable[[int, int], object],
) -> Batch:
    """`rollout` of one case, or of several at the same times."""
    alone = isinstance(source, (str, os.PathLike, Mapping, Case))
    cases = [as_case(source)] if alone else [as_case(case) for case in source]
    variants = [_assignments(change) for change in overrides] if overrides is not None else []
    if variants and not alone:
        raise TypeError("overrides are variants of one case, and there are several")
    if not cases:
        raise ValueError("there are no cases")
    grid = _grid(cases, times, every, initial)
    given = [_action(*action) for action in _listed(forces, rest_scale, loads, wind)]
    start = _initial(initial)
    runs = _runs(len(variants) if overrides is not None else None if alone else len(cases), given, start)
    actions = [(what, place, _spread(what, array, (runs, len(grid)), tail)) for what, place, array, tail in given]
    wanted = list(dict.fromkeys([*(keep if keep is not None else () if out else ("gauges", "energies")), *(out or ())]))
    unknown = [name for name in wanted if name not in _KEPT]
    if unknown:
        raise KeyError(f"nothing of a run is called {unknown[0]!r}; there are: {', '.join(_KEPT)}")
    core = cases[0]._core
    if variants:
        core = core.with_overrides(variants[0])
    gauged = any(name in wanted for name in ("gauges", "peaks", "peak_times"))
    channels = core.channels if gauged else []
    n = (core.node_count if nodes is None else len(nodes)) if {"positions", "velocities"} & {*wanted} else 0
    shapes = {
        "positions": (runs, len(grid), n, 3),
        "velocities": (runs, len(grid), n, 3),
        "gauges": (runs, len(grid), len(channels)),
        "energies": (runs, len(grid), len(ENERGIES)),
        "peaks": (runs, len(channels)),
        "peak_times": (runs, len(channels)),
    }
    arrays = {name: _place(name, (out or {}).get(name), shapes[name]) for name in wanted}
    batch = Batch(grid, nodes, channels, arrays)
    listen()
    log.info("rollout of %d runs begins: %s, threads %d", runs, cases[0].name, threads)
    batch._runs = _core.rollout_batch(
        [case._core for case in cases],
        variants=variants,
        times=grid.tolist(),
        ends=times is not None,
        nodes=[] if nodes is None else [int(node) for node in nodes],
        channels=batch.channels,
        arrays=arrays,
        runs=runs,
        actions=actions,
        initial={name: _spread_start(name, value, runs, core) for name, value in start.items()},
        threads=threads,
        progress=teller(progress, _runs_made(), "the runs made and of all runs"),
    )
    log.info("rollout of %d runs ended, %d steps", runs, batch.steps.sum())
    for run, failure in batch.failures.items():
        log.warning("run %d %s at t = %g s: %s", run, batch.status[run], failure["time"], failure["cause"])
    return batch


def _grid(cases: list[Case], times: npt.ArrayLike | None, every: float | None, initial: Any) -> _Array:
    if times is not None:
        if every is not None:
            raise TypeError("give either times or every")
        grid = np.array(times, dtype=np.float64)
        if grid.ndim != 1 or not len(grid) or not np.isfinite(grid).all() or (np.diff(grid) <= 0).any():
            raise ValueError("times are finite numbers [s], each above the one before it, (times,)")
        return grid
    if _of_snapshots(initial):
        raise TypeError("give times: the runs begin at the times of their snapshots")
    end = max(case.end for case in cases)
    if every is None:
        return np.array([0.0, end])
    if not (every > 0 and np.isfinite(every)):
        raise ValueError("every must be a time [s] above 0")
    multiples: _Array = np.arange(int(end / every * (1 + 1e-12)) + 1, dtype=np.float64) * every
    return np.minimum(multiples, end)


def _of_snapshots(initial: Any) -> bool:
    return isinstance(initial, bytes) or (
        isinstance(initial, Sequence) and len(initial) > 0 and isinstance(initial[0], bytes)
    )


def _listed(forces: Any, rest_scale: Any, loads: Any, wind: Any) -> list[tuple[str, Any, Any]]:
    """All that is set on the way: what, where, values."""
    named = (("force", forces), ("rest_scale", rest_scale), ("load", loads))
    for what, mapping in named:
        if mapping is not None and not isinstance(mapping, Mapping):
            raise TypeError(f"{what}: give a dictionary of places and arrays, not {type(mapping).__name__}")
    listed = [(what, place, value) for what, mapping in named for place, value in (mapping or {}).items()]
    return listed + ([("wind", "", wind)] if wind is not None else [])


def _action(what: str, place: Any, value: Any) -> tuple[str, Any, _Array, int]:
    """The same with an array, and how many of its last axes a time has."""
    array = np.asarray(value)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{what} {place}: give an array of numbers, not of {array.dtype}")
    where = place if isinstance(place, str) else [int(place)] if np.ndim(place) == 0 else [int(i) for i in place]
    tail = {"force": 2 if array.ndim == 4 else 1, "wind": 1}.get(what, 0)
    if array.ndim > 2 + tail or (tail and array.shape[-1:] != (3,)):
        shape = {"force": "(runs, times, 3) or (runs, times, k, 3)", "wind": "(runs, times, 3)"}
        wanted = shape.get(what, "(runs, times)")
        raise ValueError(f"{what} {place}: the shape is {wanted}, or one that spreads to it, not {array.shape}")
    return what, where, array.astype(np.float64), tail


def _initial(initial: Any) -> dict[str, Any]:
    """Positions and velocities, or snapshots."""
    if initial is None:
        return {}
    if isinstance(initial, bytes):
        return {"snapshots": [initial]}
    if _of_snapshots(initial):
        return {"snapshots": list(initial)}
    if isinstance(initial, Mapping):
        pair = dict(initial)
    elif isinstance(initial, tuple) and len(initial) == 2:
        pair = {"positions": initial[0], "velocities": initial[1]}
    else:
        raise TypeError("initial is a pair of positions and velocities, a dictionary of them, or snapshots")
    unknown = [name for name in pair if name not in ("positions", "velocities")]
    if unknown:
        raise KeyError(f"initial has positions and velocities, and no {unknown[0]!r}")
    return {name: np.asarray(value, dtype=np.float64) for name, value in pair.items() if value is not None}


def _runs(known: int | None, actions: list[tuple[str, Any, _Array, int]], start: dict[str, Any]) -> int:
    """The number of runs: of the cases, else of what has an axis for them."""
    found = [(what, len(array)) for what, _, array, tail in actions if array.ndim == 2 + tail]
    found += [(name, len(value)) for name, value in start.items() if name == "snapshots" or value.ndim == 3]
    several = [(what, count) for what, count in found if count != 1]
    runs = known if known is not None else several[0][1] if several else 1
    for what, count in several:
        if count != runs:
            raise ValueError(f"{what} is of {count} runs, and there are {runs}")
    return runs


def _spread(what: str, array: _Array, lead: tuple[int, int], tail: int) -> _Array:
    """The array with its axes for runs and times."""
    shape = lead + array.shape[array.ndim - tail :]
    try:
        return np.ascontiguousarray(np.broadcast_to(array, shape))
    except ValueError:
        raise ValueError(f"{what} has the shape {array.shape}, which does not spread to {shape}") from None


def _spread_start(name: str, value: Any, runs: int, core: _core.Case) -> Any:
    if name == "snapshots":
        return value
    shape = (runs, core.node_count, 3)
    if value.ndim not in (2, 3):
        raise ValueError(f"initial {name} have the shape (n, 3) or (runs, n, 3), not {value.shape}")
    return _spread(f"initial {name}", value, shape[:2], 1)


def _place(name: str, given: Any, shape: tuple[int, ...]) -> _Array:
    if given is None:
        return np.empty(shape)
    if not isinstance(given, np.ndarray) or given.dtype != np.float64:
        raise TypeError(f"out[{name!r}] must be an array of float64")
    if given.shape != shape:
        raise ValueError(f"out[{name!r}] must have the shape {shape}, and has {given.shape}")
    if not given.flags.c_contiguous or not given.flags.writeable or not given.flags.aligned:
        raise ValueError(f"out[{name!r}] must be C-contiguous, aligned and writable")
    return given


def _runs_made() -> Callable[[int, int], str]:
    began = time.monotonic()
    return lambda made, runs: f"{made} of {runs} runs, {time.monotonic() - began:.0f} s"
