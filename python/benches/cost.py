"""What a step costs through Python, and what a rollout gains from threads, on the cloth of 703 nodes.

    python python/benches/cost.py

A step is timed in six ways, in turns, and the least of twenty times is shown: on a busy machine the others measure
the rest of the machine. `step(n)` makes all its steps within the engine, in blocks. A cloth of
MuJoCo stands beside where that is installed.
"""

import resource
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

import canopy_fem as cf

ROOT = Path(__file__).resolve().parents[2]
CLOTH = ROOT / "assets" / "cases" / "cloth-k1000.json"
DROP = ROOT / "docs" / "guide" / "cases" / "two-stage.json"
STEPS = 500


def one_by_one(sim):
    for _ in range(STEPS):
        sim.step()


def with_copies(sim):
    for _ in range(STEPS):
        sim.step()
        _ = sim.positions


def with_out(sim, out=np.empty((703, 3))):  # noqa: B008  one array for all calls is meant
    for _ in range(STEPS):
        sim.step()
        sim.read_positions(out)


def with_force(sim, force=np.zeros((703, 3))):  # noqa: B008
    for _ in range(STEPS):
        sim.forces["f"] = force
        sim.step()


WAYS = {
    "in the engine, step(n)": lambda sim: sim.step(STEPS),
    "step()": one_by_one,
    "step(), positions": with_copies,
    "step(), read_positions(out)": with_out,
    "a force set, step()": with_force,
    "a force of a function, step()": one_by_one,
}


def steps(method, step):
    case = cf.Case(CLOTH, {"time.end": 1000.0, "time.method": method, "time.step": step})
    sims = {way: cf.Simulation(case) for way in WAYS}
    sims["a force of a function, step()"].forces["f"] = lambda t, x, v: x * 0.0
    best = dict.fromkeys(WAYS, np.inf)
    for _ in range(20):
        for way, go in WAYS.items():
            start = time.perf_counter()
            go(sims[way])
            best[way] = min(best[way], (time.perf_counter() - start) / STEPS)
    for way, seconds in best.items():
        print(f"{method:<16} {way:<30} {1e6 * seconds:8.1f} us  {seconds / best['step()']:.2f}")


def rollouts():
    """Gain of threads by the clock, and what tells why it may be small: processor time, which locks and memory that is
    fought over would raise, and the times that a thread had to wait."""
    base = cf.Case(CLOTH, {"time.end": 0.2})
    rule = "system.network.springs.0.stiffness"
    cases = [base.with_overrides({rule: stiffness}) for stiffness in np.linspace(500, 1500, 64)]
    best = {}
    for _ in range(5):
        for threads in (1, 2):
            waits, used, start = (
                resource.getrusage(resource.RUSAGE_SELF).ru_nvcsw,
                time.process_time(),
                time.perf_counter(),
            )
            cf.rollout(cases, threads=threads)
            now = time.perf_counter() - start, time.process_time() - used
            now = (*now, resource.getrusage(resource.RUSAGE_SELF).ru_nvcsw - waits)
            best[threads] = min(best.get(threads, now), now)
    for threads, (seconds, used, waits) in best.items():
        print(f"64 cloths, 400 steps, {threads} threads: {seconds:.2f} s, processor {used:.2f} s, {waits} waits")
    print(f"gain {best[1][0] / best[2][0]:.2f}; by processor time at most {2 * best[1][1] / best[2][1]:.2f}")


def drops():
    """1,000 drops of the guide's load under a canopy that opens in two stages, with other masses: processor time of
    `rollout` beside that of `canopy-fem sweep`, whose runs are those of the Rust engine, in turns."""
    masses = [float(mass) for mass in np.linspace(400, 600, 1000)]
    key = "system.network.mass.points.0.total"
    case = cf.Case(DROP)
    with tempfile.TemporaryDirectory() as folder:
        command = [cf.program(), "sweep", DROP, "--vary", f"{key}={','.join(map(repr, masses))}", "--threads", "1"]
        ways = {
            "canopy-fem sweep": lambda: subprocess.run([*command, "--out", f"{folder}/out", "--force", "--quiet"]),
            "rollout, 1 thread": lambda: cf.rollout(case, overrides=[{key: mass} for mass in masses], threads=1),
            "rollout, 2 threads": lambda: cf.rollout(case, overrides=[{key: mass} for mass in masses], threads=2),
        }
        for _ in range(3):
            for way, go in ways.items():
                before, start = used(), time.perf_counter()
                go()
                clock = time.perf_counter() - start
                print(f"1,000 drops, {way:<20} processor {used() - before:.2f} s, clock {clock:.2f} s")


def used():
    """[s] processor time of this process and of those that it has started."""
    both = [resource.getrusage(of) for of in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(of.ru_utime + of.ru_stime for of in both)


MUJOCO = """<mujoco>
<option timestep="{step}" gravity="0 0 -9.81" integrator="{integrator}"><flag contact="disable"/></option>
<worldbody>
<flexcomp name="cloth" type="grid" count="27 26 1" spacing=".07 .07 .05" dim="2" mass="6.2" radius=".001">
<elasticity young="1.155e7" poisson="0.333" thickness="1e-4" damping="0.0005" elastic2d="stretch"/>
<contact selfcollide="none"/>
<pin gridrange="0 0 26 0"/><pin gridrange="0 25 26 25"/>
</flexcomp>
</worldbody></mujoco>"""


def mujoco_flex():
    """A flex of MuJoCo with 702 vertices and the same modulus times thickness, E t = 2/sqrt(3) k, without contact: a
    membrane of triangles where ours has springs, so costs of a step are of the same size, not of the same model."""
    try:
        import mujoco
    except ImportError:
        print("MuJoCo: not installed")
        return
    for integrator, step in (("Euler", 5e-4), ("discrete", 5e-3)):
        model = mujoco.MjModel.from_xml_string(MUJOCO.format(step=step, integrator=integrator))
        data = mujoco.MjData(model)
        best = np.inf
        for _ in range(10):
            start = time.perf_counter()
            mujoco.mj_step(model, data, 100)
            best = min(best, (time.perf_counter() - start) / 100)
        text = f"{1e6 * best:8.1f} us, {1e3 * best / step:.0f} ms a simulated second"
        print(f"MuJoCo {mujoco.__version__}, flex of {model.nflexvert}, {integrator} {step} s: {text}")


if __name__ == "__main__":
    steps("velocity-verlet", 5e-4)
    steps("newmark", 5e-3)
    rollouts()
    drops()
    mujoco_flex()
