"""SciPy's solve_ivp with a vectorised right-hand side; nodal sums are a product with a sparse incidence matrix."""

import numpy as np
import scipy
from peer_common import Accelerations, Diverged, serve
from scipy.integrate import solve_ivp
from scipy.sparse import csr_array


def gather(elements, signs, nodes):
    """Sums at nodes by a sparse matrix of `signs`."""
    count, width = elements.shape
    data, columns = np.tile(signs, count), np.repeat(np.arange(count), width)
    incidence = csr_array((data, (elements.ravel(), columns)), shape=(nodes, count))
    return lambda force: incidence @ force


def run(scene, method, _kind, tolerance):
    if method not in ("DOP853", "RK45", "RK23"):
        raise ValueError("DOP853, RK45 or RK23")
    acceleration, n = Accelerations(scene, gather), scene.x0.size

    def rhs(_t, y):
        x, v = y[:n].reshape(-1, 3), y[n:].reshape(-1, 3)
        dy = np.empty_like(y)
        dy[:n] = y[n:]
        dy[n:] = acceleration(x, v).ravel()
        return dy

    times = scene.end * np.arange(1, scene.frames + 1) / scene.frames
    start = np.concatenate([scene.x0.ravel(), np.zeros(n)])
    with np.errstate(all="ignore"):
        solution = solve_ivp(
            rhs, (0.0, scene.end), start, method=method, t_eval=times, rtol=tolerance, atol=tolerance / 100
        )
    if not solution.success:
        raise Diverged(solution.message)
    return f"{solution.nfev} force passes", solution.y[:n].T.reshape(len(times), -1, 3)


if __name__ == "__main__":
    serve(f"SciPy {scipy.__version__}, numpy {np.__version__}", run)
