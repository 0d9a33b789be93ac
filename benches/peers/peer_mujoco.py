"""MuJoCo: nodes as bodies on three slides, springs as a flex of dimension 1, membranes as one of dimension 2 that only
stretches.

`euler`: its semi-implicit Euler (v, then x with the new v), of order 1. `rk4`. Its dashpots act along edges, not ours.
"""

import time

import mujoco
import numpy as np
from peer_common import serve, steps_a_frame

INTEGRATORS = {"euler": "Euler", "rk4": "RK4"}
OFF = " ".join(f'{part}="disable"' for part in ("contact", "constraint", "eulerdamp", "sensor", "actuation"))


def flexes(scene):
    """One flex a material: dimension, elements, what it is made of."""
    length = np.linalg.norm(scene.x0[scene.ends[:, 1]] - scene.x0[scene.ends[:, 0]], axis=1)
    if scene.damped or np.any(np.abs(length - scene.rest) > 1e-12 * length):
        raise ValueError("only unstretched springs without dashpots and air are modelled")
    for k in np.unique(scene.k).tolist():
        yield 1, scene.ends[scene.k == k], f'<edge stiffness="{k!r}"/>'
    for thickness, modulus, poisson, wrinkles in np.unique(scene.membranes[:, 3:], axis=0).tolist():
        if wrinkles:
            raise ValueError("its membranes do not wrinkle")
        of_it = np.all(scene.membranes[:, 3:] == [thickness, modulus, poisson, wrinkles], axis=1)
        elasticity = f'young="{modulus!r}" poisson="{poisson!r}" thickness="{thickness!r}" elastic2d="stretch"'
        yield 2, scene.membranes[of_it, :3].astype(int), f"<elasticity {elasticity}/>"


def model(scene, integrator, step):
    """Its model, from XML with all digits."""

    def vector(x):
        return " ".join(map(repr, x))

    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    bodies = []
    for i, (x, m, fixed) in enumerate(zip(scene.x0.tolist(), scene.mass.tolist(), scene.fixed, strict=True)):
        inside = "" if fixed else f'<inertial pos="0 0 0" mass="{m!r}" diaginertia="1 1 1"/>{slides}'
        bodies.append(f'<body name="{i}" pos="{vector(x)}">{inside}</body>')
    named, at = vector(range(len(bodies))), " ".join(["0"] * 3 * len(bodies))
    flexible = []
    for number, (dimension, elements, made_of) in enumerate(flexes(scene)):
        corners = vector(elements.ravel().tolist())
        head = f'<flex name="f{number}" dim="{dimension}" body="{named}" vertex="{at}" element="{corners}">'
        flexible.append(f'{head}<contact contype="0" conaffinity="0"/>{made_of}</flex>')
    gravity = vector(scene.gravity.tolist())
    option = f'<option timestep="{step!r}" integrator="{integrator}" gravity="{gravity}"><flag {OFF}/></option>'
    parts = [
        "<mujoco>",
        option,
        "<worldbody>",
        *bodies,
        "</worldbody><deformable>",
        *flexible,
        "</deformable></mujoco>",
    ]
    return mujoco.MjModel.from_xml_string("".join(parts))


def run(scene, method, _kind, step):
    if method not in INTEGRATORS:
        raise ValueError(" or ".join(INTEGRATORS))
    each = steps_a_frame(scene, step)
    made = model(scene, INTEGRATORS[method], scene.every / each)
    data = mujoco.MjData(made)
    free = ~scene.fixed
    data.qfrc_applied[:] = scene.load[free].ravel()
    frames, before = [], time.process_time()
    for _ in range(scene.frames):
        mujoco.mj_step(made, data, each)
        x = scene.x0.copy()
        x[free] += data.qpos.reshape(-1, 3)
        frames.append(x)
    return f"{scene.frames * each} steps", frames, time.process_time() - before


if __name__ == "__main__":
    serve(f"MuJoCo {mujoco.__version__}", run)
