"""A vectorised numpy loop with fixed steps, as a thesis would write it: explicit Euler and velocity Verlet."""

import numpy as np
from peer_common import Accelerations, serve, steps_a_frame


def gather(elements, signs, nodes):
    """Sums at nodes by bincount, component by component: the whole pass takes half of what it does with np.add.at."""
    index = elements.T.ravel()

    def at_nodes(force):
        per_end = [np.concatenate([s * force[:, d] for s in signs]) for d in range(3)]
        return np.stack([np.bincount(index, weights=w, minlength=nodes) for w in per_end], axis=1)

    return at_nodes


def run(scene, method, _kind, step):
    each = steps_a_frame(scene, step)
    h, acceleration = scene.every / each, Accelerations(scene, gather)
    x, v, frames = scene.x0.copy(), np.zeros_like(scene.x0), []
    with np.errstate(all="ignore"):
        a = acceleration(x, v)
        for n in range(1, scene.frames * each + 1):
            if method == "explicit-euler":
                x, v = x + h * v, v + h * a
                a = acceleration(x, v)
            elif method == "velocity-verlet":
                half = v + 0.5 * h * a
                x = x + h * half
                # Forces that depend on the velocity are taken at the predicted one.
                a = acceleration(x, half + 0.5 * h * a)
                v = half + 0.5 * h * a
            else:
                raise ValueError("explicit-euler or velocity-verlet")
            if n % each == 0:
                frames.append(x.copy())
    return f"{scene.frames * each} steps", frames


if __name__ == "__main__":
    serve(f"numpy {np.__version__}", run)
