"""Copies, pickles, and what comes from other processes."""

import copy
import gc
import multiprocessing
import pickle
import subprocess
import sys
import weakref
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from conftest import CASES, cloth

import canopy_fem as cf
from canopy_fem import errors

WAYS = [lambda it: pickle.loads(pickle.dumps(it)), copy.copy, copy.deepcopy]
ways = pytest.mark.parametrize("way", WAYS, ids=["pickle", "copy", "deepcopy"])

RAISED = [
    cf.CaseError("two", [{"pointer": "/a", "value": "1", "allowed": "0"}]),
    cf.Diverged("it has", {"time": 1.5, "cause": "a step"}),
    cf.Ended("it has"),
    errors.CouplingError("forces"),
    errors.CouplingLost("gone"),
    errors.FlowDiverged(1.0, 2.0, 3.0),
    errors.KratosMissing(["KratosMultiphysics"]),
    errors.NotCoupled(1.0, 20, 0.1, 0.01),
    errors.SurfaceOutside(3, [0.0] * 3, [1.0] * 3, [2.0] * 3),
    cf.InternalError("a defect"),
]


def raises(number):
    raise RAISED[number]


def runs(end):
    return cf.run(cf.Case(CASES / "cloth-k1000.json", {"time.end": end}))


def moves(sim):
    sim.step(10)
    return sim


@ways
@pytest.mark.parametrize("error", RAISED, ids=lambda error: type(error).__name__)
def test_exceptions(error, way):
    again = way(error)
    assert type(again) is type(error) and str(again) == str(error) and again.args == error.args
    assert again.__dict__ == error.__dict__


def test_pools_get_exceptions():
    """Of every kind, from both kinds of pools, which then still work."""
    context = multiprocessing.get_context("spawn")
    with context.Pool(1) as pool, ProcessPoolExecutor(1, mp_context=context) as other:
        for number, error in enumerate(RAISED):
            with pytest.raises(type(error)) as caught:
                pool.apply_async(raises, (number,)).get(timeout=120)
            assert str(caught.value) == str(error)
            with pytest.raises(type(error)):
                other.submit(raises, number).result(timeout=120)


def test_pools_get_results_and_simulations():
    """A result takes the files of its temporary folder along; a simulation comes back where it was brought to."""
    context = multiprocessing.get_context("spawn")
    sim, stayed = cf.Simulation(cloth()), cf.Simulation(cloth())
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        short, longer = pool.map(runs, [0.01, 0.02])
        assert short.history["t"][-1] == 0.01 and longer.history["t"][-1] == 0.02
        assert short.frame().is_file() and short.folder != longer.folder
        again = pool.submit(moves, sim).result(timeout=120)
    assert moves(stayed).positions.tobytes() == again.positions.tobytes() and sim.step_count == 0


@ways
def test_cases(way, tmp_path, monkeypatch):
    """A case keeps its content, the files that it names, and its overrides, wherever the program is by then."""
    mesh = tmp_path / "sheet.vtu"
    cf.mesh.rectangle(width=1, height=1, columns=6, rows=6).write(mesh)
    raw = cloth()
    raw["system"]["network"]["mesh"] = {"file": "sheet.vtu"}
    case = cf.Case(raw, {"time.end": 0.1}, base=tmp_path)
    at_rest = cf.Case({key: value for key, value in cloth().items() if key != "time"}, at_rest=True)
    monkeypatch.chdir(tmp_path.parent)
    again = way(case)
    assert again.to_dict() == case.to_dict() and again == case and hash(again) == hash(case)
    assert again.with_overrides({"time.end": 0.2}).end == 0.2
    assert cf.rollout([again])[0].status == "completed"
    assert way(at_rest) == at_rest


def test_cases_are_equal_by_content(tmp_path):
    """However they were written; other values, or other content of a file, are another case."""
    file = cf.Case(CASES / "cloth-k1000.json")
    assert file == cf.Case(file.to_dict()) and len({file, cf.Case(file.to_dict())}) == 1
    assert file != file.with_overrides({"time.end": 1.0}) and file != file.with_overrides({"output": None})
    assert file != file.to_dict() and cf.Case(cloth()) == cf.Case(cloth(), {"time.step": 0.001})
    raw = cloth()
    raw["system"]["network"]["mesh"] = {"file": "sheet.vtu"}
    made = []
    for columns in (6, 7):
        cf.mesh.rectangle(width=1, height=1, columns=columns, rows=6).write(tmp_path / "sheet.vtu", replace=True)
        made.append(cf.Case(raw, {"output.probes": None}, base=tmp_path))
    assert made[0].to_dict() == made[1].to_dict() and made[0] != made[1]


@ways
def test_meshes_and_networks(way):
    mesh = cf.mesh.annulus(inner_radius=0.2, outer_radius=1, nodes=100, boundary_nodes=40, seams=4)
    again = way(mesh)
    for name in ("nodes", "edges", "triangles", "seams"):
        np.testing.assert_array_equal(getattr(again, name), getattr(mesh, name))
    mass = np.full(len(mesh.nodes), 0.01)
    net = cf.Network(mesh, mass=mass, gravity=[0, 0, -9.81])
    net.springs(stiffness=np.full(len(mesh.edges), 500.0), dashpot=0.1)
    net.hold([0, 1])
    net.force([5], [0, 0, 0.1])
    net.initial(velocity=np.outer(np.arange(len(mesh.nodes)) > 1, [0.1, 0.0, 0.0]))
    # What was given may change afterwards.
    mass[:] = 1.0
    sims = [cf.Simulation(made, method="rk4", step=1e-4, end=1.0) for made in (net, way(net))]
    assert sims[0].run_until(0.01).energies.as_dict() == sims[1].run_until(0.01).energies.as_dict()


@ways
@pytest.mark.parametrize("attribute", ["case", "network"])
def test_simulations(way, attribute):
    """A copy is another simulation that goes on with the same bits, with all that was set."""
    if attribute == "case":
        sim = cf.Simulation(cloth(time={"end": 0.2, "method": "hht", "step": 1e-3}))
    else:
        net = cf.Network(cf.mesh.rectangle(width=1, height=1, columns=6, rows=6), mass=0.01, gravity=[0, 0, -9.81])
        net.springs(stiffness=500.0)
        net.hold([0, 1])
        sim = cf.Simulation(net, method={"hht": {"alpha": -0.1}}, step=1e-3, end=1.0)
        # No part of the simulation.
        net.hold([2])
    sim.forces["lift"] = np.full((49, 3), 0.01)
    sim.forces.add("drag", drag)
    sim.rest_scale[[3]] = 0.9
    sim.step(20)
    again = way(sim)
    assert again is not sim and again.step_count == 20 and list(again.forces) == ["lift", "drag"]
    for one in (sim, again):
        one.step(20)
    assert again.positions.tobytes() == sim.positions.tobytes()
    assert again.velocities.tobytes() == sim.velocities.tobytes()
    sim.attempt()
    with pytest.raises(cf.SimulationError, match="neither accepted nor dropped"):
        way(sim)


def drag(t, x, v):
    return -0.01 * v


@ways
def test_rollouts_and_small_values(way):
    run = cf.rollout([cloth()], every=0.1)[0]
    again = way(run)
    for name in ("t", "positions", "velocities"):
        np.testing.assert_array_equal(getattr(again, name), getattr(run, name))
    assert again.energies.as_dict() == run.energies.as_dict() and repr(again) == repr(run)
    step = cf.Simulation(cloth()).step()
    assert repr(way(step)) == repr(step) and way(step).energies.as_dict() == step.energies.as_dict()
    failed = cf.rollout([cloth(time={"end": 10.0, "method": "velocity-verlet", "step": 0.05})])[0]
    assert way(failed).failure == failed.failure is not None


@ways
def test_results(way, tmp_path):
    """One in a temporary folder has its files as long as the result or a copy lives; one elsewhere knows where."""
    result = cf.run(cloth())
    again = way(result)
    table = result.history
    folder = result.folder
    del result
    gc.collect()
    np.testing.assert_array_equal(again.history, table)
    assert again.frame(0.1).is_file()
    folders = {folder, again.folder}
    del again
    gc.collect()
    assert not any(folder.exists() for folder in folders)
    kept = cf.run(cloth(), tmp_path / "out")
    assert way(kept).folder == tmp_path / "out"


def test_a_temporary_folder_goes_without_a_warning():
    program = "import canopy_fem as cf; from conftest import cloth; r = cf.run(cloth()); print(r.folder); del r"
    done = subprocess.run(
        [sys.executable, "-X", "dev", "-W", "error", "-c", program],
        cwd=CASES.parents[1] / "python" / "tests", capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "Warning" not in done.stderr


class Environment:
    """Has a simulation, one of whose forces is a method of it."""

    def __init__(self):
        self.sim = cf.Simulation(cloth())
        self.sim.forces["wake"] = self.wake
        self.calls = 0

    def wake(self, t, x, v):
        self.calls += 1
        return 0 * x


def test_a_force_that_knows_its_simulation_is_collected():
    """Both go when no one else knows them; a deep copy has a force of its own."""
    one = Environment()
    other = copy.deepcopy(one)
    one.calls = 0
    other.sim.step()
    assert other.calls > 0 and one.calls == 0
    seen = [weakref.ref(one), weakref.ref(one.sim), weakref.ref(other)]
    del one, other
    gc.collect()
    assert [ref() for ref in seen] == [None] * 3
