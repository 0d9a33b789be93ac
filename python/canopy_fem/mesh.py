"""Meshes: generators, files, arrays, and objects of meshio and pyvista.

The keywords of a generator are those of its section in a case; the schema has their documentation
(``canopy_fem.schema()["$defs"]``). A mesh can stand in a case: ``{"mesh": canopy_fem.mesh.disc(...)}``.

>>> import canopy_fem as cf
>>> mesh = cf.mesh.rectangle(width=2.0, height=1.0, columns=4, rows=2)
>>> mesh.nodes.shape, mesh.triangles.shape
((15, 3), (16, 3))
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Mesh
from .case import plain
from .errors import CaseError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .typed import Graded, Parachute, Pattern

__all__ = [
    "Mesh", "annulus", "chain", "disc", "from_meshio", "from_pyvista", "generate", "parachute", "read", "rectangle",
    "to_meshio", "to_pyvista",
]  # fmt: skip


def generate(kind: str, **parameters: Any) -> Mesh:
    """A mesh of any kind that a case knows: annulus, disc, rectangle, chain, parachute.

    Raises:
        CaseError: an unknown kind or parameter, or one out of range.
    """
    section = {kind: {key: value for key, value in parameters.items() if value is not None}}
    return _core.generate(json.dumps(plain(section)), Path("."))


def annulus(*, inner_radius: float, outer_radius: float, nodes: int, **more: Unpack[Graded]) -> Mesh:
    """A flat ring [m] in the x-y plane; more: boundary_nodes, seams, seed, grading. Raises CaseError as `generate`."""
    return generate("annulus", inner_radius=inner_radius, outer_radius=outer_radius, nodes=nodes, **more)


def disc(*, radius: float, nodes: int, **more: Unpack[Graded]) -> Mesh:
    """A flat disc [m] in the x-y plane; more: boundary_nodes, seams, seed, grading. Raises CaseError as `generate`."""
    return generate("disc", radius=radius, nodes=nodes, **more)


def rectangle(*, width: float, height: float, columns: int, rows: int, **more: Unpack[Pattern]) -> Mesh:
    """A flat rectangle [m] in the x-y plane, of columns times rows cells; more: pattern. Raises as `generate`."""
    return generate("rectangle", width=width, height=height, columns=columns, rows=rows, **more)


def chain(*, start: npt.ArrayLike, end: npt.ArrayLike, segments: int) -> Mesh:
    """A straight line of edges between two points [m], (3,) each. Raises CaseError as `generate`."""
    return generate("chain", **{"from": np.asarray(start), "to": np.asarray(end), "segments": segments})


def parachute(**parameters: Unpack[Parachute]) -> Mesh:
    """A rigged parachute; the keywords of "parachute" in a case, e.g. type="flat-circular", nominal_diameter=8.5 [m].
    Raises CaseError as `generate`."""
    return generate("parachute", **parameters)


def read(
    path: str | os.PathLike[str],
    *more: str | os.PathLike[str],
    scale: float | None = None,
    axes: str = "auto",
    translate: Sequence[float] = (0.0, 0.0, 0.0),
    edge: float | None = None,
    merge: float | None = None,
    orient: bool = False,
    diagonals: str = "one",
    sew: Sequence[Mapping[str, Any]] = (),
) -> Mesh:
    """Reads a mesh file: VTK, Gmsh, OBJ, STL, PLY, OFF, Abaqus, LS-DYNA, Nastran, Kratos, DXF or glTF.

    A frame of a run is a mesh too.

    Args:
        path: the file; its ending tells the format.
        more: further files of the same mesh, such as one with the lines of a canopy.
        scale: [-] factor on all coordinates, 0.001 for millimetres; None follows a .dxf that states its unit.
        axes: "y-up" for files whose y axis points up: (x, y, z) becomes (x, -z, y); "z-up"; "auto" turns glTF alone.
        translate: [m] (3,), added after scale.
        edge: [m] closed polylines of a .dxf are filled with triangles of about this edge length; None leaves lines.
        merge: [m] nodes at most this far apart are joined; None joins none.
        orient: whether triangles are turned so that all normals of a part are on one side.
        diagonals: "one" or "both" diagonals of quads become edges.
        sew: seams along which flat pieces are joined, as in a case: [{"gores": ["gore-1"], "copies": 12}].

    Raises:
        OSError: a file that cannot be read, or is no mesh.
        CaseError: an option out of range.
    """
    options: dict[str, Any] = {
        "axes": axes,
        "translate": list(translate),
        "edge": edge,
        "merge": merge,
        "orient": orient,
    }
    if scale is not None:
        options["scale"] = scale
    if sew:
        options["sew"] = [dict(seam) for seam in sew]
    section = {"file": os.fspath(path), "with": [os.fspath(other) for other in more], **options, "diagonals": diagonals}
    return _core.generate(json.dumps(section), Path(""))


def to_meshio(mesh: Mesh) -> Any:
    """The mesh as a meshio.Mesh: lines are its edges; groups are cell sets and point sets.

    Raises:
        ImportError: meshio is not installed.
    """
    import meshio

    edges, triangles = mesh.edges.astype(np.int64), mesh.triangles.astype(np.int64)
    blocks = [(kind, cells) for kind, cells in (("line", edges), ("triangle", triangles)) if len(cells)]
    kinds = {"line": "edges", "triangle": "triangles"}
    points, cells = {}, {}
    for name, group in mesh.groups.items():
        if "nodes" in group:
            points[name] = group["nodes"].astype(np.int64)
        if "edges" in group or "triangles" in group:
            none = np.empty(0, dtype=np.int64)
            cells[name] = [np.asarray(group.get(kinds[kind], none), dtype=np.int64) for kind, _ in blocks]
    return meshio.Mesh(mesh.nodes, blocks, point_sets=points, cell_sets=cells)


def from_meshio(mesh: Any) -> Mesh:
    """A mesh of the lines, triangles and quads of a meshio.Mesh; cell sets and point sets become groups.

    Quads are cut in two, as readers of files do, along their first diagonal or that which lies inside. Edges are the
    lines, then the sides of the triangles that are not among them. `Mesh.notes` tells what was cut or left out.

    Raises:
        CaseError: cells of other kinds, such as those of second order and volumes; no mesh that can be used.
    """
    points = np.asarray(mesh.points, dtype=float)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    made, sides = _Cells(points), []
    for block in mesh.cells:
        sides.append(made.add(block.type, block.data))
    groups: dict[str, dict[str, Any]] = {}
    for name, numbers in (mesh.point_sets or {}).items():
        groups.setdefault(name, {})["nodes"] = np.asarray(numbers, dtype=np.int64)
    for name, blocks in (mesh.cell_sets or {}).items():
        for (kind, of), numbers in zip(sides, blocks, strict=True):
            if kind is not None and numbers is not None and len(numbers):
                found = groups.setdefault(name, {}).setdefault(kind, [])
                found.extend(of[np.isin(of[:, 0], numbers), 1].tolist())
    return made.mesh(groups)


class _Cells:
    """Lines and triangles, as they are found."""

    def __init__(self, points: npt.NDArray[np.float64]) -> None:
        self._points = points
        self._lines: list[npt.NDArray[np.int64]] = []
        self._triangles: list[npt.NDArray[np.int64]] = []
        self._counts = {"edges": 0, "triangles": 0}
        self._quads = self._spots = 0

    def add(self, kind: str, cells: Any) -> tuple[str | None, npt.NDArray[np.int64]]:
        """Adds cells of one of meshio's kinds: what they become, and for each part its cell and number, (k, 2)."""
        if kind == "vertex":
            self._spots += len(cells)
            return None, np.empty((0, 2), dtype=np.int64)
        if kind == "polygon" and all(len(cell) == 4 for cell in cells):
            kind = "quad"
        if kind == "polygon" and all(len(cell) == 3 for cell in cells):
            kind = "triangle"
        if kind not in ("line", "triangle", "quad"):
            raise CaseError(
                f"the mesh holds {len(cells)} cells of type {kind}: only lines, triangles and quads of first order are "
                "taken. Make the surface mesh alone, of first order"
            )
        cells = np.asarray(cells, dtype=np.int64)
        if len(cells) and not (0 <= cells.min() and cells.max() < len(self._points)):
            raise CaseError(f"a {kind} names node {cells.max()}; nodes are numbered 0 to {len(self._points) - 1}")
        of = np.arange(len(cells))
        if kind == "quad":
            self._quads += len(cells)
            cells, of = _halves(self._points, cells)
        what = "edges" if kind == "line" else "triangles"
        (self._lines if kind == "line" else self._triangles).append(cells)
        first = self._counts[what]
        self._counts[what] += len(cells)
        return what, np.column_stack([of, np.arange(first, first + len(cells))])

    def mesh(self, groups: Any) -> Mesh:
        lines = np.concatenate([np.empty((0, 2), dtype=np.int64), *self._lines])
        triangles = np.concatenate([np.empty((0, 3), dtype=np.int64), *self._triangles])
        notes = []
        if self._quads:
            notes.append(f"{self._quads} quads were cut into two triangles each")
        if self._spots:
            notes.append(f"{self._spots} point cells were left out")
        edges = _with_sides(lines, triangles)
        return _core._mesh_of(self._points, edges, triangles, groups, ([], np.empty((0, 3)), notes))


def _halves(
    points: npt.NDArray[np.float64], quads: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Triangles of quads, (k, 3), and the quad of each, (k,): along the first diagonal if the halves turn the same way,
    else along the second. A quad with a corner twice is a triangle."""

    def turned(p: int, q: int, r: int) -> npt.NDArray[np.float64]:
        at = points[quads]
        return np.asarray(np.cross(at[:, q] - at[:, p], at[:, r] - at[:, p]))

    first = np.einsum("ij,ij->i", turned(0, 1, 2), turned(0, 2, 3))
    second = np.einsum("ij,ij->i", turned(0, 1, 3), turned(1, 2, 3))
    crossed = np.flatnonzero((first < 0) & (second < 0))
    if len(crossed):
        raise CaseError(
            f"a quad crosses itself: its corners, nodes {quads[crossed[0]].tolist()}, are not in order around it"
        )
    along_second = ((first <= 0) & (second > 0))[:, None, None]
    halves = np.where(along_second, quads[:, [[0, 1, 3], [1, 2, 3]]], quads[:, [[0, 1, 2], [0, 2, 3]]])
    triangles, of = halves.reshape(-1, 3), np.repeat(np.arange(len(quads)), 2)
    whole = (np.diff(np.sort(triangles, axis=1), axis=1) != 0).all(axis=1)
    return triangles[whole], of[whole]


def _with_sides(lines: npt.NDArray[Any], triangles: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The lines, then the other sides of triangles, in ascending order."""
    sides = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 0, 2]].reshape(-1, 2), axis=1), axis=0)
    known = {tuple(pair) for pair in np.sort(lines, axis=1).tolist()}
    others = [pair for pair in sides.tolist() if tuple(pair) not in known]
    return np.array(lines.tolist() + others, dtype=np.int64).reshape(-1, 2)


def to_pyvista(mesh: Mesh, positions: npt.ArrayLike | None = None) -> Any:
    """The mesh as a pyvista.PolyData, with its nodes at other positions [m], (n, 3), if they are given.

    Raises:
        ImportError: pyvista is not installed.
    """
    import pyvista

    points = mesh.nodes if positions is None else np.asarray(positions, dtype=float)

    def padded(cells: npt.NDArray[Any]) -> Any:
        count = np.full((len(cells), 1), cells.shape[1])
        return np.hstack([count, cells]).astype(np.int64).ravel() if len(cells) else None

    return pyvista.PolyData(points, lines=padded(mesh.edges), faces=padded(mesh.triangles))


# Cells of VTK that have lines, triangles or quads of first order: vertex to quad.
_FLAT = range(1, 10)


def from_pyvista(data: Any) -> Mesh:
    """A mesh of the lines, triangles, strips, quads and polygons of a pyvista.PolyData, UnstructuredGrid or other grid.

    Quads are cut as `from_meshio` does, and polygons of more corners as pyvista does. `Mesh.notes` tells what was cut
    or left out.

    Raises:
        CaseError: cells of other kinds, such as those of second order and volumes; no mesh that can be used.
    """
    kinds = sorted({int(kind) for kind in getattr(data, "celltypes", ())} - set(_FLAT))
    if kinds:
        raise CaseError(
            f"the grid holds cells of VTK's types {', '.join(map(str, kinds))}: only lines, triangles and quads of "
            "first order are taken. Give its surface, of first order: grid.extract_surface(nonlinear_subdivision=0)"
        )
    surface = data if hasattr(data, "faces") else data.extract_surface(pass_pointid=False, pass_cellid=False)
    made = _Cells(np.asarray(surface.points, dtype=float))
    spots = _padded(np.asarray(surface.verts))
    if spots:
        made.add("vertex", spots)
    made.add("line", _pairs(_padded(np.asarray(surface.lines))))
    faces = _padded(np.asarray(surface.faces))
    if any(len(face) > 4 for face in faces):
        whole = type(surface)(surface.points, faces=np.asarray(surface.faces)).triangulate()
        faces = _padded(np.asarray(whole.faces))
    # In the order of the cells, as far as kinds go together.
    start = 0
    for end in range(1, len(faces) + 1):
        if end == len(faces) or len(faces[end]) != len(faces[start]):
            made.add({3: "triangle", 4: "quad"}.get(len(faces[start]), "polygon"), faces[start:end])
            start = end
    strips = [
        [strip[i + i % 2], strip[i + 1 - i % 2], strip[i + 2]]
        for strip in _padded(np.asarray(surface.strips))
        for i in range(len(strip) - 2)
    ]
    made.add("triangle", np.array(strips, dtype=np.int64).reshape(-1, 3))
    return made.mesh({})


def _padded(numbers: npt.NDArray[Any]) -> list[list[int]]:
    """The lists in one of VTK's: count, nodes, count, nodes, …"""
    lists, at, flat = [], 0, numbers.tolist()
    while at < len(flat):
        lists.append(flat[at + 1 : at + 1 + flat[at]])
        at += 1 + flat[at]
    return lists


def _pairs(polylines: list[list[int]]) -> npt.NDArray[Any]:
    pairs = [pair for line in polylines for pair in zip(line[:-1], line[1:], strict=True)]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)
