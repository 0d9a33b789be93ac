"""The simulation: steps, attempts, snapshots, forces, actuation, arrays."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from conftest import CASES, cloth

import canopy_fem as cf


def test_steps_add_up(small):
    """step, step(n), advance, run_until and run give the same bits, however they are mixed."""
    one, other = cf.Simulation(small), cf.Simulation(small)
    for _ in range(10):
        one.step()
    one.step(40)
    one.advance(0.1)
    one.run()
    last = other.run()
    assert last.step == 200 and one.step_count == 200
    assert one.positions.tobytes() == other.positions.tobytes()
    assert one.velocities.tobytes() == other.velocities.tobytes()
    with pytest.raises(cf.Ended):
        one.step()
    assert one.run() is None


def test_motion_obeys_its_law():
    """A mass of 2 kg on a spring of 8 N/m: x = 1 + 0.5 cos(2 t), without any JSON, to rounding of the scheme."""
    net = cf.Network(np.array([[0, 0, 0], [1.5, 0, 0]], dtype=np.float32), mass=[2.0, 2.0])
    net.springs([[0, 1]], stiffness=8.0, rest_length=1.0)
    net.hold([0])
    sim = cf.Simulation(net, method="rk4", step=1e-3, end=10.0)
    sim.run_until(1.0)
    assert sim.positions[1, 0] == pytest.approx(1 + 0.5 * np.cos(2.0), abs=1e-10)
    assert sim.energies.kinetic + sim.energies.elastic == pytest.approx(1.0, abs=1e-9)
    assert sim.tension[0] == pytest.approx(8 * 0.5 * np.cos(2.0), abs=1e-8)


def test_methods_of_a_network_are_chained():
    """They return the network itself, and one chain makes what single calls make."""
    net = cf.Network([[0, 0, 0], [1.5, 0, 0]], mass=2.0)
    chained = net.springs([[0, 1]], stiffness=8.0, rest_length=1.0).hold([0]).force([1], [0, 0, 1])
    assert chained.initial(velocity=[[0, 0, 0], [0, 1, 0]]) is net
    single = cf.Network([[0, 0, 0], [1.5, 0, 0]], mass=2.0)
    single.springs([[0, 1]], stiffness=[8.0], rest_length=[1.0])
    single.hold([0])
    single.force([1], [0, 0, 1])
    single.initial(velocity=[[0, 0, 0], [0, 1, 0]])
    runs = [cf.Simulation(each, method="rk4", step=1e-3, end=1.0) for each in (net, single)]
    assert runs[0].run().energies.kinetic > 0.5 and runs[1].run() is not None
    assert runs[0].positions.tobytes() == runs[1].positions.tobytes()


def test_bars_of_finite_strain():
    """A green bar at twice its length pulls with EA lambda (lambda^2 - 1)/2 = 3 EA; another name is refused."""
    net = cf.Network([[0, 0, 0], [1, 0, 0]], mass=2)
    net.springs([[0, 1]], stiffness=8, law="green")
    net.hold([0])
    net.initial(displacement=[[0, 0, 0], [1, 0, 0]])
    sim = cf.Simulation(net, method="rk4", step=1e-3, end=1.0)
    assert sim.tension[0] == pytest.approx(24.0)
    with pytest.raises(ValueError, match='give "linear" or "green"'):
        net.springs(stiffness=1, law="red")


def test_network_of_a_mesh_hangs():
    """A net of arrays under gravity: reactions carry the weight of all nodes once it has come to rest."""
    mesh = cf.mesh.rectangle(width=1, height=1, columns=3, rows=3)
    net = cf.Network(mesh, mass=0.1, gravity=[0, 0, -10])
    net.springs(stiffness=np.full(len(mesh.edges), 500.0), dashpot=5.0, slack="tension-only", dashpot_kind="relative")
    net.hold(np.flatnonzero(mesh.nodes[:, 1] == 0))
    sim = cf.Simulation(net, method={"hht": {"alpha": -0.1}}, step=5e-3, end=20)
    sim.run_until(15.0)
    assert sim.reactions[:, 2].sum() == pytest.approx(10 * 0.1 * len(mesh.nodes), rel=1e-3)


def test_attempts_leave_no_trace(sim):
    """A dropped step has not happened; an accepted one is the step."""
    sim.step(5)
    before = sim.positions
    trial = sim.attempt()
    with pytest.raises(cf.SimulationError, match="neither accepted nor dropped"):
        sim.step()
    assert (sim.positions == before).all() and (trial.positions != before).any()
    sim.drop()
    assert (sim.positions == before).all()
    again = sim.attempt()
    assert sim.accept().step == 6
    assert (again.positions == trial.positions).all() and (sim.positions == trial.positions).all()
    with pytest.raises(cf.SimulationError, match="no step was attempted"):
        sim.accept()


@pytest.mark.parametrize("method", ["velocity-verlet", "newmark", "improved-euler-pec", "beeman"])
def test_snapshots_restore_the_bits(method):
    """A simulation goes on from a snapshot with the bits of the one it is of, with its forces and factors."""
    case = cloth(time={"end": 0.2, "method": method, "step": 1e-3})
    one, other = cf.Simulation(case), cf.Simulation(case)
    one.forces["wake"] = np.full((one.node_count, 3), 0.01)
    one.rest_scale[[0, 1]] = 0.9
    one.step(30)
    state = one.snapshot()
    one.step(50)
    other.restore(state)
    other.step(50)
    assert one.positions.tobytes() == other.positions.tobytes()
    for damaged in (b"", state[:-3], state[:9] + bytes([state[9] ^ 1]) + state[10:]):
        with pytest.raises(ValueError, match="snapshot"):
            other.restore(damaged)


def test_array_and_function_forces_agree(small):
    """The same force as an array and as a function gives the same motion; its work is external."""
    force = np.zeros((49, 3))
    force[:, 2] = 0.2
    one, other = cf.Simulation(small), cf.Simulation(small)
    one.forces["lift"] = force
    other.forces["lift"] = lambda t, x, v: force
    assert one.run_until(0.1).energies.external_work > 0.0
    other.run_until(0.1)
    np.testing.assert_allclose(one.positions, other.positions, atol=1e-12)
    assert list(one.forces) == ["lift"]
    del one.forces["lift"]
    with pytest.raises(KeyError):
        del one.forces["lift"]


def test_a_function_sees_time_and_motion(small):
    """A drag -c v in a function takes the energy that it should: as Rayleigh's mass damping does."""
    calls = []

    def drag(t, x, v):
        calls.append(t)
        assert x.shape == v.shape == (49, 3)
        return -0.05 * v

    sim = cf.Simulation(small)
    sim.forces.add("drag", drag, velocity_dependent=True)
    sim.run_until(0.1)
    assert sim.energies.external_work < 0 and abs(sim.energies.numerical) < 1e-3 * abs(sim.energies.gravity)
    assert max(calls) == pytest.approx(0.1) and min(calls) == 0.0


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (lambda t, x, v: 1 / 0, ZeroDivisionError),
        (lambda t, x, v: x[:3], ValueError),
        (lambda t, x, v: np.full_like(x, np.nan), ValueError),
        (lambda t, x, v: "no", TypeError),
        (lambda t, x: x, TypeError),
    ],
)
def test_exceptions_of_forces_come_out_of_the_step(small, wrong, error):
    """What a force raises ends the step, which has not happened; without the force the simulation goes on."""
    sim = cf.Simulation(small)
    sim.step(3)
    before = sim.positions
    sim.forces["wrong"] = wrong
    with pytest.raises(error):
        sim.step()
    assert sim.step_count == 3 and (sim.positions == before).all()
    del sim.forces["wrong"]
    sim.step()


def test_a_force_cannot_use_its_own_simulation(sim):
    sim.forces["self"] = lambda t, x, v: sim.positions
    with pytest.raises(cf.SimulationError, match="at work"):
        sim.step()


def test_actuation():
    """Wind, rest lengths and loads are changed on the way, by name."""
    sim = cf.Simulation(CASES / "parachute" / "c9-drop.json")
    assert "lines" in sim.group_names
    lines = sim.select("lines", "edges")
    assert len(sim.select("payload")) == 1 and len(sim.select("all")) == sim.node_count
    sim.rest_scale["lines"] = 0.99
    assert (sim.rest_scale[lines] == 0.99).all() and sim.rest_scale[lines].shape == lines.shape
    sim.loads["gravity"] = 0.0
    assert sim.loads["gravity"] == 0.0 and dict(sim.loads)["gravity"] == 0.0
    sim.set_wind([1.0, 0, 0])
    sim.set_wind(None)
    for act in (
        lambda: sim.select("lnies", "edges"),
        lambda: sim.loads.__setitem__("weight", 1.0),
    ):
        with pytest.raises(KeyError, match="lines|gravity"):
            act()
    with pytest.raises(ValueError, match="above 0"):
        sim.rest_scale["lines"] = -1.0


def test_state_is_set_and_read(sim):
    x = sim.reference.copy()
    x[20:] += [0.0, 0.0, 0.01]
    sim.set_state(x, np.zeros_like(x))
    np.testing.assert_array_equal(sim.positions, x)
    out = np.empty_like(x)
    assert sim.read_positions(out) is out and (out == x).all()
    assert sim.read_velocities(out) is out and not out.any()
    own = sim.read_positions()
    own[:] = 7.0
    assert (sim.positions == x).all()
    assert sim.edges.dtype == np.int64 and sim.triangles.shape == (72, 3)


def test_arrays_are_read_only(sim):
    """A change of one would be lost, so it raises."""
    mesh = cf.mesh.rectangle(width=1, height=1, columns=2, rows=2)
    run = cf.rollout([cloth()])[0]
    sim.forces["f"] = np.zeros((49, 3))
    trial = sim.attempt()
    arrays = [sim.positions, sim.velocities, sim.reactions, sim.tension, sim.reference, sim.edges, sim.triangles]
    arrays += [trial.positions, trial.velocities, sim.forces["f"], sim.rest_scale[[0, 1]], sim.select("all")]
    arrays += [mesh.nodes, mesh.edges, mesh.triangles, run.t, run.positions, run.velocities]
    for array in arrays:
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0


def test_unknown_attributes_are_refused(sim, small):
    """What is misspelt, or set by a method, raises and says what to use."""
    for name, words in {
        "wind": "set_wind",
        "positions": "set_state",
        "time": "time=",
        "threads": "Simulation",
        "velocity": "methods",
    }.items():
        with pytest.raises(AttributeError, match=words):
            setattr(sim, name, 1.0)
    net = cf.Network([[0, 0, 0]], mass=1)
    for thing in (net, cf.Case(small), cf.run(small), sim.forces, sim.loads, sim.rest_scale):
        with pytest.raises(AttributeError):
            thing.stiffness = 1.0

    class Own(cf.Simulation):
        """A class of one's own may have attributes."""

    own = Own(small)
    own.note = "mine"
    assert own.note == "mine"


def test_mappings_show_what_acts(sim):
    """Forces, loads and factors are those of the engine, after `restore` too."""
    sim.forces["a"] = np.ones((49, 3))
    state = sim.snapshot()
    sim.forces["a"] = lambda t, x, v: 2.0 + 0 * x
    sim.forces["b"] = np.zeros((49, 3))
    sim.forces["c"] = drag = lambda t, x, v: -v
    sim.loads["gravity"], sim.rest_scale[[3]] = 0.5, 0.9
    assert set(sim.forces) == {"a", "b", "c"} and callable(sim.forces["a"]) and "'c'" in repr(sim.forces)
    assert repr(sim.rest_scale) == "RestScales({3: 0.9})" and repr(sim.loads) == "Loads({'gravity': 0.5})"
    sim.restore(state)
    assert set(sim.forces) == {"a", "c"} and (sim.forces["a"] == 1.0).all() and sim.forces["c"] is drag
    assert sim.loads["gravity"] == 1.0 and sim.rest_scale[[3]] == [1.0]
    # Only the array of the snapshot acts under that name.
    del sim.forces["c"]
    other = cf.Simulation(cloth())
    other.restore(state)
    for one in (sim, other):
        one.step(5)
    assert sim.positions.tobytes() == other.positions.tobytes() and list(other.forces) == ["a"]
    with pytest.raises(TypeError):
        iter(sim.rest_scale)


def test_a_snapshot_starts_another_run():
    """Other stiffnesses, methods and steps take it, with a word; other nodes do not."""
    sim = cf.Simulation(cloth())
    sim.step(100)
    state, x = sim.snapshot(), sim.positions
    for moves, words in (
        ({"end": 0.2, "method": "newmark", "step": 1e-3}, "method velocity-verlet, now newmark"),
        ({"end": 0.2, "method": "velocity-verlet", "step": 4e-4}, "steps of 0.001 s, now steps of 0.0004 s"),
    ):
        other = cf.Simulation(cloth(time=moves))
        with pytest.warns(cf.CaseWarning, match=words):
            other.restore(state)
        assert other.time == pytest.approx(0.1, rel=1e-12) and (other.positions == x).all()
        assert other.step().time == pytest.approx(0.1 + moves["step"], rel=1e-12)
    softer = cf.Case(cloth(), {"system.network.springs.0.stiffness": 100.0})
    with pytest.warns(cf.CaseWarning, match="other stiffnesses"):
        cf.Simulation(softer).restore(state)
    finer = cf.Case(cloth(), {"system.network.mesh.rectangle.rows": 7, "output": None})
    with pytest.raises(ValueError, match="other nodes"):
        cf.Simulation(finer).restore(state)


def test_the_time_is_set(sim):
    """With a state; steps of fixed size keep their ends, and a time outside the run is refused."""
    x, v = sim.positions, sim.velocities
    sim.set_state(x, v, time=0.1)
    assert (sim.time, sim.step_count) == (0.1, 100)
    sim.set_state(x, v, time=0.0504)
    assert sim.step().time == pytest.approx(0.051, rel=1e-12)
    assert sim.run_until(0.2).step == 200
    for t in (-1.0, 0.3, float("nan")):
        with pytest.raises(ValueError, match="time"):
            sim.set_state(x, v, time=t)


def test_springs_on_parts_of_a_mesh():
    """Two kinds on the mesh's own edges, and some between other nodes, are the springs of one network."""
    mesh = cf.mesh.rectangle(width=1.0, height=1.0, columns=4, rows=4)
    net = cf.Network(mesh, mass=0.01)
    net.springs(mesh.edges[:20], stiffness=100.0)
    net.springs(mesh.edges[20:, ::-1], stiffness=1000.0)
    net.springs([[0, 24], [1, 0]], stiffness=[10.0, 50.0])
    net.hold([0])
    net.initial(displacement=[[0.0, 0, 0]] + [[0.01, 0, 0]] * 24)
    sim = cf.Simulation(net, method="newmark", step=1e-3, end=1.0)
    assert len(sim.edges) == len(mesh.edges) + 1 and sim.edges[-1].tolist() == [0, 24]
    pair = mesh.edges.tolist().index([0, 1])
    assert pair < 20 and sim.tension[pair] == pytest.approx((100 + 50) * 0.01)
    sim.step()


@pytest.mark.parametrize(
    ("out", "error"),
    [
        (np.empty((49, 2)), ValueError),
        (np.empty((49, 3), dtype=np.float32), TypeError),
        (np.empty((3, 49)).T, ValueError),
        ([[0.0] * 3] * 49, TypeError),
        (np.broadcast_to(0.0, (49, 3)), ValueError),
    ],
)
def test_out_must_fit(sim, out, error):
    with pytest.raises(error, match="out"):
        sim.read_positions(out)


def test_divergence_has_its_report(small):
    """A step far above the critical one diverges: the exception tells cause and advice, and the state is finite."""
    small["time"]["step"] = 0.05
    small["time"]["end"] = 10.0
    sim = cf.Simulation(small)
    with pytest.raises(cf.Diverged) as caught:
        sim.run()
    report = caught.value.report
    assert report["cause"] and report["advice"] and 0 < report["critical_step"] < 0.05
    assert np.isfinite(sim.positions).all()


def test_a_panic_is_an_exception():
    with pytest.raises(cf.InternalError, match="a test asked for this panic"):
        cf.mesh._core._panic()


def test_two_threads_cannot_use_one_simulation():
    """While a thread steps, another one gets an exception, whichever of them comes first, and nothing breaks."""
    sim = cf.Simulation(cf.Case(CASES / "cloth-k1000.json", {"time.end": 1000.0, "output": None}))
    refused, made = [], []

    def work():
        while not refused:
            try:
                made.append(sim.step(20).step)
            except cf.SimulationError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all("at work" in text for text in refused) and sim.step_count >= max(made, default=0)
    sim.step()


@pytest.mark.skipif(not hasattr(signal, "raise_signal") or os.name == "nt", reason="needs signals")
@pytest.mark.parametrize("how", ["run", "function", "record", "rollout", "implicit", "mesh", "case"])
def test_ctrl_c_is_quick(how, tmp_path):
    """KeyboardInterrupt comes at once from whatever is running; 5 s would be a hang, on any machine. A function that is
    interrupted is called no more, and its step is not looked into; an implicit step has not happened."""
    case = cf.Case(CASES / "cloth-k1000.json", {"time.end": 2000.0, "output.frames.every": 100.0})
    sim = cf.Simulation(case)
    if how == "implicit":
        mesh = cf.mesh.rectangle(width=1.0, height=1.0, columns=40, rows=40)
        net = cf.Network(mesh, mass=1e-4, gravity=[0, 0, -9.81])
        net.springs(stiffness=1000.0)
        net.hold([0, 1])
        sim = cf.Simulation(net, method="backward-euler", step=0.02, end=1e3)
    large = {"radius": 1.0, "nodes": 300_000}
    if how == "function":
        sim.forces["none"] = lambda t, x, v: 0.0 * x
    sent = []

    def interrupt():
        time.sleep(0.3)
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        {
            "run": sim.run,
            "function": sim.run,
            "implicit": sim.run,
            "mesh": lambda: cf.mesh.disc(**large),
            "case": lambda: cf.Case(cloth(), {"system.network.mesh": {"disc": large}}),
            "record": lambda: cf.run(case, tmp_path / "out"),
            "rollout": lambda: cf.rollout([case] * 3, threads=2),
        }[how]()
    late = time.perf_counter() - sent[0]
    assert late < 5.0, late
    if how in ("run", "function", "implicit"):
        before = sim.step_count
        sim.step()
        assert sim.step_count == before + 1
    if how == "record":
        assert (tmp_path / "out" / "checkpoint.bin").exists()
