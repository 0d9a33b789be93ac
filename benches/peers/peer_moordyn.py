"""MoorDyn: nodes as points, every spring as a line of one segment, no water and no air.

Its lines carry no compression. It finds where a line hangs at the start; lines of one segment have nothing in between,
so that the scene starts where it is told to.
"""

import os
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import moordyn
import numpy as np
from peer_common import serve, steps_a_frame

SCHEMES = {"rk2": "RK2", "rk4": "RK4"}
TYPES = """
------- LINE TYPES -------
TypeName Diam Mass/m EA BA/-zeta EI Cd Ca CdAx CaAx
(name) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)"""
POINTS = """------- POINTS -------
ID Attachment X Y Z Mass Volume CdA Ca
(#) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)"""
LINES = """------- LINES -------
ID LineType AttachA AttachB UnstrLen NumSegs LineOutputs
(#) (name) (#) (#) (m) (-) (-)"""


def text(scene, scheme, step):
    """Its input file. Lines without mass or thickness are refused, so both are next to nothing."""
    if scene.damped or np.any(scene.load) or np.any(scene.gravity[:2]):
        raise ValueError("only springs and gravity along z are modelled")
    materials = {rigidity: f"t{i}" for i, rigidity in enumerate(dict.fromkeys((scene.k * scene.rest).tolist()))}
    rows = ["springs", TYPES, *(f"{name} 1e-9 1e-12 {ea!r} 0 0 0 0 0 0" for ea, name in materials.items()), POINTS]
    for i, (x, m, fixed) in enumerate(zip(scene.x0.tolist(), scene.mass.tolist(), scene.fixed, strict=True), start=1):
        rows.append(f"{i} {'Fixed' if fixed else 'Free'} {x[0]!r} {x[1]!r} {x[2]!r} {m!r} 0 0 0")
    rows.append(LINES)
    lines = zip(scene.ends.tolist(), (scene.k * scene.rest).tolist(), scene.rest.tolist(), strict=True)
    rows += [f"{i} {materials[ea]} {a + 1} {b + 1} {rest!r} 1 -" for i, ((a, b), ea, rest) in enumerate(lines, start=1)]
    options = [f"{step!r} dtM", f"{scheme} tScheme", f"{-scene.gravity[2]!s} g", "1000 WtrDpth"]
    nothing = [f"0 {name}" for name in ("writeLog", "rhoW", "rhoA", "kb", "cb", "WaveKin", "Currents")]
    return "\n".join([*rows, "------- OPTIONS -------", *options, *nothing, "------- OUTPUTS -------", "-------", ""])


def run(scene, method, _kind, step):
    if method not in SCHEMES:
        raise ValueError(" or ".join(SCHEMES))
    each = steps_a_frame(scene, step)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "lines.txt"
        file.write_text(text(scene, SCHEMES[method], scene.every / each), encoding="ascii")
        system = moordyn.Create(str(file))
        try:
            moordyn.SetVerbosity(system, moordyn.LEVEL_NONE)
            moordyn.Init_NoIC(system, [], [])
            points = [moordyn.GetPoint(system, i + 1) for i in range(len(scene.x0))]
            frames, before = [], time.process_time()
            for frame in range(scene.frames):
                moordyn.Step(system, [], [], frame * scene.every, scene.every)
                frames.append([moordyn.GetPointPos(point) for point in points])
            return f"{scene.frames * each} steps", frames, time.process_time() - before
        finally:
            moordyn.Close(system)


if __name__ == "__main__":
    # It talks to standard output from C++.
    sys.stdout = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    serve(f"MoorDyn {version('moordyn')}", run)
