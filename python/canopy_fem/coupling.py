"""What a coupling with another program needs of a simulation: an interface, and steps that can be made again.

`canopy_fem.kratos` and `canopy_fem.precice` are made of it. A program of your own uses it like this:

>>> structure = Structure("drop.json", ["canopy"])              # doctest: +SKIP
>>> structure.push("canopy", forces)                            # doctest: +SKIP
>>> structure.solve(0.01)                                       # doctest: +SKIP
>>> structure.displacements("canopy")                           # doctest: +SKIP
>>> structure.accept()                                          # doctest: +SKIP
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .case import Case
from .errors import CanopyError, CouplingError, CouplingLost, Diverged, SimulationError
from .mesh import Mesh
from .simulation import Motion, Simulation

if TYPE_CHECKING:
    from .typed import CaseSource

__all__ = ["Frames", "Interface", "Structure", "frames"]

_Array = npt.NDArray[np.float64]
# How many times a step that cannot be solved is halved.
_CUTS = 5
# [-] Share of a step by which times may differ.
_SLACK = 1e-9


class Interface:
    """The nodes of a group as a flow sees them.

    In three dimensions each node is a point of the interface. In two, the scene has some depth along z: nodes with the
    same x and y are one point. Its displacement is their mean, and they share its force [N/m] times the depth, each by
    the part of the depth that is nearest to it. So forces do the same work on both sides.

    Args:
        sim: the scene.
        group: nodes of a group, or "all", "boundary", "outer", "inner".
        dimensions: 3, or 2 for a flow in the x-y plane.
        depth: [m] along z, in two dimensions; left out, the extent of the nodes in z, or 1 where that is 0.

    Raises:
        CouplingError: an unknown group, one without nodes, another number of dimensions, a depth of 0 or less.
    """

    def __init__(self, sim: Simulation, group: str, *, dimensions: int = 3, depth: float | None = None) -> None:
        if dimensions not in (2, 3):
            raise CouplingError(f"an interface has 2 or 3 dimensions, not {dimensions!r}")
        try:
            nodes = sim.select(group)
        except KeyError as error:
            raise CouplingError(f'interface "{group}": {error.args[0]}') from None
        if not len(nodes):
            raise CouplingError(f'interface "{group}": the group has no nodes')
        self.group, self.dimensions = group, dimensions
        self.nodes: npt.NDArray[np.int64] = nodes.astype(np.int64)
        self._count = sim.node_count
        self._reference = sim.reference[self.nodes]
        self._point, self._first = _points(self._reference, dimensions)
        # [-] share of each node in its point
        self._share = _shares(self._reference[:, 2], self._point)
        self._scale = 1.0 if dimensions == 3 else _depth(self._reference, depth)
        of = np.full(self._count, -1)
        of[self.nodes] = self._point
        self._edges, self._triangles = _inside(sim.edges, of, dimensions), _inside(sim.triangles, of, dimensions)

    def __len__(self) -> int:
        """Number of points."""
        return len(self._first)

    @property
    def points(self) -> _Array:
        """[m] points before any displacement, (k, dimensions)"""
        return self._reference[self._first, : self.dimensions]

    @property
    def edges(self) -> npt.NDArray[np.int64]:
        """pairs of points, (m, 2)"""
        return self._edges

    @property
    def triangles(self) -> npt.NDArray[np.int64]:
        """triples of points, (t, 3); none in two dimensions"""
        return self._triangles

    def mean(self, rows: _Array) -> _Array:
        """Values of all nodes, (n, 3), at the points, (k, dimensions)."""
        return self._mean(rows[self.nodes])

    def displacements(self, positions: _Array) -> _Array:
        """[m] of the points, (k, dimensions), where the nodes of the scene are at these positions, (n, 3)."""
        return self._mean(positions[self.nodes] - self._reference)

    def spread(self, forces: npt.ArrayLike) -> _Array:
        """[N] forces on all nodes of the scene, (n, 3), for those on the points: (k, dimensions), [N] or [N/m].

        Raises:
            CouplingError: forces of another shape, or that are not finite.
        """
        given = np.asarray(forces, dtype=float)
        needed = (len(self), self.dimensions)
        if given.shape != needed:
            raise CouplingError(
                f'interface "{self.group}" has {needed[0]} points in {needed[1]} dimensions, '
                f"the forces have the shape {given.shape}"
            )
        wrong = np.flatnonzero(~np.isfinite(given).all(axis=1))
        if len(wrong):
            first = int(wrong[0])
            raise CouplingError(
                f'interface "{self.group}": the force on point {first} at {self.points[first].tolist()} m is '
                f"{given[first].tolist()}; {len(wrong)} of {len(self)} points have a force that is not finite"
            )
        out = np.zeros((self._count, 3))
        out[self.nodes, : self.dimensions] = self._scale * self._share[:, None] * given[self._point]
        return out

    def _mean(self, rows: _Array) -> _Array:
        total = np.zeros((len(self), self.dimensions))
        np.add.at(total, self._point, self._share[:, None] * rows[:, : self.dimensions])
        return total


def _points(reference: _Array, dimensions: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """The point of each node, and the first node of each point."""
    if dimensions == 3:
        return np.arange(len(reference)), np.arange(len(reference))
    size = float(np.ptp(reference, axis=0).max()) or 1.0
    grid = np.round(reference[:, :2] / (1e-9 * size))
    _, first, inverse = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return rank[inverse.ravel()], first[order]


def _shares(z: _Array, point: npt.NDArray[np.int64]) -> _Array:
    """The part of the depth of a point that is nearest to each of its nodes; equal parts where all are at one depth."""
    order = np.lexsort((z, point))
    same = np.diff(point[order]) == 0
    half = np.where(same, np.diff(z[order]) / 2, 0.0)
    parts = np.empty(len(z))
    parts[order] = np.concatenate([[0.0], half]) + np.concatenate([half, [0.0]])
    total = np.bincount(point, parts)
    equal = 1.0 / np.bincount(point)
    safe = np.where(total > 0, total, 1.0)
    shares: _Array = np.where(total[point] > 0, parts / safe[point], equal[point])
    return shares


def _depth(reference: _Array, depth: float | None) -> float:
    if depth is None:
        return float(np.ptp(reference[:, 2])) or 1.0
    if not (np.isfinite(depth) and depth > 0):
        raise CouplingError(f"the depth of an interface is {depth!r}: give a length [m] above 0")
    return float(depth)


def _inside(cells: npt.NDArray[Any], of: npt.NDArray[np.int64], dimensions: int) -> npt.NDArray[np.int64]:
    """Cells all of whose corners are different points, each once."""
    corners = of[cells.astype(np.int64)]
    corners = corners[(corners >= 0).all(axis=1)]
    if cells.shape[1] == 3:
        return corners if dimensions == 3 else np.empty((0, 3), dtype=np.int64)
    corners = np.sort(corners[corners[:, 0] != corners[:, 1]], axis=1)
    return np.unique(corners, axis=0) if len(corners) else corners.reshape(0, 2)


class Structure:
    """A scene that a coupling moves in steps of its own size, and as often as it wants from the same start.

    Args:
        case: a case, its file or dictionary; a fixed `time.step` is the longest step within one of the coupling.
        groups: the interfaces.
        dimensions, depth: of the interfaces, as `Interface` has them.
        overrides: other values of the case by dotted path.
        threads: threads of scenes above 2,000 nodes.
        cuts: how many times a step that diverges or cannot be solved is halved before the coupling is told.

    Raises:
        CaseError: the case has faults.
        OSError: the case file cannot be read.
        CouplingError: an interface that cannot be made, or a scene that takes no forces.
    """

    def __init__(
        self,
        case: CaseSource | Case,
        groups: Iterable[str],
        *,
        dimensions: int = 3,
        depth: float | None = None,
        overrides: Mapping[str, Any] | None = None,
        threads: int = 1,
        cuts: int = _CUTS,
    ) -> None:
        self.case = Case(case, overrides)
        self.sim = Simulation(self.case, threads=threads, free_steps=True)
        self.interfaces = {
            group: Interface(self.sim, group, dimensions=dimensions, depth=depth) for group in dict.fromkeys(groups)
        }
        if not self.interfaces:
            raise CouplingError("a coupling needs at least one interface: name a group of the scene")
        self._longest = self.case.step or np.inf
        self._cuts = cuts
        self._forces: dict[str, _Array] = {}
        # The state at the start of the step, where some of it was accepted already; and where it began.
        self._start: bytes | None = None
        self._from = self.sim.time
        self._end: Motion | None = None
        for group, interface in self.interfaces.items():
            self.push(group, np.zeros_like(interface.points))
        try:
            self._put_forces()
        except SimulationError as error:
            raise CouplingError(f'"{self.case.name}" cannot be coupled: {error}') from None

    @property
    def time(self) -> float:
        """[s] end of the last accepted step"""
        return self._from

    def push(self, group: str, forces: npt.ArrayLike) -> None:
        """Sets the forces on an interface for the next `solve`, (k, dimensions): [N], or [N/m] in two dimensions.

        Raises:
            CouplingError: another shape, or values that are not finite; nothing is changed.
        """
        self._forces[f"coupling {group}"] = self.interfaces[group].spread(forces)

    def solve(self, step: float) -> None:
        """Computes a step [s] of the coupling from the end of the last accepted one, under the present forces.

        It is made in equal parts that are not longer than the step of the case, and in shorter ones where these diverge
        or cannot be solved. `displacements` and `velocities` then show its end. Another `solve` begins again.

        Raises:
            Diverged: it cannot be solved in shorter parts either. The structure is where the step began, and takes
                another `solve`, with a shorter step or other forces.
            CouplingError: a step that is not above 0 and finite.
        """
        if not (np.isfinite(step) and step > 0):
            raise CouplingError(f"the coupling asks for a step of {step!r} s: it must be above 0 and finite")
        parts = max(1, int(np.ceil(step / self._longest * (1 - _SLACK))))
        for cut in range(self._cuts + 1):
            self.rewind()
            self._put_forces()
            try:
                self._end = self._make(step, parts << cut)
                return
            except Diverged:
                if cut == self._cuts:
                    self.rewind()
                    raise

    def _put_forces(self) -> None:
        for name, force in self._forces.items():
            self.sim.forces[name] = force

    def _make(self, step: float, parts: int) -> Motion:
        """Makes the parts of a step. The last remains an attempt, so that a step of one part costs no copy."""
        until, size = self._from + step, step / parts
        if parts > 1:
            self._start = self.sim.snapshot()
        while True:
            left = until - self.sim.time
            end = self.sim.attempt(left if left <= size * (1 + _SLACK) else size)
            if not np.isfinite(end.positions).all():
                # Refuses it with a report.
                self.sim.accept()
            reached = self.sim.attempted_time
            if reached is not None and until - reached <= _SLACK * size:
                return end
            if self._start is None:
                # An event of the scene has cut it.
                self.sim.drop()
                self._start = self.sim.snapshot()
            else:
                self.sim.accept()

    def rewind(self) -> None:
        """Goes back to the end of the last accepted step."""
        if self.sim.attempted_time is not None:
            self.sim.drop()
        if self._start is not None:
            self.sim.restore(self._start)
        self._start = self._end = None

    def accept(self) -> None:
        """Accepts the step that `solve` has made.

        Raises:
            SimulationError: there is none.
            Diverged: its energy shows that its end cannot be right; the structure is where the step began.
        """
        try:
            self.sim.accept()
        except Diverged:
            self.rewind()
            raise
        self._from, self._start, self._end = self.sim.time, None, None

    @property
    def motion(self) -> Motion:
        """positions [m] and velocities [m/s] of all nodes, (n, 3), at the end of the step that was solved, or of the
        last accepted one"""
        return self._end or Motion(self.sim.positions, self.sim.velocities)

    def displacements(self, group: str) -> _Array:
        """[m] of the points of an interface, (k, dimensions), there."""
        return self.interfaces[group].displacements(self.motion.positions)

    def velocities(self, group: str) -> _Array:
        """[m/s] of the points of an interface, (k, dimensions), there."""
        return self.interfaces[group].mean(self.motion.velocities)

    def snapshot(self) -> bytes:
        """The state at the end of the last accepted step. A step that was solved is given up."""
        self.rewind()
        return self.sim.snapshot()

    def restore(self, state: bytes) -> None:
        """Goes on from a snapshot.

        Raises:
            ValueError: damaged bytes, or those of another scene or version.
        """
        self.rewind()
        self.sim.restore(state)
        self._from = self.sim.time

    def resume(self, path: str | os.PathLike[str]) -> None:
        """Goes on from a snapshot in a file.

        Raises:
            CouplingError: a file that cannot be read, or whose content is damaged or of another scene or version.
        """
        try:
            self.restore(Path(path).read_bytes())
        except (OSError, ValueError) as error:
            raise CouplingError(f'"resume" {os.fspath(path)}: {error}') from None


class Frames:
    """Where a structure is, for ParaView: a mesh file every so often, and ``NAME.pvd`` with their times.

    Args:
        structure: the structure; its case names the files.
        folder: where they go; it is made.
        every: [s] simulated time between two.

    Raises:
        OSError: the folder cannot be made, or a file not be written.
    """

    def __init__(self, structure: Structure, folder: str | os.PathLike[str], every: float) -> None:
        self._structure, self._folder, self._every = structure, Path(folder), every
        self._folder.mkdir(parents=True, exist_ok=True)
        self._written: list[tuple[float, str]] = []
        self.look()

    def look(self) -> None:
        """Writes a frame of the end of the last accepted step, if one is due."""
        structure, time = self._structure, self._structure.time
        if self._written and time < self._written[-1][0] + self._every * (1 - 1e-6):
            return
        sim, stem = structure.sim, structure.case.name
        name = f"{stem}_{len(self._written):06}.vtu"
        Mesh(sim.positions, edges=sim.edges, triangles=sim.triangles).write(self._folder / name, replace=True)
        self._written.append((time, name))
        rows = [f'    <DataSet timestep="{t:.17g}" part="0" file="{file}"/>' for t, file in self._written]
        head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        text = head + "\n".join(rows) + "\n  </Collection>\n</VTKFile>\n"
        (self._folder / f"{stem}.pvd").write_text(text, encoding="utf-8")


def frames(structure: Structure, folder: str | os.PathLike[str], every: float) -> Frames | None:
    """Frames of a structure; None where `every` is 0."""
    if every == 0:
        return None
    if not (np.isfinite(every) and every > 0):
        raise CouplingError(f"the time between frames is {every!r} s: give one above 0")
    return Frames(structure, folder, every)


def command(usage: str, run: Callable[[str], object]) -> int:
    """The status of a command that runs a coupling by its file, the only argument.

    Args:
        usage: how the command is called.
        run: runs the coupling of a file.
    """
    if len(sys.argv) != 2:
        print(f"usage: {usage}", file=sys.stderr)
        return 2
    try:
        run(sys.argv[1])
    except (CanopyError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 3 if isinstance(error, (Diverged, CouplingLost)) else 2
    return 0
