"""What users see of names: errors that list those that are there, and objects in one line."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest
from conftest import cloth

import canopy_fem as cf

GAUGES = [{"name": "cloth", "on": "all", "of": "tension", "every": 1}]


@pytest.fixture
def sim():
    sim = cf.Simulation(cloth(output={"gauges": GAUGES}))
    sim.forces["wake"] = np.zeros((49, 3))
    return sim


def test_a_name_that_is_not_there_lists_those_that_are(sim):
    """Every mapping and method that takes a name raises a KeyError with the names that it has."""
    case = cf.Case(cloth(output={"gauges": GAUGES}))
    result, batch = cf.run(case, files=False), cf.rollout(case, times=[0.0, 0.01])
    column, gauge = "cloth tension_max", "cloth"
    for ask, known in (
        (lambda: sim.gauges["riser"], column),
        (lambda: sim.gauge_units["riser"], column),
        (lambda: sim.peaks["riser"], column),
        (lambda: sim.forces["riser"], "wake"),
        (lambda: sim.forces.pop("riser"), "wake"),
        (lambda: sim.loads["riser"], "gravity"),
        (lambda: sim.loads.__setitem__("riser", 1.0), "gravity"),
        (lambda: result.peaks["riser"], column),
        (lambda: result.quantities["riser"], "tension"),
        (lambda: result.gauge("riser"), gauge),
        (lambda: batch.gauge("riser"), gauge),
        (lambda: batch.gauge("cloth", "riser"), "tension_max"),
        (lambda: batch.energy("riser"), "kinetic"),
        (lambda: sim.select("riser"), "groups here"),
        (lambda: sim.rest_scale["riser"], "groups here"),
    ):
        with pytest.raises(KeyError, match=known):
            ask()
    assert sim.forces.get("riser") is None and sim.gauges.get("riser", 1.0) == 1.0


def test_named_values_are_dictionaries_that_can_be_copied(sim):
    for again in (copy.copy(sim.gauges), copy.deepcopy(sim.gauges), pickle.loads(pickle.dumps(sim.gauges))):
        assert again == sim.gauges == dict(sim.gauges)
        with pytest.raises(KeyError, match="cloth tension_max"):
            again["riser"]


def test_every_public_object_shows_itself_in_one_line(sim):
    """An instance of every class of `__all__`, and every other name of it."""
    case = cf.Case(cloth())
    mesh = cf.mesh.rectangle(width=1.0, height=1.0, columns=2, rows=2)
    made = {
        "Batch": cf.rollout(case, times=[0.0, 0.01]),
        "Case": case,
        "Energies": sim.energies,
        "Fault": cf.Fault("/time/step", "-1", "above 0"),
        "Fit": cf.Fit({"k": 1.0}, {"k": 0.1}, {"k": (0.8, 1.2)}, np.eye(1), np.zeros(0), [], case, {}),
        "Motion": sim.attempt(),
        "Network": cf.Network(mesh, mass=1.0),
        "Result": cf.run(case, files=False),
        "Rollout": cf.rollout([case])[0],
        "Sample": cf.Sample([{"run": 1}], {"quantities": []}),
        "Simulation": sim,
        "Step": cf.Step(1, 0.1, sim.energies),
    }
    # Of another part of the module, which may have more.
    for name in cf.__all__:
        value = getattr(cf, name)
        if isinstance(value, type) and issubclass(value, BaseException):
            value = value("what is wrong")
        elif isinstance(value, type):
            assert name in made, f"this test needs one {name}"
            value = made[name]
        text = repr(value)
        assert text and "\n" not in text and len(text) < 300, (name, text)
        assert " object at 0x" not in text, (name, text)
    for value in (mesh, sim.forces, sim.loads, sim.rest_scale, made["Result"].quantities):
        assert "\n" not in repr(value) and " object at 0x" not in repr(value), repr(value)


@pytest.mark.parametrize("module", ["batch", "fitting", "mesh", "results", "runs", "simulation", "studies"])
def test_any_module_can_be_imported_first(module):
    """As a process does that unpickles one of its functions."""
    subprocess.run([sys.executable, "-c", f"import canopy_fem.{module}"], check=True, timeout=60)
