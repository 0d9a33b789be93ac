"""Finds stiffness and damping of a cloth from the measured motion of its corner: scipy.optimize over rollouts.

The measurement is made here by a run with known values. Each step of the optimisation needs the motion at one point and
its differences in two directions: three runs at once.
"""

import numpy as np
from scipy.optimize import least_squares

import canopy_fem as cf

CORNER = 48
base = cf.Case(
    {
        "name": "hanging-cloth",
        "acknowledge": ["areal-density"],
        "system": {
            "network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 6, "rows": 6}},
                "mass": {"areal_density": 0.5},
                "springs": [{"on": "all", "stiffness": 300.0, "dashpot": {"relative": {"time": 0.002}}}],
                "supports": [{"on": {"box": [[-1, -0.01, -1], [2, 0.01, 1]]}, "fix": "xyz"}],
                "gravity": [0, 0, -9.81],
            }
        },
        "time": {"end": 0.5, "method": "velocity-verlet", "step": 1e-3},
    }
)


def motions(points):
    """The corner's path for each pair of log stiffness [N/m] and log retardation time [s], (k, 3 n)."""
    rule = "system.network.springs.0"
    cases = [
        base.with_overrides({f"{rule}.stiffness": np.exp(k), f"{rule}.dashpot": {"relative": {"time": np.exp(tau)}}})
        for k, tau in points
    ]
    return np.array([run.positions[:, 0].ravel() for run in cf.rollout(cases, nodes=[CORNER], every=0.01)])


def jacobian(point):
    """Central differences."""
    h = 1e-4
    shifted = [point + h * sign * axis for axis in np.eye(2) for sign in (1, -1)]
    ahead_x, behind_x, ahead_y, behind_y = motions(shifted)
    return np.column_stack([ahead_x - behind_x, ahead_y - behind_y]) / (2 * h)


true = np.log([417.0, 0.0031])
measured = motions([true])[0]
found = least_squares(lambda point: motions([point])[0] - measured, np.log([300.0, 0.002]), jacobian)
stiffness, tau = np.exp(found.x)
print(f"stiffness {stiffness:.2f} N/m (417), retardation time {1000 * tau:.4f} ms (3.1), after {found.nfev} points")
assert abs(stiffness - 417) < 0.01 and abs(tau - 0.0031) < 1e-6
