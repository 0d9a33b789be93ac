"""Newton on its CPU device (Warp): springs between particles, its semi-implicit Euler, in single precision."""

import time

import newton
import numpy as np
import warp as wp
from peer_common import serve, steps_a_frame

wp.config.quiet = True


def build(scene):
    """The model; a particle without mass stays where it is."""
    length = np.linalg.norm(scene.x0[scene.ends[:, 1]] - scene.x0[scene.ends[:, 0]], axis=1)
    if scene.damped or np.any(scene.load) or np.any(np.abs(length - scene.rest) > 1e-12 * length):
        raise ValueError("only unstretched springs and their weight are modelled")
    builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=scene.gravity.tolist())
    for x, m, fixed in zip(scene.x0.tolist(), scene.mass.tolist(), scene.fixed, strict=True):
        builder.add_particle(pos=wp.vec3(*x), vel=wp.vec3(0.0, 0.0, 0.0), mass=0.0 if fixed else m, radius=0.0)
    for (a, b), k in zip(scene.ends.tolist(), scene.k.tolist(), strict=True):
        builder.add_spring(a, b, ke=k, kd=0.0, control=0.0)
    return builder.finalize(device="cpu")


def run(scene, method, _kind, step):
    if method != "semi-implicit":
        raise ValueError("semi-implicit")
    each = steps_a_frame(scene, step)
    model = build(scene)
    solver, now, then, control = newton.solvers.SolverSemiImplicit(model), model.state(), model.state(), model.control()
    solver.step(model.state(), model.state(), control, None, scene.every / each)  # compiles
    frames, before = [], time.process_time()
    for _ in range(scene.frames):
        for _ in range(each):
            now.clear_forces()
            solver.step(now, then, control, None, scene.every / each)
            now, then = then, now
        frames.append(now.particle_q.numpy().astype(float))
    return f"{scene.frames * each} steps", frames, time.process_time() - before


if __name__ == "__main__":
    serve(f"Newton {newton.__version__}, Warp {wp.__version__}", run)
