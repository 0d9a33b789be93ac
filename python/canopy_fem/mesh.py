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
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Mesh
from .case import plain

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


def annulus(*, inner_radius: float, outer_radius: float, nodes: int, **more: Any) -> Mesh:
    """A flat ring [m] in the x-y plane; more: boundary_nodes, seams, seed, grading. Raises CaseError as `generate`."""
    return generate("annulus", inner_radius=inner_radius, outer_radius=outer_radius, nodes=nodes, **more)


def disc(*, radius: float, nodes: int, **more: Any) -> Mesh:
    """A flat disc [m] in the x-y plane; more: boundary_nodes, seams, seed, grading. Raises CaseError as `generate`."""
    return generate("disc", radius=radius, nodes=nodes, **more)


def rectangle(*, width: float, height: float, columns: int, rows: int, **more: Any) -> Mesh:
    """A flat rectangle [m] in the x-y plane, of columns times rows cells; more: pattern. Raises as `generate`."""
    return generate("rectangle", width=width, height=height, columns=columns, rows=rows, **more)


def chain(*, start: npt.ArrayLike, end: npt.ArrayLike, segments: int) -> Mesh:
    """A straight line of edges between two points [m], (3,) each. Raises CaseError as `generate`."""
    return generate("chain", **{"from": np.asarray(start), "to": np.asarray(end), "segments": segments})


def parachute(**parameters: Any) -> Mesh:
    """A rigged parachute; the keywords of "parachute" in a case, e.g. type="flat-circular", nominal_diameter=8.5 [m].
    Raises CaseError as `generate`."""
    return generate("parachute", **parameters)


def read(
    path: str | os.PathLike[str],
    *more: str | os.PathLike[str],
    scale: float = 1.0,
    axes: str = "z-up",
    translate: Sequence[float] = (0.0, 0.0, 0.0),
    edge: float | None = None,
    merge: float | None = None,
    orient: bool = False,
    diagonals: str = "one",
) -> Mesh:
    """Reads a mesh file: VTK, Gmsh, OBJ, STL, PLY, OFF, Abaqus, LS-DYNA, Nastran, Kratos, DXF or glTF.

    A frame of a run is a mesh too.

    Args:
        path: the file; its ending tells the format.
        more: further files of the same mesh, such as one with the lines of a canopy.
        scale: [-] factor on all coordinates, 0.001 for millimetres.
        axes: "z-up", or "y-up" for files whose y axis points up: (x, y, z) becomes (x, -z, y).
        translate: [m] (3,), added after scale.
        edge: [m] closed polylines of a .dxf are filled with triangles of about this edge length; None leaves lines.
        merge: [m] nodes at most this far apart are joined; None joins none.
        orient: whether triangles are turned so that all normals of a part are on one side.
        diagonals: "one" or "both" diagonals of quads become edges.

    Raises:
        OSError: a file that cannot be read, or is no mesh.
        CaseError: an option out of range.
    """
    options = {"scale": scale, "axes": axes, "translate": list(translate)}
    options |= {"edge": edge, "merge": merge, "orient": orient}
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
    """A mesh of the lines and triangles of a meshio.Mesh; cell sets and point sets become groups. Edges are its lines,
    then the sides of its triangles that are not among them.

    Raises:
        CaseError: no mesh that can be used.
    """
    points = np.asarray(mesh.points, dtype=float)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    lines, triangles = _cells(mesh, "line", 2), _cells(mesh, "triangle", 3)
    groups: dict[str, dict[str, Any]] = {}
    for name, numbers in (mesh.point_sets or {}).items():
        groups.setdefault(name, {})["nodes"] = np.asarray(numbers, dtype=np.int64)
    for name, blocks in (mesh.cell_sets or {}).items():
        before = {"line": 0, "triangle": 0}
        for block, numbers in zip(mesh.cells, blocks, strict=True):
            kind = {"line": "edges", "triangle": "triangles"}.get(block.type)
            if kind is not None and numbers is not None and len(numbers):
                found = groups.setdefault(name, {}).setdefault(kind, [])
                found.extend((np.asarray(numbers, dtype=np.int64) + before[block.type]).tolist())
            if block.type in before:
                before[block.type] += len(block.data)
    return Mesh(points, edges=_with_sides(lines, triangles), triangles=triangles, groups=groups)


def _cells(mesh: Any, kind: str, corners: int) -> npt.NDArray[np.int64]:
    found = [np.asarray(block.data, dtype=np.int64) for block in mesh.cells if block.type == kind]
    return np.concatenate(found) if found else np.empty((0, corners), dtype=np.int64)


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


def from_pyvista(data: Any) -> Mesh:
    """A mesh of the lines and triangles of a pyvista.PolyData or UnstructuredGrid; its surface is triangulated.

    Raises:
        CaseError: no mesh that can be used.
    """
    surface = data if hasattr(data, "faces") else data.extract_surface(pass_pointid=False, pass_cellid=False)
    lines = _lines(np.asarray(surface.lines))
    faces = (
        np.asarray(surface.triangulate().faces).reshape(-1, 4)[:, 1:] if len(surface.faces) else np.empty((0, 3), int)
    )
    return Mesh(np.asarray(surface.points, dtype=float), edges=_with_sides(lines, faces), triangles=faces)


def _lines(padded: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Pairs of nodes of VTK's list of polylines: count, nodes, count, nodes, …"""
    pairs: list[Any] = []
    at = 0
    while at < len(padded):
        nodes = padded[at + 1 : at + 1 + padded[at]]
        pairs.extend(zip(nodes[:-1].tolist(), nodes[1:].tolist(), strict=True))
        at += 1 + int(padded[at])
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)
