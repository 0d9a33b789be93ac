#!/usr/bin/env python3
"""A sail of constant tension between two masts, against the theory of Thwaites (1961) and Nielsen (1963).

    sail.py                 prints the lift of the sail by both, for some tensions

The sail is two-dimensional: a strip that is 400 chords wide, in the vortex lattice of PanelAero. Its tension
coefficient is C_T = T / (q c), with the tension [N/m], dynamic pressure and chord. Below 1.73 it has no equilibrium.
"""

import numpy as np
from kite import DENSITY, SPEED, air

import canopy_fem as cf
from canopy_fem.background import nodal_forces

CHORD, WIDTH, COLUMNS, INCIDENCE = 1.0, 400.0, 30, np.radians(1.0)
PRESSURE = 0.5 * DENSITY * SPEED**2
WIND = SPEED * np.array([np.cos(INCIDENCE), 0.0, np.sin(INCIDENCE)])


def theory(tension, terms=40):
    """Lift coefficient over 2 pi times the incidence, and camber over chord and incidence, of Thwaites' sail equation.

    Glauert's series, with x = (1 - cos t) / 2: the vorticity is A0 cot(t/2) + sum An sin(n t), and the slope of the
    sail is 1 - A0 + sum An cos(n t). Equilibrium, z'' = -4 / C_T times the vorticity, is integrated once, with a constant.
    """
    t = np.pi * (np.arange(terms + 1) + 0.5) / (terms + 1)

    def integrals(t):
        first = [(t + np.sin(t)) / 2, t / 4 - np.sin(2 * t) / 8]
        higher = [(np.sin((n - 1) * t) / (n - 1) - np.sin((n + 1) * t) / (n + 1)) / 4 for n in range(2, terms + 1)]
        return np.stack(first + higher, axis=-1)

    # Unknowns: A0 to A_terms, and the slope at the leading edge.
    series = np.stack([-np.ones_like(t)] + [np.cos(n * t) for n in range(1, terms + 1)], axis=-1)
    equal = np.hstack([series + 4 / tension * integrals(t), -np.ones((len(t), 1))])
    # Both ends are at one height: the mean of the slope over x is 0.
    fine = np.pi * (np.arange(4000) + 0.5) / 4000
    weight = 0.5 * np.sin(fine) * np.pi / 4000
    slope = np.hstack([-4 / tension * integrals(fine), np.ones((len(fine), 1))])
    solved = np.linalg.solve(np.vstack([equal, weight @ slope]), np.append(-np.ones(len(t)), 0.0))
    height = np.cumsum(weight * (slope @ solved))
    return solved[0] + solved[1] / 2, height.max()


def sail(tension, end=1.5, step=1e-3):
    """The same of the sail of canopy-fem; it starts flat, and settles."""
    x = np.linspace(0, CHORD, COLUMNS + 1)
    nodes = np.array([[a, y, 0.0] for y in (-WIDTH / 2, WIDTH / 2) for a in x])
    first = np.array([[i, i + 1] for i in range(COLUMNS)])
    corners = [[i, i + 1, i + COLUMNS + 2, i + COLUMNS + 1] for i in range(COLUMNS)]
    triangles = np.array([three for a, b, c, d in corners for three in ((a, b, c), (a, c, d))])
    net = cf.Network(nodes, mass=0.05 * WIDTH * CHORD / len(nodes))
    # [N] on each of the two edges of the strip; springs without a length at rest, so that it hardly changes.
    pull, length = tension * PRESSURE * CHORD * WIDTH / 2, CHORD / COLUMNS
    net.springs(
        np.concatenate([first, first + COLUMNS + 1]), stiffness=pull / (0.99 * length), rest_length=0.01 * length
    )
    net.hold([0, COLUMNS, COLUMNS + 1, 2 * COLUMNS + 1])
    sim = cf.Simulation(net, method="backward-euler", step=step, end=end)
    for _ in range(round(end / step)):
        at, forces = air(sim.positions, sim.velocities, WIND, COLUMNS)
        sim.forces["air"] = nodal_forces(sim.positions, triangles, at, forces)
        sim.step()
    coefficient = forces[:, 2].sum() / (PRESSURE * CHORD * WIDTH)
    return coefficient / (2 * np.pi * INCIDENCE), sim.positions[:, 2].max() / (CHORD * INCIDENCE)


def main():
    """The command."""
    print("C_T   lift / (2 pi alpha)     camber / (chord alpha)")
    print("      theory   sail           theory   sail")
    for tension in (2.5, 4.0, 8.0, 20.0):
        (lift, camber), (found, height) = theory(tension), sail(tension)
        print(f"{tension:4.1f}  {lift:.3f}    {found:.3f}          {camber:.4f}   {height:.4f}")


if __name__ == "__main__":
    main()
