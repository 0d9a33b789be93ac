"""Studies by the program, and rollouts."""

import os
import signal
import subprocess
import threading
import time

import numpy as np
import pytest
from conftest import CASES, cloth

import canopy_fem as cf


def test_check_reports(small):
    report = cf.check(small, within=1e-2)
    assert report["nodes"] == 49 and report["method"] == "velocity-verlet"
    steps = {entry["method"]: entry["critical_step"] for entry in report["critical_steps"]}
    assert 1e-3 < steps["velocity-verlet"] < 0.1 and steps["newmark"] is None
    assert report["within"] == "1 %" and 0 < report["this_case"]["errors"]["motion"]["error"] < 0.1
    named = cf.check(small, within="0.1m", quantities=["displacement_end"])
    assert list(named["this_case"]["errors"]) == ["displacement_end"]
    with pytest.raises(cf.CaseError, match="not below the whole value"):
        cf.check(small, within=2.0)


def test_studies_have_rows(small, tmp_path):
    rows = cf.stability(small, tmp_path / "stability", arguments=["--methods", "velocity-verlet,rk4"])
    assert [row["method"] for row in rows] == ["velocity-verlet", "rk4"]
    assert all(abs(row["measured"] / row["predicted"] - 1) < 0.1 for row in rows)
    arguments = ["--methods", "velocity-verlet,newmark", "--steps", "2e-3,4e-3", "--budget", "20s"]
    rows = cf.tradeoff(small, arguments=arguments)
    assert len(rows) == 4 and all(row["status"] == "completed" and row["error"] < 0.1 for row in rows)
    assert (tmp_path / "stability" / "stability.svg").exists()


def test_sweep_has_a_row_a_value(small, tmp_path):
    """A grid of values has a row each, with the values and the numbers of `solve`; faults name value and place."""
    key = "system.network.springs.0.stiffness"
    vary = {key: np.array([100.0, 200.0]), "time.method": ["rk4", {"hht": {"alpha": -0.2}}]}
    rows = cf.sweep(small, vary, tmp_path / "sweep", arguments=["--threads", "1"])
    assert [row[key] for row in rows] == [100.0, 100.0, 200.0, 200.0]
    assert all(row["status"] == "completed" and row["steps"] == 200 for row in rows)
    alone = cf.run(cf.Case(small, {key: 200.0, "time.method": "rk4"}))
    assert rows[2]["max_speed"] == alone.history["max_speed"].max()
    assert (tmp_path / "sweep" / "sweep.svg").exists()
    steps = [row["time.step"] for row in cf.sweep(small, {"time.step": "log:1e-4..1e-2:3"})]
    assert steps == [1e-4, 1e-3, 1e-2]
    with pytest.raises(cf.CaseError, match="stiffness"):
        cf.sweep(small, {key: [100.0, -1.0]})
    for wrong in ([key], {key: 100.0}, {key: []}):
        with pytest.raises(TypeError):
            cf.sweep(small, wrong)


@pytest.mark.skipif(os.name == "nt", reason="needs signals")
def test_ctrl_c_ends_the_program_of_a_study(tmp_path):
    """A sweep that is interrupted leaves its plan, and no process."""
    case = cf.Case(CASES / "cloth-k1000.json", {"time.end": 2000.0, "output": None})
    out = tmp_path / "sweep"

    def interrupt():
        while not (out / "sweep" / "plan.json").exists():
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt, daemon=True).start()
    with pytest.raises(KeyboardInterrupt):
        cf.sweep(case, {"time.step": [5e-4, 2.5e-4]}, out)
    # Not any child: pools of other tests may have left their helpers.
    listed = subprocess.run(["ps", "-A", "-o", "ppid=,args="], capture_output=True, text=True, check=True).stdout
    own = [line.split(maxsplit=1)[1] for line in listed.splitlines() if line.split()[0] == str(os.getpid())]
    assert not any("canopy-fem" in line and "sweep" in line for line in own), own


def test_a_sample_has_rows_and_a_summary(small, tmp_path):
    """Rows are those of the seed; the summary is of the numbers that were asked for."""
    (tmp_path / "sets.csv").write_text("time.end,weight\n0.02,1\n0.03,3\n")
    vary = {"rows": str(tmp_path / "sets.csv"), "time.step": [1e-3, 5e-4]}
    one = cf.sample(small, vary, 12, ["max_speed"], seed=3, arguments=["--no-errors"])
    two = cf.sample(small, vary, 12, ["max_speed"], seed=3, arguments=["--no-errors", "--threads", "1"])
    assert len(one.rows) == 12 and [row["time.end"] for row in one.rows].count(0.03) == 9
    assert [row["max_speed"] for row in one.rows] == [row["max_speed"] for row in two.rows]
    (speed,) = one.summary["quantities"]
    mean = sum(row["max_speed"] for row in one.rows) / 12
    assert speed["name"] == "max_speed" and abs(speed["mean"]["value"] - mean) < 1e-12 * mean
    with pytest.raises(cf.CaseError, match="standard deviation"):
        cf.sample(small, {"time.end": "normal:1"}, 12)
    with pytest.raises(TypeError):
        cf.sample(small, ["time.end"], 12)


def test_rollout_is_the_same_for_every_number_of_threads(small):
    """Variants of one case run at once; each is the run of a simulation, in the order given."""
    base = cf.Case(small)
    stiffness = [100.0, 200.0, 400.0, 800.0]
    cases = [base.with_overrides({"system.network.springs.0.stiffness": k}) for k in stiffness]
    one = cf.rollout(cases, threads=1, nodes=[48, 3], every=0.05)
    two = cf.rollout(cases, threads=2, nodes=np.array([48, 3], dtype=np.uint8), every=0.05)
    for case, a, b in zip(cases, one, two, strict=True):
        assert a.status == "completed" and a.steps == 200
        np.testing.assert_allclose(a.t, [0, 0.05, 0.1, 0.15, 0.2], atol=1e-12)
        assert a.positions.shape == (5, 2, 3) and a.positions.tobytes() == b.positions.tobytes()
        sim = cf.Simulation(case)
        sim.run()
        assert (a.positions[-1] == sim.positions[[48, 3]]).all()
        assert (a.velocities[-1] == sim.velocities[[48, 3]]).all()
    assert len({a.positions[-1].tobytes() for a in one}) == 4


def test_failures_in_a_rollout_are_told(small):
    bad = cf.Case(small, {"time.step": 0.05, "time.end": 10})
    good, failed = cf.rollout([small, bad])
    assert good.failure is None and good.positions.shape == (2, 49, 3)
    assert failed.status == "diverged" and "cause" in failed.failure
    with pytest.raises(ValueError, match="49"):
        cf.rollout([small], nodes=[49])
    with pytest.raises(ValueError, match="every"):
        cf.rollout([small], every=0.0)
    with pytest.raises(TypeError):
        cf.rollout([small], nodes=[0.5])
    assert cf.rollout([]) == []


def test_a_solver_that_does_not_fit_is_a_fault(tmp_path):
    """Conjugate gradients cannot solve a pendulum: run, simulation and rollout name the place and what fits there."""
    swing = {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}}
    time = {"end": 1, "step": 1e-3, "method": "newmark"}
    case = cf.Case({"name": "swing", "system": swing, "time": time, "solver": {"linear": "cg"}})
    for act in (lambda: cf.run(case, tmp_path / "out"), lambda: cf.Simulation(case), lambda: cf.rollout([case])):
        with pytest.raises(cf.CaseError) as caught:
            act()
        (fault,) = caught.value.faults
        assert fault.pointer == "/solver/linear" and '"lu"' in fault.allowed
    assert not (tmp_path / "out").exists()


def test_kept_times_follow_adaptive_steps():
    """With adaptive steps the kept states are ends of steps, at or after the multiples."""
    case = cloth(time={"end": 0.2, "method": "newmark", "tolerance": {"relative": 1e-3, "absolute": 1e-5}})
    (run,) = cf.rollout([case], every=0.05)
    assert len(run.t) == 5 and (run.t >= np.arange(5) * 0.05 - 1e-12).all() and run.t[-1] == 0.2
