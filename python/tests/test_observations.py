"""What is seen of a simulation on the way: accelerations, gauges, and their peaks."""

import pickle

import numpy as np
import pytest
from conftest import cloth

import canopy_fem as cf

GAUGES = [
    {"name": "corner", "on": {"ids": [48]}, "of": "acceleration", "every": 1},
    {"name": "held", "on": {"box": [[-1, -0.01, -1], [2, 0.01, 1]]}, "of": "reaction", "every": 1},
    {"name": "cloth", "on": "all", "of": "tension", "every": 1},
]


@pytest.fixture
def gauged():
    """The cloth with gauges, which loses 1 N on its corner from the start."""
    case = cloth(output={"gauges": GAUGES})
    case["system"]["network"]["loads"] = [{"on": {"ids": [48]}, "force": [0, 0, 1.0]}]
    return case


def test_accelerations_are_those_of_a_fall(small):
    """Free fall: every node that is not held begins with g. A force from outside acts at once, by its mass."""
    small["system"]["network"]["springs"][0]["dashpot"] = {"relative": {"time": 0.002}}
    sim = cf.Simulation(small)
    held = np.flatnonzero(sim.positions[:, 1] == 0)
    free = np.setdiff1d(np.arange(sim.node_count), held)
    a = sim.accelerations
    np.testing.assert_allclose(a[free], np.tile([0, 0, -9.81], (len(free), 1)), rtol=1e-12)
    assert (a[held] == 0).all() and not a.flags.writeable
    force = np.zeros((49, 3))
    force[24, 0] = 2.0
    sim.forces["push"] = force
    mass = 0.5 / 36
    np.testing.assert_allclose(sim.accelerations[24], [2.0 / mass, 0, -9.81], rtol=1e-12)
    assert (sim.accelerations[25] == a[25]).all()


def test_gauges_show_what_the_files_hold(gauged, tmp_path):
    """Every step: values and peaks are those of the rows and of the summary that `run` writes."""
    result = cf.run(gauged, tmp_path / "run")
    sim = cf.Simulation(gauged)
    rows = result.gauges
    for step in range(200):
        now = rows[np.isclose(rows["t"], step * 1e-3, rtol=0, atol=1e-9)]
        assert sim.gauges == {f"{row['name']} {row['quantity']}": row["value"] for row in now}
        sim.step()
    assert sim.gauge_units["corner acceleration_max"] == "m/s^2"
    assert sim.peaks == result.peaks
    many = cf.Simulation(gauged)
    many.run()
    assert many.peaks == result.peaks and many.positions.tobytes() == sim.positions.tobytes()


def test_gauges_see_what_was_set(gauged):
    """A force that was set shows in the gauges at once, before any step."""
    sim = cf.Simulation(gauged)
    before = sim.gauges
    force = np.zeros((49, 3))
    force[0] = [3.0, 0, 0]
    sim.forces["push"] = force
    after = sim.gauges
    assert after["held reaction_x"] == pytest.approx(before["held reaction_x"] - 3.0)
    assert after["corner acceleration_z"] == before["corner acceleration_z"]


def test_peaks_are_part_of_snapshots(gauged):
    """A simulation that is restored, or copied, has the peaks of that state; one that is set begins them anew."""
    sim = cf.Simulation(gauged)
    sim.step(50)
    state, peaks = sim.snapshot(), sim.peaks
    sim.run()
    last = sim.peaks
    assert last != peaks
    sim.restore(state)
    assert sim.peaks == peaks
    other = pickle.loads(pickle.dumps(sim))
    other.run()
    assert other.peaks == last
    sim.set_state(sim.reference, np.zeros((49, 3)))
    assert sim.peaks["cloth tension_max"] == sim.gauges["cloth tension_max"] == 0.0


def test_attempted_steps_count_once_accepted(gauged):
    sim, plain = cf.Simulation(gauged), cf.Simulation(gauged)
    for _ in range(20):
        sim.attempt()
        sim.drop()
        sim.attempt()
        sim.accept()
    plain.step(20)
    assert sim.peaks == plain.peaks


def test_a_network_has_no_gauges():
    net = cf.Network([[0, 0, 0], [1.5, 0, 0]], mass=2).springs([[0, 1]], stiffness=8, rest_length=1).hold([0])
    sim = cf.Simulation(net, method="rk4", step=1e-3, end=10)
    assert sim.gauges == {} and sim.peaks == {}
    np.testing.assert_allclose(sim.accelerations, [[0, 0, 0], [-2.0, 0, 0]])


def test_numbers_are_those_of_numpy(sim):
    """Numbers of nodes, edges and triangles are int64: they may be subtracted, and index without a copy."""
    mesh = cf.mesh.rectangle(width=1.0, height=1.0, columns=2, rows=2)
    for numbers in (sim.edges, sim.triangles, sim.select("boundary"), mesh.edges, mesh.triangles, mesh.seams):
        assert numbers.dtype == np.int64
