#!/usr/bin/env python3
"""Reads the mesh files that canopy-fem writes with the programs people use, and compares counts and groups.

    .ci/check_meshes.py FOLDER         cloth.vtu, .vtp, .msh, .obj, .ply, .stl, .inp, .bdf, .mdpa and .glb of one mesh
"""

import sys
from pathlib import Path

import meshio
import pyvista
import trimesh

NODES, TRIANGLES, LINES = 10, 8, 2


def count(mesh, kind):
    return sum(len(block.data) for block in mesh.cells if block.type == kind)


folder = Path(sys.argv[1])
# meshio reads no .ply with lines; VTK and trimesh do. It takes triangles of an .mdpa for lines; Kratos reads it itself.
for ending in ("vtu", "msh", "obj", "inp", "bdf"):
    mesh = meshio.read(folder / f"cloth.{ending}")
    assert len(mesh.points) == NODES, (ending, len(mesh.points))
    assert count(mesh, "triangle") == TRIANGLES, (ending, mesh)
gmsh = meshio.read(folder / "cloth.msh")
assert count(gmsh, "line") == LINES, gmsh
assert {"CANOPY", "LINES", "SKIRT"} <= set(gmsh.field_data), gmsh.field_data
for ending in ("vtu", "vtp", "ply", "stl"):
    shown = pyvista.read(folder / f"cloth.{ending}")
    assert abs(shown.compute_cell_sizes()["Area"].sum() - 1) < 1e-6, (ending, shown)
grid, surface = (pyvista.read(folder / f"cloth.{ending}") for ending in ("vtu", "vtp"))
assert len(surface.regular_faces) == TRIANGLES and surface.n_lines == grid.n_cells - TRIANGLES, surface
# A .vtp has its lines before its polygons; the same cells are in the same groups.
order = list(range(TRIANGLES, grid.n_cells)) + list(range(TRIANGLES))
assert (surface.cell_data["group"] == grid.cell_data["group"][order]).all(), surface.cell_data["group"]
deck = meshio.read(folder / "cloth.inp")
assert {"CANOPY", "LINES"} <= {name.upper() for name in deck.cell_sets} and count(deck, "line") == LINES, deck
for ending in ("obj", "stl", "glb"):
    mesh = trimesh.load(folder / f"cloth.{ending}", force="mesh")
    assert len(mesh.faces) == TRIANGLES and abs(mesh.area - 1) < 1e-6, (ending, mesh)
print("meshes: meshio, VTK and trimesh read what was written")
