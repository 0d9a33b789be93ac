"""Derivatives: of a simulation's state by numbers of its case, and of quantities by each spring and node."""

import copy
from typing import Any

import numpy as np
import pytest

import canopy_fem as cf

KEY = "system.network.springs.0.stiffness"
CASE: dict[str, Any] = {
    "name": "net",
    "system": {
        "network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 0.8, "columns": 4, "rows": 3, "pattern": "regular"}},
            "mass": {"areal_density": 0.3},
            "springs": [{"on": "all", "stiffness": 300.0, "rest_length": 0.2}],
            "supports": [{"on": "boundary", "fix": "xyz"}],
            "gravity": [0, 0, -9.81],
        }
    },
    "time": {"end": 0.2, "method": "newmark", "step": 0.002},
    "solver": {"newton": {"relative": 1e-12}},
    "output": {
        "probes": [{"name": "middle", "on": {"ids": [6]}}],
        "gauges": [{"name": "all", "on": "all", "of": "tension"}],
    },
}


@pytest.mark.parametrize("method", ["newmark", "rk4", "hht"])
def test_the_state_has_the_derivatives_of_differences(method: str) -> None:
    case = cf.Case(CASE, {"time.method": method})
    sim = cf.Simulation(case, sensitivity="stiffness")
    sim.step(37)
    sim.run_until(0.15)
    assert list(sim.sensitivity) == [KEY]
    ends = []
    for stiffness in (300.0 * (1 - 1e-4), 300.0 * (1 + 1e-4)):
        other = cf.Simulation(case.with_overrides({KEY: stiffness}))
        other.run_until(0.15)
        ends.append((other.positions, other.velocities))
    for found, below, above in zip(sim.sensitivity[KEY], *ends, strict=True):
        expected = (above - below) / (2 * 300.0 * 1e-4)
        assert found.shape == (sim.positions.shape) and np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_a_followed_simulation_has_the_bits_of_any_other() -> None:
    plain, followed = cf.Simulation(CASE), cf.Simulation(CASE, sensitivity=["stiffness", "gravity.2"])
    plain.step(50)
    followed.step(50)
    assert np.array_equal(plain.positions, followed.positions) and plain.peaks == followed.peaks
    assert len(followed.sensitivity) == 2 and plain.sensitivity == {}


def test_what_has_no_derivative_says_so() -> None:
    with pytest.raises(cf.CaseError, match="the case has no number there"):
        cf.Simulation(CASE, sensitivity="stiffnes")
    with pytest.raises(cf.CaseError, match="by kang is not known"):
        cf.Simulation(cf.Case(CASE, {"time.method": "kang"}), sensitivity="stiffness")
    with pytest.raises(cf.CaseError, match="steps of one size"):
        adaptive = {"time.step": None, "time.method": "dop853", "time.tolerance": {"relative": 1e-6, "absolute": 1e-8}}
        cf.Simulation(cf.Case(CASE, adaptive), sensitivity="stiffness")
    sim = cf.Simulation(CASE, sensitivity="stiffness")
    assert copy.deepcopy(sim).sensitivity == {}
    sim.step(3)
    sim.set_load_factor("gravity", 0.5)
    with pytest.raises(cf.SimulationError, match="has no derivative by numbers of the case"):
        sim.step()
    with pytest.raises(TypeError, match="a network has no keys"):
        cf.Simulation(cf.Network([[0, 0, 0]], mass=1.0), method="rk4", step=0.1, end=1.0, sensitivity="stiffness")


def test_each_spring_and_node_has_a_derivative() -> None:
    by = ["each.stiffness", "each.mass", "each.position", "stiffness"]
    quantities = ["all.tension_max.peak", "middle.z.last"]
    found = cf.gradient(CASE, of=quantities, by=by)
    again = cf.gradient(CASE, of=quantities, by=by, states=10)
    mesh = cf.Simulation(CASE)
    for quantity, slopes in found.items():
        assert slopes["each.stiffness"].shape == (len(mesh.edges),)
        assert slopes["each.mass"].shape == (len(mesh.positions),)
        assert slopes["each.position"].shape == mesh.positions.shape
        assert np.nansum(slopes["each.stiffness"]) == pytest.approx(slopes[KEY], rel=1e-7)
        for name in by[:3]:
            assert np.allclose(slopes[name], again[quantity][name], rtol=1e-8, atol=1e-10, equal_nan=True)


def test_derivatives_end_where_they_are_not_known() -> None:
    """After the error there are none, rather than wrong ones."""
    sim = cf.Simulation(CASE, sensitivity="stiffness")
    sim.step(3)
    sim.set_load_factor("gravity", 0.5)
    with pytest.raises(cf.SimulationError, match="derivatives of the state"):
        sim.step()
    assert sim.sensitivity == {}
    assert sim.step().time > 0.006
