"""OpenSees through OpenSeesPy: springs as corotational trusses with EA/L = k, lumped masses, nodal weights.

`newmark`: Newmark 1/2, 1/4 with Newton's iteration, to the same residual as ours (1e-8 of the weight).
`central-difference`: its fastest explicit integrator with a diagonal system. Both start wrongly unless told: Newmark
from zero acceleration, the central differences half a step of velocity late, which leaves order 1. The nodes are given
what makes both right.
"""

import os
import sys
import time

import numpy as np
import openseespy.opensees as ops
from peer_common import Diverged, serve, steps_a_frame

# The fastest of its symmetric and general sparse solvers on these nets, measured by --solvers.
SYSTEM = ("SparseSYM",)


def build(scene, method, step):
    """The model with the acceleration or the velocity it starts with."""
    length = np.linalg.norm(scene.x0[scene.ends[:, 1]] - scene.x0[scene.ends[:, 0]], axis=1)
    if scene.damped or np.any(np.abs(length - scene.rest) > 1e-12 * length):
        raise ValueError("only unstretched springs without dashpots and air are modelled")
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 3)
    for i, (x, m, fixed) in enumerate(zip(scene.x0.tolist(), scene.mass.tolist(), scene.fixed, strict=True), start=1):
        ops.node(i, *x)
        if fixed:
            ops.fix(i, 1, 1, 1)
        else:
            ops.mass(i, m, m, m)
    for e, ((a, b), k, l0) in enumerate(
        zip(scene.ends.tolist(), scene.k.tolist(), scene.rest.tolist(), strict=True), start=1
    ):
        ops.uniaxialMaterial("Elastic", e, k * l0)
        ops.element("corotTruss", e, a + 1, b + 1, 1.0, e)
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    for i in np.flatnonzero(~scene.fixed).tolist():
        ops.load(i + 1, *scene.constant[i].tolist())
        # At rest and unstretched nothing else accelerates.
        for axis, g in enumerate((scene.constant[i] / scene.mass[i]).tolist(), start=1):
            if method == "newmark":
                ops.setNodeAccel(i + 1, axis, g, "-commit")
            else:
                ops.setNodeVel(i + 1, axis, -0.5 * step * g, "-commit")


def analysis(scene, method):
    ops.constraints("Plain")
    if method == "newmark":
        weight = np.linalg.norm(scene.constant[~scene.fixed])
        ops.numberer("RCM")
        ops.system(*SYSTEM)
        ops.test("NormUnbalance", 1e-8 * weight, 50, 0)
        ops.algorithm("Newton")
        ops.integrator("Newmark", 0.5, 0.25)
    elif method == "central-difference":
        ops.numberer("Plain")
        ops.system("Diagonal")
        ops.algorithm("Linear")
        ops.integrator("CentralDifferenceNoDamping")
    else:
        raise ValueError("newmark or central-difference")
    ops.analysis("Transient")


def run(scene, method, _kind, step):
    each = steps_a_frame(scene, step)
    build(scene, method, scene.every / each)
    frames, nodes = [], range(1, len(scene.x0) + 1)
    before = time.process_time()
    analysis(scene, method)
    for frame in range(1, scene.frames + 1):
        if ops.analyze(each, scene.every / each) != 0:
            raise Diverged(f"analyze() failed before t = {scene.every * frame:g} s")
        frames.append(scene.x0 + np.array([ops.nodeDisp(i) for i in nodes]))
    return f"{each * scene.frames} steps", frames, time.process_time() - before


def silenced(scene, *job):
    """OpenSees talks to standard error from C++ when Newton fails."""
    keep, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 2)
    try:
        return run(scene, *job)
    finally:
        os.dup2(keep, 2)
        os.close(keep)
        os.close(nothing)


if __name__ == "__main__":
    if "--solvers" in sys.argv:
        from peer_common import read_scene

        for SYSTEM in (("SparseSYM",), ("Umfpack",), ("ProfileSPD",), ("BandSPD",), ("SuperLU",)):
            print(*SYSTEM, *run(read_scene(sys.argv[1]), "newmark", "step", 0.01)[::2])
    else:
        serve(f"OpenSeesPy, OpenSees {ops.version()}", silenced)
