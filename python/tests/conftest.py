"""What the tests share: cases, and a small cloth."""

from __future__ import annotations

from pathlib import Path

import pytest

import canopy_fem as cf

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "assets" / "cases"


def cloth(**changes):
    """A square of cloth that hangs from one side in the wind."""
    case = {
        "name": "square",
        "acknowledge": ["areal-density"],
        "system": {
            "network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 6, "rows": 6}},
                "mass": {"areal_density": 0.5},
                "springs": [{"on": "all", "stiffness": 200.0, "dashpot": {"relative": {"time": 0.002}}}],
                "supports": [{"on": {"box": [[-1, -0.01, -1], [2, 0.01, 1]]}, "fix": "xyz"}],
                "gravity": [0, 0, -9.81],
            }
        },
        "time": {"end": 0.2, "method": "velocity-verlet", "step": 1e-3},
        "output": {"frames": {"every": 0.05}, "probes": [{"name": "corner", "on": {"ids": [48]}}]},
    }
    case.update(changes)
    return case


@pytest.fixture
def small():
    return cloth()


@pytest.fixture
def sim(small):
    return cf.Simulation(small)
