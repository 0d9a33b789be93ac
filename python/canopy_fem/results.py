"""What runs have left: summary, tables and frames."""

from __future__ import annotations

import copy
import html
import json
import os
import shutil
import subprocess
import tempfile
import weakref
import xml.etree.ElementTree as xml
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from .errors import CanopyError
from .names import Named, unknown
from .studies import program
from .tables import empty, of_columns, read

if TYPE_CHECKING:
    from typing_extensions import Self

    from .typed import Table

__all__ = ["Page", "Quantity", "Result", "load"]


class Quantity(NamedTuple):
    """A number of a run."""

    value: float | None
    """None where the run did not come to it, and for ``motion``."""
    unit: str
    """Its unit, ``"-"`` without one."""
    error: float | None
    """Estimate of its error by the steps, in its unit; None unless ``canopy-fem solve --verify`` made the run."""


class Keeper:
    """A temporary folder that goes with this object, or with the interpreter, but only in the process that made it."""

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="canopy-fem-"))
        weakref.finalize(self, _remove, str(self.folder), os.getpid())


def _remove(folder: str, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def folder_of(out: str | os.PathLike[str] | None) -> tuple[Path, Keeper | None]:
    """Where results go, and what keeps that folder if it is a temporary one."""
    if out is not None:
        return Path(os.fspath(out)), None
    keeper = Keeper()
    return keeper.folder / "results", keeper


def load(folder: str | os.PathLike[str]) -> Result:
    """The results in a folder, of this module or of ``canopy-fem solve``.

    Raises:
        OSError: no folder, or no summary in it.
        ValueError: a summary that cannot be read.
    """
    path = Path(os.fspath(folder))
    return Result(path, json.loads((path / "summary.json").read_text(encoding="utf-8")))


class Page:
    """A page for a browser that needs nothing else; a notebook displays it."""

    __slots__ = ("height", "html")

    html: str
    """its text, to be written into a file"""
    height: int
    """[px] in a notebook"""

    def __init__(self, html: str, height: int) -> None:
        self.html = html
        self.height = height

    def _repr_html_(self) -> str:
        style = f"width: 100%; height: {self.height}px; border: 0"
        return f'<iframe srcdoc="{html.escape(self.html)}" style="{style}"></iframe>'


class Result:
    """A finished run: its folder, its summary, and its tables.

    `history`, `probes` and `gauges` are numpy structured arrays with the columns of the files, read when first asked
    for; columns are e.g. ``result.history["kinetic"]`` [J].

    A result of a run without files has them from the start, and no frames: `times` is empty then.

    A result can be copied and pickled. One in a temporary folder takes its files along, so it may come from another
    process; one in a folder of yours only knows where that is.

    A temporary folder goes with its result, or at the end of a block: ``with cf.run(case) as result: …``.
    """

    __slots__ = ("__weakref__", "_folder", "_keeper", "_tables", "summary")

    summary: dict[str, Any]
    """what summary.json holds"""

    def __init__(
        self,
        folder: Path | None,
        summary: dict[str, Any],
        keeper: Keeper | None = None,
        tables: Mapping[str, Any] | None = None,
    ) -> None:
        self._folder = folder
        self.summary = summary
        self._keeper = keeper
        self._tables: dict[str, npt.NDArray[Any]] = {} if tables is None else of_columns(tables)

    @property
    def folder(self) -> Path:
        """Where the files are.

        Raises:
            CanopyError: the run has none: it was made with ``files=False``.
        """
        if self._folder is None:
            raise CanopyError("this run has no files: it was made with files=False; its tables are in memory")
        return self._folder

    def _again(self, summary: dict[str, Any]) -> Result:
        made = Result(self._folder, summary, self._keeper)
        # Tables cannot be written to, and files do not change, so they serve both.
        made._tables = dict(self._tables)
        return made

    def __copy__(self) -> Result:
        return self._again(self.summary)

    def __deepcopy__(self, memo: dict[int, Any]) -> Result:
        return self._again(copy.deepcopy(self.summary, memo))

    def __getstate__(self) -> dict[str, Any]:
        if self._folder is None:
            return {"summary": self.summary, "tables": self._tables}
        if self._keeper is None:
            return {"summary": self.summary, "folder": self.folder.absolute()}
        paths = sorted(path for path in self.folder.rglob("*") if path.is_file())
        return {
            "summary": self.summary,
            "files": {path.relative_to(self.folder).as_posix(): path.read_bytes() for path in paths},
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.summary, self._keeper = state["summary"], None
        self._tables, self._folder = state.get("tables", {}), state.get("folder")
        for table in self._tables.values():
            table.flags.writeable = False
        if "files" not in state:
            return
        self._folder, self._keeper = folder_of(None)
        self.folder.mkdir()
        for name, content in state["files"].items():
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Removes the files, if they are in a temporary folder that no copy of this result uses. The summary stays, and
        so do tables that were read."""
        self._keeper = None

    def save(self, folder: str | os.PathLike[str], *, replace: bool = False) -> Result:
        """Copies all files into a folder; the result there.

        Args:
            folder: where they go; it is made if it is not there.
            replace: replace earlier results in it.

        Raises:
            OSError: a folder with other files in it, files that cannot be written, or a result that was closed.
        """
        to = Path(os.fspath(folder))
        if not self.folder.is_dir():
            raise FileNotFoundError(f"the files of this result are gone: {self.folder}")
        if to.exists() and any(to.iterdir()):
            if not replace:
                raise FileExistsError(f"{to} is not empty: give replace=True for a folder of results")
            load(to)
            shutil.rmtree(to)
        shutil.copytree(self.folder, to, dirs_exist_ok=True)
        return Result(to, copy.deepcopy(self.summary))

    @property
    def status(self) -> str:
        """``"completed"``, ``"diverged"``, ``"not-converged"`` or ``"interrupted"``."""
        return str(self.summary["status"])

    @property
    def failure(self) -> dict[str, Any] | None:
        """The post-mortem of a run that failed: cause, advice, time [s], node, …"""
        return self.summary.get("failure")

    @property
    def peaks(self) -> dict[str, float]:
        """Largest values of the gauges, by ``"name quantity"``."""
        found = {f"{peak['name']} {peak['quantity']}": peak["value"] for peak in self.summary.get("peaks", [])}
        return Named("gauge", found)

    @property
    def quantities(self) -> dict[str, Quantity]:
        """The numbers of the report, or those that ``study.quantities`` of the case asks for, by name, such as
        ``"riser.tension.peak"``."""
        found = self.summary.get("quantities", {})
        made = {name: Quantity(of["value"], of["unit"], of.get("error")) for name, of in found.items()}
        return Named("quantity", made)

    @property
    def history(self) -> npt.NDArray[Any]:
        """A row a step or every n: t [s], step, energies [J], newton_iterations, residual, max_speed [m/s],
        max_strain [-]."""
        return self._table("history")

    @property
    def probes(self) -> npt.NDArray[Any]:
        """A row a node and frame time: t [s], name, node, x, y, z [m], vx, vy, vz [m/s]."""
        return self._table("probes")

    @property
    def gauges(self) -> npt.NDArray[Any]:
        """A row a value: t [s], name, quantity, value in its SI unit."""
        return self._table("gauges")

    @property
    def equilibrium(self) -> dict[str, Any] | None:
        """Of `static`: residual [N], potential_energy [J], stability, findings, …"""
        return self.summary.get("equilibrium")

    @property
    def modes(self) -> npt.NDArray[Any]:
        """A row a vibration mode: mode, frequency [Hz], omega_squared [1/s^2], the node and axis that move most, and
        mass_x, mass_y, mass_z [kg], what moves in it if a support shakes along an axis, growth [1/s], 0 for a mode that
        oscillates, and error [1/s^2], how far omega_squared may be from one that the scene has."""
        return self._table("modes")

    def gauge(self, name: str, quantity: str | None = None) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Times [s] and values of one gauge.

        Raises:
            KeyError: no such gauge, or several quantities and none named.
        """
        rows = self.gauges[self.gauges["name"] == name]
        known = sorted(set(rows["quantity"].tolist()))
        if quantity is None and len(known) == 1:
            quantity = known[0]
        if not known:
            raise unknown("gauge", name, sorted(set(self.gauges["name"].tolist())))
        if quantity is None:
            raise KeyError(f"gauge {name!r} has several quantities: {', '.join(known)}; name one of them")
        if quantity not in known:
            raise KeyError(f"gauge {name!r} has no quantity {quantity!r}; it has: {', '.join(known)}")
        rows = rows[rows["quantity"] == quantity]
        return rows["t"], rows["value"]

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """[s] Times of the frames."""
        if self._folder is None:
            return np.array([])
        file = self._one_file()
        return np.array(_core.frame_times(file) if file else [t for t, _ in self._frames()])

    def frame(self, t: float | None = None) -> Path:
        """The .vtu file of the frame nearest to a time [s]; of the last one if left out.

        Raises:
            CanopyError: there are no frames, or all are in one file (``output.format`` is ``"vtkhdf"``), of which
                :meth:`to_pyvista` reads one.
        """
        if file := self._one_file():
            raise CanopyError(f"{file} holds all frames of the run: to_pyvista(t) reads one, times has their times")
        frames = self._frames()
        if not frames:
            raise CanopyError(f"{self.folder} has no frames")
        return frames[-1][1] if t is None else min(frames, key=lambda frame: abs(frame[0] - t))[1]

    def to_pandas(self, table: Table = "history") -> Any:
        """A table, ``"history"``, ``"probes"``, ``"gauges"`` or ``"modes"``, as a pandas DataFrame.

        Raises:
            ImportError: pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self._table(table))

    def to_polars(self, table: Table = "history") -> Any:
        """The same as a polars DataFrame, whose columns Arrow has.

        Raises:
            ImportError: polars is not installed.
        """
        import polars

        rows = self._table(table)
        return polars.DataFrame({name: rows[name] for name in rows.dtype.names or ()})

    def to_xarray(self) -> Any:
        """The history as an xarray.Dataset over t [s], and each column of a gauge, ``"name quantity"``, over a t of its
        own.

        Raises:
            ImportError: xarray is not installed.
        """
        import xarray

        rows = self.history
        made = {name: ("t", rows[name]) for name in rows.dtype.names or () if name != "t"}
        times: dict[str, Any] = {"t": rows["t"]}
        for name, quantity in dict.fromkeys(
            zip(self.gauges["name"].tolist(), self.gauges["quantity"].tolist(), strict=True)
        ):
            t, values = self.gauge(name, quantity)
            own = next((other for other, known in times.items() if np.array_equal(known, t)), f"t {name}")
            times[own] = t
            made[f"{name} {quantity}"] = (own, values)
        return xarray.Dataset(made, times)

    def to_pyvista(self, t: float | None = None, into: Any = None) -> Any:
        """The frame nearest to a time [s], or the last one, as a pyvista.UnstructuredGrid with all its fields.

        Args:
            t: time of the frame.
            into: a grid of an earlier call, which shows that frame from then on, also where a plotter has it.

        Raises:
            ImportError: pyvista is not installed.
        """
        grid = self._grid(t)
        if into is None:
            return grid
        into.copy_from(grid)
        return into

    def _grid(self, t: float | None) -> Any:
        import pyvista

        file = self._one_file()
        if file is None:
            return pyvista.read(self.frame(t))
        from vtkmodules.vtkIOHDF import vtkHDFReader

        times = self.times
        if not len(times):
            raise CanopyError(f"{self.folder} has no frames")
        reader = vtkHDFReader()
        reader.SetFileName(str(file))
        reader.UpdateInformation()
        reader.SetStep(len(times) - 1 if t is None else int(np.abs(times - t).argmin()))
        reader.Update()
        return pyvista.wrap(reader.GetOutputDataObject(0))

    def show(self, height: int = 760) -> Page:
        """The run in 3D with its gauges, as the page of ``canopy-fem view``; a notebook displays it.

        Args:
            height: [px] of the page in a notebook.

        Raises:
            CanopyError: the program is not there, or the run has no frames that can be shown.
        """
        own = self.folder
        with tempfile.TemporaryDirectory() as folder:
            command = [str(program()), "view", str(own), "--out", folder, "--quiet"]
            ended = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
            if ended.returncode != 0:
                raise CanopyError(ended.stderr.strip().removeprefix("error: "))
            return Page((Path(folder) / "view.html").read_text(encoding="utf-8"), height)

    def plot(self, axes: Any = None) -> Any:
        """Draws the energies over time with matplotlib; the axes.

        Raises:
            ImportError: matplotlib is not installed.
        """
        if axes is None:
            from matplotlib import pyplot

            axes = pyplot.subplots(layout="constrained")[1]
        for name in ("kinetic", "elastic", "gravity", "external_work", "dissipated", "numerical"):
            if np.any(self.history[name]):
                axes.plot(self.history["t"], self.history[name], label=name.replace("_", " "))
        axes.set_xlabel("time [s]")
        axes.set_ylabel("energy [J]")
        # Above the axes, where it hides no line.
        axes.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        return axes

    def __repr__(self) -> str:
        run = self.summary
        added = run.get("mass_scaling")
        masses = f", with {added['added']:.3g} kg of added mass" if added else ""
        steps = f"{run['steps']} steps of {run['method']}"
        return f"<Result: {run['status']} at t = {run['t_end']:g} s after {steps}{masses}>"

    def _repr_html_(self) -> str:
        rows = [("status", self.status), ("steps", self.summary["steps"]), ("end [s]", f"{self.summary['t_end']:g}")]
        rows += [("energy error", f"{self.summary['energy_error']:.2e}")]
        rows += [("folder", "none" if self._folder is None else "temporary" if self._keeper else self._folder)]
        rows += [(name, f"{value:.6g}") for name, value in self.peaks.items() if value is not None]
        cells = "".join(f"<tr><td>{html.escape(str(a))}</td><td>{html.escape(str(b))}</td></tr>" for a, b in rows)
        return f"<b>{html.escape(repr(self))}</b><table>{cells}</table>"

    def _table(self, name: str) -> npt.NDArray[Any]:
        if name not in ("history", "probes", "gauges", "modes"):
            raise KeyError(f"no table {name!r}; there are history, probes, gauges and modes")
        if name not in self._tables and self._folder is None:
            return empty(name)
        if name not in self._tables:
            self._tables[name] = read(self.folder / f"{name}.csv", name)
        return self._tables[name]

    def _one_file(self) -> Path | None:
        files = sorted(self.folder.glob("*.vtkhdf"))
        return files[0] if files else None

    def _frames(self) -> list[tuple[float, Path]]:
        lists = sorted(self.folder.glob("*.pvd"))
        if not lists:
            return []
        entries = xml.parse(lists[0]).getroot().iter("DataSet")
        return [(float(entry.attrib["timestep"]), self.folder / entry.attrib["file"]) for entry in entries]
