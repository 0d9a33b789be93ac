#!/usr/bin/env python3
"""Reads the .usda that canopy-fem exports with USD (pip install usd-core vtk), and compares it with the frames of the run.

    check_animation.py FOLDER DIR    FOLDER holds canopy.usda; DIR holds NAME.pvd and frames/

Writes FOLDER/expected.json for check_animation_py311.py: times and positions of all frames. Exit status 1 on any fault.
"""

import json
import pathlib
import sys

import numpy as np
from check_vtu import LINE, TRIANGLE, Fault, frames_of, need, read
from pxr import Usd, UsdGeom
from vtkmodules.util.numpy_support import vtk_to_numpy


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    folder, run = map(pathlib.Path, sys.argv[1:])
    try:
        (pvd,) = run.glob("*.pvd")
        times, paths = frames_of(pvd)
        grids = [read(path) for path in paths]
        frames = [vtk_to_numpy(grid.GetPoints().GetData()) for grid in grids]
        kinds = [grids[0].GetCellType(i) for i in range(grids[0].GetNumberOfCells())]
        parts = vtk_to_numpy(grids[0].GetCellData().GetArray("kind"))
        lines = [i for i, kind in enumerate(kinds) if kind == LINE and parts[i] == 2]

        stage = Usd.Stage.Open(str(folder / "canopy.usda"))
        need(UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1, "usda: not +Z up in metres")
        rate = stage.GetTimeCodesPerSecond()
        prims = {prim.GetName(): prim for prim in stage.Traverse()}
        cloth, curves = UsdGeom.Mesh(prims["cloth"]), UsdGeom.BasisCurves(prims["lines"])
        need(list(cloth.GetFaceVertexCountsAttr().Get()) == [3] * kinds.count(TRIANGLE), "usda: other triangles")
        need(list(curves.GetCurveVertexCountsAttr().Get()) == [2] * len(lines), "usda: other lines")
        samples = cloth.GetPointsAttr().GetTimeSamples()
        need(np.allclose(np.array(samples) / rate, times, rtol=0, atol=1e-9), "usda: other times")
        ends = [[grids[0].GetCell(i).GetPointId(j) for j in (0, 1)] for i in lines]
        for t, frame in zip(samples, frames):
            scale = np.abs(frame).max()
            need(np.abs(np.array(cloth.GetPointsAttr().Get(t)) - frame).max() <= 1e-6 * scale, f"usda: other points at {t}")
            found = np.array(curves.GetPointsAttr().Get(t)).reshape(-1, 2, 3)
            need(np.abs(found - frame[ends]).max() <= 1e-6 * scale, f"usda: other lines at {t}")
            need(UsdGeom.Boundable(prims["cloth"]).GetExtentAttr().Get(t) is not None, f"usda: no extent at {t}")
        need(stage.GetEndTimeCode() == samples[-1], "usda: ends at another time")
    except Fault as fault:
        print(f"check_animation: {fault}", file=sys.stderr)
        return 1
    expected = {"times": times, "frames": [frame.tolist() for frame in frames], "triangles": kinds.count(TRIANGLE)}
    (folder / "expected.json").write_text(json.dumps(expected))
    print(f"animation: USD reads .usda, {len(times)} frames, {len(frames[0])} points, {len(lines)} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
