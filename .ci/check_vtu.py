#!/usr/bin/env python3
"""Reads back the frames of a run with VTK (pip install vtk) and checks them.

    check_vtu.py DIR    DIR holds NAME.pvd and frames/; several .pvd are checked one by one

Prints a line a file set; exit status 1 and a message on any fault.
"""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

TRIANGLE, LINE, VERTEX = 5, 3, 1


class Fault(Exception):
    """What is wrong with a file."""


def need(condition, message):
    if not condition:
        raise Fault(message)


def read(path):
    """The grid of a file; VTK tells errors to observers only, and a reader has several parts that may speak."""
    need(path.is_file(), f"{path}: listed but not there")
    errors = []
    reader = vtkXMLUnstructuredGridReader()
    reader.AddObserver("ErrorEvent", lambda *_: errors.append(reader.GetClassName()))
    reader.SetFileName(str(path))
    reader.Update()
    need(not errors and reader.GetErrorCode() == 0, f"{path}: VTK reports an error (code {reader.GetErrorCode()})")
    return reader.GetOutput()


def cells_of(grid, path):
    count = grid.GetNumberOfCells()
    need(count > 0, f"{path}: no cells")
    kinds = np.fromiter((grid.GetCellType(i) for i in range(count)), dtype=np.uint8, count=count)
    need(set(kinds) <= {TRIANGLE, LINE, VERTEX}, f"{path}: unexpected cell types {set(kinds)}")
    need((np.diff((kinds != TRIANGLE).astype(int)) >= 0).all(), f"{path}: triangles do not stand before edges")
    connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    need(connectivity.min() >= 0 and connectivity.max() < grid.GetNumberOfPoints(), f"{path}: cells leave the points")
    return kinds, connectivity


def check_drawn(grid, kinds, path):
    """What VTK draws: all triangles, and the edges that are not hidden."""
    hidden = grid.GetCellData().GetArray("vtkGhostType")
    lines = kinds == LINE
    if hidden is not None:
        kind = vtk_to_numpy(grid.GetCellData().GetArray("kind"))
        need(np.array_equal(vtk_to_numpy(hidden) != 0, kind == 1), f"{path}: hidden cells are not the sides of triangles")
        lines &= kind == 2
    surface = vtkGeometryFilter()
    surface.SetInputData(grid)
    surface.Update()
    drawn = surface.GetOutput()
    need(drawn.GetNumberOfLines() == lines.sum(), f"{path}: VTK draws {drawn.GetNumberOfLines()} edges, not {lines.sum()}")
    need(drawn.GetNumberOfPolys() == (kinds == TRIANGLE).sum(), f"{path}: VTK draws {drawn.GetNumberOfPolys()} triangles")


def frame_of(path, time):
    grid = read(path)
    need(grid.GetNumberOfPoints() > 0, f"{path}: no points")
    points = vtk_to_numpy(grid.GetPoints().GetData())
    need(points.dtype in (np.float64, np.float32) and np.isfinite(points).all(), f"{path}: points are not finite numbers")
    kinds, connectivity = cells_of(grid, path)
    check_drawn(grid, kinds, path)
    arrays = {}
    for name in ("displacement", "velocity", "force", "reaction"):
        array = grid.GetPointData().GetArray(name)
        if array is None:
            need(name not in ("displacement", "velocity"), f"{path}: no point array {name}")
            continue
        need(array.GetNumberOfComponents() == 3, f"{path}: {name} is no vector")
        need(array.GetNumberOfTuples() == len(points), f"{path}: {name} has the wrong length")
        arrays[name] = vtk_to_numpy(array)
    for name in ("tension", "strain"):
        array = grid.GetCellData().GetArray(name)
        if array is not None:
            need(array.GetNumberOfTuples() == len(kinds), f"{path}: {name} has the wrong length")
            arrays[name] = vtk_to_numpy(array)
    for name, values in arrays.items():
        need(np.isfinite(values).all(), f"{path}: {name} is not finite")
    stamp = grid.GetFieldData().GetArray("TimeValue")
    need(stamp is not None and stamp.GetNumberOfTuples() == 1, f"{path}: no TimeValue")
    need(stamp.GetValue(0) == time, f"{path}: TimeValue {stamp.GetValue(0)!r} but the .pvd says {time!r}")
    # Copies: the arrays live in the grid, which ends with this function.
    return points.copy(), {name: values.copy() for name, values in arrays.items()}, kinds.copy(), connectivity.copy()


def frames_of(pvd):
    """Times and paths of the frames that a .pvd lists."""
    try:
        listed = ElementTree.parse(pvd).getroot().findall("./Collection/DataSet")
    except ElementTree.ParseError as error:
        raise Fault(f"{pvd}: not well-formed: {error}") from error
    need(listed, f"{pvd}: lists no frame")
    times = [float(entry.get("timestep")) for entry in listed]
    need(all(a < b for a, b in zip(times, times[1:])), f"{pvd}: times do not ascend")
    return times, [pvd.parent / entry.get("file") for entry in listed]


def check(pvd):
    times, paths = frames_of(pvd)
    first = None
    for path, time in zip(paths, times):
        frame = frame_of(path, time)
        first = first or frame
        points, arrays, kinds, connectivity = frame
        need(np.array_equal(kinds, first[2]) and np.array_equal(connectivity, first[3]), f"{path}: cells changed")
        need(arrays.keys() == first[1].keys(), f"{path}: arrays changed")
        moved = points - first[0]
        told = arrays["displacement"] - first[1]["displacement"]
        scale = max(1.0, np.abs(points).max(), np.abs(arrays["displacement"]).max())
        worst = np.abs(moved - told).max()
        rounding = 1e-12 if arrays["displacement"].dtype == np.float64 else 3e-7
        need(worst <= rounding * scale, f"{path}: points and displacement differ by {worst} m")
    lo, hi = points.min(axis=0), points.max(axis=0)
    print(
        f"{pvd.name}: {len(times)} frames, t {times[0]:g} .. {times[-1]:g} s, {len(points)} points, "
        f"{(kinds == TRIANGLE).sum()} triangles, {(kinds == LINE).sum()} edges, {(kinds == VERTEX).sum()} vertices; "
        f"arrays {', '.join(arrays)}; last box {np.array2string(lo, precision=4)} .. {np.array2string(hi, precision=4)}, "
        f"largest displacement {np.linalg.norm(arrays['displacement'], axis=1).max():.6g} m"
    )


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(sys.argv[1])
    collections = sorted(folder.glob("*.pvd"))
    try:
        need(collections, f"{folder}: no .pvd")
        for pvd in collections:
            check(pvd)
    except Fault as fault:
        print(f"check_vtu: {fault}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
