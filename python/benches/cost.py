"""What a step costs through Python, and what a rollout gains from threads, on the cloth of 703 nodes.

    python python/benches/cost.py

A step is timed in six ways, in turns, and the least of twenty times is shown: on a busy machine the others measure
the rest of the machine. `step(n)` makes all its steps within the engine, in blocks.
"""

import time
from pathlib import Path

import numpy as np

import canopy_fem as cf

CLOTH = Path(__file__).resolve().parents[2] / "assets" / "cases" / "cloth-k1000.json"
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
    base = cf.Case(CLOTH, {"time.end": 0.2})
    rule = "system.network.springs.0.stiffness"
    cases = [base.with_overrides({rule: stiffness}) for stiffness in np.linspace(500, 1500, 64)]
    seconds = {}
    for _ in range(3):
        for threads in (1, 2):
            start = time.perf_counter()
            cf.rollout(cases, threads=threads)
            seconds[threads] = min(seconds.get(threads, np.inf), time.perf_counter() - start)
    gain = seconds[1] / seconds[2]
    print(f"64 cloths, 400 steps: 1 thread {seconds[1]:.2f} s, 2 threads {seconds[2]:.2f} s: {gain:.2f}")


if __name__ == "__main__":
    steps("velocity-verlet", 5e-4)
    rollouts()
