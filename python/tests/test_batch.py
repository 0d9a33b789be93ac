"""Rollouts in arrays: the same numbers as runs made one by one, for any number of threads."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES, cloth

import canopy_fem as cf

KEY = "system.network.springs.0.stiffness"
GAUGES = [{"name": "cloth", "on": "all", "of": "tension", "every": 1}]
EVERY = 0.05


@pytest.fixture
def gauged():
    return cf.Case(cloth(output={"gauges": GAUGES, "frames": {"every": EVERY}}))


def kept(batch):
    return [getattr(batch, name).tobytes() for name in ("positions", "velocities", "gauges", "energies", "peaks")]


ALL = ["positions", "velocities", "gauges", "energies", "peaks", "peak_times"]


def test_a_batch_is_the_runs_one_by_one(gauged):
    """At the ends of steps states, gauges, energies and peaks have the bits of simulations that stop there."""
    stiffness = [100.0, 200.0, 400.0]
    changes = [{KEY: k} for k in stiffness]
    one = cf.rollout(gauged, overrides=changes, every=EVERY, keep=ALL, threads=1)
    two = cf.rollout(gauged, overrides=changes, every=EVERY, keep=ALL, threads=2)
    assert kept(one) == kept(two)
    assert one.channels == ["cloth tension_sum", "cloth tension_max"] and one.units == ["N", "N"]
    assert one.status == ["completed"] * 3 and one.steps.tolist() == [200] * 3 and len(one) == 3
    np.testing.assert_allclose(one.t, np.arange(5) * EVERY)
    for run, change in enumerate(changes):
        sim = cf.Simulation(gauged.with_overrides(change))
        for row, t in enumerate(one.t):
            if t > 0:
                sim.run_until(t)
            assert (one.positions[run, row] == sim.positions).all()
            assert (one.velocities[run, row] == sim.velocities).all()
            assert dict(zip(one.channels, one.gauges[run, row], strict=True)) == sim.gauges
            assert one.energies[run, row].tolist() == list(sim.energies.as_dict().values())
        assert dict(zip(one.channels, one.peaks[run], strict=True)) == sim.peaks
    listed = cf.rollout([gauged.with_overrides(change) for change in changes], times=one.t, keep=ALL)
    assert kept(listed) == kept(one)


def test_times_within_steps_are_interpolated(gauged):
    """Between steps of 1 ms, where the motion is a cubic up to h^4, a row agrees with a run whose steps end there; the
    account is near the mean of its neighbours."""
    t = np.array([0.0405, 0.1005])
    batch = cf.rollout(gauged, times=t, keep=["positions", "velocities", "gauges", "energies"])
    for row, time in enumerate(t):
        sim = cf.Simulation(gauged, free_steps=True)
        sim.run_until(round(time - 0.0005, 9))
        before = list(sim.energies.as_dict().values())
        sim.attempt(0.0005)
        sim.accept()
        assert np.abs(batch.positions[0, row] - sim.positions).max() < 1e-6
        assert np.abs(batch.velocities[0, row] - sim.velocities).max() < 1e-3
        assert batch.gauges[0, row] == pytest.approx(list(sim.gauges.values()), rel=1e-2)
        sim.attempt(0.0005)
        sim.accept()
        after = list(sim.energies.as_dict().values())
        assert batch.energies[0, row] == pytest.approx(np.add(before, after) / 2, rel=1e-2, abs=1e-6)


def test_actions_act_as_in_a_loop():
    """Forces, wind, rest lengths and loads that change at the times have the bits of a simulation set in a loop."""
    case = cloth()
    case["system"]["network"]["aero"] = {"law": {"pressure_coefficient": {"cp": 1.0}}, "wind": [0, 0, 0.5]}
    case = cf.Case(case)
    t = np.arange(5) * EVERY
    rng = np.random.default_rng(1)
    force, wind = rng.normal(size=(2, 5, 3)) * 0.1, rng.normal(size=(2, 5, 3))
    reef, heavy = rng.uniform(0.8, 1.1, (2, 5)), rng.uniform(0.5, 1.5, 5)
    edges = (0, 1, 2)
    batch = cf.rollout(
        case,
        times=t,
        keep=["positions", "velocities"],
        forces={"boundary": force},
        wind=wind,
        rest_scale={edges: reef},
        loads={"gravity": heavy},
        threads=2,
    )
    for run in range(2):
        sim = cf.Simulation(case)
        on = np.zeros((49, 3))
        for row, time in enumerate(t):
            if time > 0:
                sim.run_until(time)
            assert (batch.positions[run, row] == sim.positions).all(), (run, row)
            assert (batch.velocities[run, row] == sim.velocities).all()
            if row == 4:
                break
            on[sim.select("boundary")] = force[run, row]
            sim.forces["boundary"] = on
            sim.rest_scale[list(edges)] = reef[run, row]
            sim.loads["gravity"] = heavy[row]
            sim.set_wind(wind[run, row])


def test_forces_of_each_node(gauged):
    """(runs, times, k, 3) gives each of k nodes its own; the rows of one value are those of (runs, times, 3)."""
    each = np.zeros((1, 2, 2, 3))
    each[..., 2] = [0.1, 0.2]
    nodes = (30, 48)
    batch = cf.rollout(gauged, forces={nodes: each}, keep=["positions"])
    apart = cf.rollout(gauged, forces={30: [0, 0, 0.1], 48: [0, 0, 0.2]}, keep=["positions"])
    np.testing.assert_allclose(batch.positions, apart.positions, rtol=0, atol=1e-12)
    alike = cf.rollout(gauged, forces={nodes: np.full((1, 2, 2, 3), 0.1)}, keep=["positions"])
    assert (
        alike.positions.tobytes()
        == cf.rollout(gauged, forces={nodes: [0.1] * 3}, keep=["positions"]).positions.tobytes()
    )
    with pytest.raises(ValueError, match="2, 3"):
        cf.rollout(gauged, forces={nodes: np.zeros((1, 2, 3, 3))})


def test_runs_begin_where_they_are_told(gauged):
    """From states, and from snapshots: the runs go on with the bits of the simulation."""
    sim = cf.Simulation(gauged)
    states = []
    for _ in range(2):
        sim.step(20)
        states.append((sim.positions, sim.velocities))
    x, v = (np.array(part) for part in zip(*states, strict=True))
    batch = cf.rollout(gauged, initial=(x, v), keep=["positions", "velocities"])
    assert (batch.positions[:, 0] == x).all() and (batch.velocities[:, 0] == v).all()
    begun = cf.Simulation(gauged)
    begun.set_state(x[1], v[1])
    begun.run()
    assert (batch.positions[1, -1] == begun.positions).all()
    snapshot, t = sim.snapshot(), sim.time
    times = [0.0, t, 0.1, 0.2]
    wind = np.zeros((3, 4))
    wind[2] = 1.0
    ahead = cf.rollout(gauged, times=times, initial=snapshot, loads={"gravity": wind}, keep=["positions"])
    assert np.isnan(ahead.positions[:, 0]).all() and (ahead.positions[:, 1] == sim.positions).all()
    sim.loads["gravity"] = 1.0
    sim.run()
    assert (ahead.positions[2, -1] == sim.positions).all() and (ahead.positions[0] != ahead.positions[2])[-1].any()
    with pytest.raises(TypeError, match="give times"):
        cf.rollout(gauged, initial=snapshot)


def test_arrays_of_the_caller_are_filled(gauged):
    out = {"positions": np.empty((2, 5, 1, 3)), "gauges": np.empty((2, 5, 2))}
    batch = cf.rollout(gauged, overrides=[{}, {KEY: 50.0}], every=EVERY, nodes=[48], out=out)
    assert batch.positions is out["positions"] and batch.gauges is out["gauges"]
    again = cf.rollout(gauged, overrides=[{}, {KEY: 50.0}], every=EVERY, nodes=[48], keep=["positions", "gauges"])
    assert again.positions.tobytes() == out["positions"].tobytes()
    with pytest.raises(AttributeError, match="keep="):
        _ = batch.energies
    wrong = [np.empty((2, 5, 2), dtype=np.float32), np.empty((2, 4, 2)), np.empty((2, 5, 4))[:, :, ::2]]
    for array in wrong:
        with pytest.raises((ValueError, TypeError), match="out"):
            cf.rollout(gauged, overrides=[{}, {}], every=EVERY, out={"gauges": array})
    with pytest.raises(KeyError, match="nothing"):
        cf.rollout(gauged, keep=["tension"])


def test_failures_leave_rows_empty(gauged):
    """A run that fails has rows up to there and NaN from there on; the others are whole."""
    batch = cf.rollout(
        gauged, overrides=[{}, {"time.step": 0.05}], times=[0.0, 0.1, 0.2], keep=["energies", "positions"]
    )
    assert batch.status == ["completed", "diverged"] and list(batch.failures) == [1]
    assert np.isfinite(batch.positions[0]).all() and np.isfinite(batch.positions[1, 0]).all()
    assert np.isnan(batch.positions[1, -1]).all() and np.isnan(batch.energies[1, -1]).all()
    assert "1 failed" in repr(batch)


def test_what_does_not_fit_is_told(gauged):
    for wrong, match in (
        ({"times": [0.0, 0.1, 0.1]}, "above the one before"),
        ({"times": [0.0, 0.1], "every": 0.1}, "either"),
        ({"wind": np.zeros((2, 2, 2))}, "runs, times, 3"),
        ({"rest_scale": {0: [1.0, 1.0, 1.0]}}, "does not spread"),
        ({"rest_scale": {0: -1.0}}, "above 0"),
        ({"forces": {"nowhere": [0, 0, 1]}}, "groups here"),
        ({"loads": {"snow": 1.0}}, "the scene has: gravity"),
        ({"wind": [0, 0, 1.0]}, "no air"),
        ({"nodes": [49], "keep": ["positions"]}, "49"),
        ({"forces": {99: [0, 0, 1]}}, "99"),
        ({"overrides": [{}, {}], "loads": {"gravity": np.ones((3, 2))}}, "3 runs"),
        ({"initial": (np.zeros((2, 3)), np.zeros((2, 3)))}, "initial"),
    ):
        with pytest.raises((ValueError, TypeError, KeyError, cf.SimulationError), match=match):
            cf.rollout(gauged, **wrong)
    with pytest.raises(cf.CaseError):
        cf.rollout(gauged, overrides=[{KEY: -1.0}])
    with pytest.raises(TypeError, match="need times"):
        cf.rollout([gauged], keep=["positions"])
    with pytest.raises(ValueError, match="run 1 has other gauges"):
        cf.rollout([gauged, gauged.with_overrides({"output.gauges": None})], times=[0.0, 0.1])


def test_progress_is_told(gauged):
    told = []
    cf.rollout(gauged, overrides=[{}] * 3, progress=lambda made, runs: told.append((made, runs)))
    assert told[-1] == (3, 3)

    def stop(made, runs):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cf.rollout(gauged, overrides=[{}] * 3, progress=stop)


def test_tables_of_a_batch(gauged):
    batch = cf.rollout(
        gauged, overrides=[{}, {KEY: 50.0}], every=EVERY, keep=["gauges", "energies", "positions", "peaks"]
    )
    assert batch.gauge("cloth", "tension_max").shape == (2, 5) and np.shares_memory(
        batch.gauge("cloth", "tension_max"), batch.gauges
    )
    assert (batch.energy("kinetic")[:, 1:] > 0).all()
    with pytest.raises(KeyError, match="tension_sum, tension_max"):
        batch.gauge("cloth")
    with pytest.raises(KeyError, match="cloth"):
        batch.gauge("riser")
    pandas = pytest.importorskip("pandas")
    table = batch.to_pandas()
    assert isinstance(table, pandas.DataFrame) and len(table) == 10
    assert (table["cloth tension_max"].to_numpy().reshape(2, 5) == batch.gauge("cloth", "tension_max")).all()


def test_polars_and_xarray(gauged):
    batch = cf.rollout(gauged, every=EVERY, keep=["gauges", "energies", "positions", "peaks"])
    pytest.importorskip("polars")
    assert batch.to_polars()["kinetic"].to_list() == batch.energy("kinetic").ravel().tolist()
    pytest.importorskip("xarray")
    data = batch.to_xarray()
    chosen = data.gauges.sel(channel="cloth tension_max").values
    assert (chosen == batch.gauge("cloth", "tension_max")).all() and data.positions.dims[2] == "node"


def test_runs_end_where_solve_ends(tmp_path):
    """A case that ends at rest ends there in a rollout too; later rows are NaN."""
    case = cf.Case(CASES / "oscillator.json", {"time.end": 10.0})
    case = case.with_overrides({"time.until_rest": {"speed": 1e3, "every": 1.0}})
    ended = cf.run(case, tmp_path / "out").summary["t_end"]
    assert ended < 10.0
    batch = cf.rollout(case, every=0.5, keep=["positions"])
    assert batch.t_end.tolist() == [ended]
    assert np.isnan(batch.positions[0, batch.t > ended + 1e-9]).all()
    assert np.isfinite(batch.positions[0, batch.t <= ended]).all()
    assert cf.rollout([case])[0].t_end == ended


def test_runs_end_with_the_last_of_their_times(gauged):
    """With `times` no step is made after the first that reaches the last of them; with `every` runs go to their end.
    Peaks are those of the steps that were made."""
    short = cf.rollout(gauged, times=[0.0, 0.05], keep=["positions", "peaks"])
    assert short.steps.tolist() == [50] and short.status == ["completed"]
    sim = cf.Simulation(gauged)
    sim.run_until(0.05)
    assert (short.positions[0, 1] == sim.positions).all()
    assert dict(zip(short.channels, short.peaks[0], strict=True)) == sim.peaks
    assert cf.rollout(gauged, times=[0.0, 0.0505]).steps.tolist() == [51]
    assert cf.rollout(gauged, every=0.15).steps.tolist() == [200]
    acted = cf.rollout(gauged, times=[0.0, 0.025, 0.05], loads={"gravity": [1.0, 1.0, 0.0]}, keep=["positions"])
    assert acted.steps.tolist() == [50] and (acted.positions[0, 2] == sim.positions).all()
    late = cf.rollout(gauged, times=[0.01], initial=sim.snapshot(), keep=["positions"])
    assert late.steps.tolist() == [50] and np.isnan(late.positions).all()


def test_threads_stay_for_the_next_rollout(gauged):
    """A second rollout starts no thread: those of the first are there still, and have the same bits."""
    task = Path("/proc/self/task")
    if not task.exists():
        pytest.skip("counts threads by /proc")

    def pool():
        return {entry.name for entry in task.iterdir() if (entry / "comm").read_text().startswith("rollout")}

    first = cf.rollout(gauged, overrides=[{}] * 4, keep=ALL, threads=2)
    threads = pool()
    assert len(threads) >= 2
    again = cf.rollout(gauged, overrides=[{}] * 4, keep=ALL, threads=2)
    assert pool() == threads and kept(again) == kept(first)
    cf.rollout([gauged] * 2, threads=2)
    assert pool() == threads


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_processes_have_the_same_bits(gauged, start):
    """Cases go to processes and batches come back as pickles; forked ones make threads of their own."""
    if start not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system has no {start}")
    changes = [{KEY: k} for k in (100.0, 200.0, 300.0, 400.0)]
    here = cf.rollout(gauged, overrides=changes, every=EVERY, keep=ALL, threads=2)
    context = multiprocessing.get_context(start)
    share = partial(cf.rollout, gauged, every=EVERY, keep=ALL, threads=2)
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        parts = [pool.submit(share, overrides=changes[place::2]) for place in range(2)]
        parts = [part.result(timeout=120) for part in parts]
    for place, part in enumerate(parts):
        for name in ALL:
            assert (getattr(part, name) == getattr(here, name)[place::2]).all(), name
        assert part.status == ["completed"] * 2 and part.channels == here.channels
