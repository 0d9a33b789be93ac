"""A force of one's own on a weight on a cord: once as a function, once as an array before each step.

The function is called with the interpreter several times a step, so it is slow; it is exact in time. An array costs
less, and acts unchanged for a whole step.
"""

import time

import numpy as np

import canopy_fem as cf


def cord():
    """Ten springs of 0.1 m with 1 kg at the end, in no gravity."""
    mesh = cf.mesh.chain(start=[0, 0, 0], end=[0, 0, -1], segments=10)
    mass = np.full(11, 0.01)
    mass[-1] = 1.0
    net = cf.Network(mesh, mass=mass)
    net.springs(stiffness=20000.0, slack="tension-only", dashpot=1.0)
    net.hold([0])
    return cf.Simulation(net, method="velocity-verlet", step=1e-4, end=10.0)


def magnet(t, x, v):
    """Draws the last node to (0.5, 0, -1) as a spring of 50 N/m, and pulls down with 10 N."""
    force = np.zeros_like(x)
    force[-1] = 50.0 * (np.array([0.5, 0.0, -1.0]) - x[-1]) + [0, 0, -10.0]
    return force


by_function = cord()
by_function.forces.add("magnet", magnet, velocity_dependent=False)
start = time.perf_counter()
by_function.advance(0.5)
seconds = time.perf_counter() - start
print(f"function: {by_function.positions[-1].round(4)}, {1e6 * seconds / by_function.step_count:.0f} us a step")

by_array = cord()
start = time.perf_counter()
while by_array.time < 0.5 - 1e-9:
    by_array.forces["magnet"] = magnet(by_array.time, by_array.positions, None)
    by_array.step()
seconds = time.perf_counter() - start
print(f"array:    {by_array.positions[-1].round(4)}, {1e6 * seconds / by_array.step_count:.0f} us a step")
assert np.allclose(by_function.positions, by_array.positions, atol=2e-3)
