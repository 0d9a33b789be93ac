#!/usr/bin/env python3
"""Reads the one file of a run with VTK (pip install vtk) and compares it with the .vtu frames of the same run.

    check_vtkhdf.py RUN.vtkhdf DIR    DIR holds NAME.pvd and frames/

Every array of every step must have the same numbers, and the file at most 0.6 of the bytes of the frames. Prints a line;
exit status 1 and a message on any fault.
"""

import pathlib
import sys

import numpy as np
from check_vtu import Fault, frames_of, need, read
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader

# Division slash: what stands for a slash in names of arrays of the file.
SLASH = "\u2215"


def arrays(data):
    """The arrays of points, cells or fields as lists of numbers."""
    found = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
    return {array.GetName().replace(SLASH, "/"): vtk_to_numpy(array).ravel() for array in found if array is not None}


def compare(one, frame, where):
    cells = [(vtk_to_numpy(g.GetCells().GetConnectivityArray()), vtk_to_numpy(g.GetCells().GetOffsetsArray())) for g in (one, frame)]
    need(all(np.array_equal(a, b) for a, b in zip(*cells)), f"{where}: other cells")
    points = [vtk_to_numpy(grid.GetPoints().GetData()) for grid in (one, frame)]
    need(np.array_equal(*points), f"{where}: other points")
    count = 0
    for kind in ("GetPointData", "GetCellData", "GetFieldData"):
        found, expected = (arrays(getattr(grid, kind)()) for grid in (one, frame))
        # The time, which every format has its own array for.
        found.pop("Time", None), expected.pop("TimeValue", None)
        need(found.keys() == expected.keys(), f"{where}: arrays {set(found) ^ set(expected)} are in one of the two only")
        for name, values in expected.items():
            need(np.array_equal(found[name], values), f"{where}: other numbers in {name}")
        count += len(expected)
    return count


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    path, folder = map(pathlib.Path, sys.argv[1:])
    try:
        (pvd,) = folder.glob("*.pvd")
        times, frames = frames_of(pvd)
        errors = []
        reader = vtkHDFReader()
        reader.AddObserver("ErrorEvent", lambda *_: errors.append(reader.GetClassName()))
        reader.SetFileName(str(path))
        reader.UpdateInformation()
        need(not errors, f"{path}: VTK reports an error")
        need(reader.GetNumberOfSteps() == len(frames), f"{path}: {reader.GetNumberOfSteps()} steps, {len(frames)} frames")
        size = 0
        for step, (time, frame) in enumerate(zip(times, frames)):
            reader.SetStep(step)
            reader.Update()
            need(not errors and reader.GetErrorCode() == 0, f"{path}: VTK reports an error at step {step}")
            size += frame.stat().st_size
            need(reader.GetTimeValue() == time, f"{path}: step {step} is at {reader.GetTimeValue()} s")
            count = compare(reader.GetOutputDataObject(0), read(frame), f"{path}, step {step}")
        share = path.stat().st_size / size
        need(share <= 0.6, f"{path}: {share:.3f} of the bytes of the .vtu frames")
    except Fault as fault:
        print(f"check_vtkhdf: {fault}", file=sys.stderr)
        return 1
    print(f"{path.name}: {len(frames)} steps, {count} arrays, the same as the .vtu frames in {share:.3f} of their bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
