#!/usr/bin/env python3
"""A kite panel in the air forces of others: the vortex lattice of PanelAero (pip install PanelAero).

    kite.py [FIGURE]        runs it, prints lift and camber, and draws them

A rectangle of cloth between two spars is set at 8 degrees in a wind of 10 m/s. Its pressures come from PanelAero in
every step, for the shape and the motion of the cloth at the start of the step: a flow that follows at once. The flow is
linear and without separation, and there is no suction at the leading edge. Forces are passed by name:

    sim.forces["air"] = forces      # [N] on every node, (n, 3)
"""

import sys

import numpy as np
from panelaero import VLM

import canopy_fem as cf
from canopy_fem.background import nodal_forces

CHORD, SPAN = 1.0, 3.0
COLUMNS, ROWS = 10, 18
SPEED, DENSITY, INCIDENCE = 10.0, 1.225, np.radians(8.0)
WIND = SPEED * np.array([np.cos(INCIDENCE), 0.0, np.sin(INCIDENCE)])
STEP, END = 1e-3, 0.5


def case():
    """Cloth between two spars along y, at x = 0 and at x = CHORD."""
    spars = [[[x - 0.01, -1, -1], [x + 0.01, SPAN + 1, 1]] for x in (0.0, CHORD)]
    return {
        "name": "kite-panel",
        "system": {
            "network": {
                "mesh": {"rectangle": {"width": CHORD, "height": SPAN, "columns": COLUMNS, "rows": ROWS}},
                "mass": {"areal_density": 0.1},
                "springs": [
                    {
                        "on": "all",
                        "membrane": {"modulus": 2e8, "thickness": 1e-4},
                        "slack": "tension-only",
                        "dashpot": {"axial": {"time": 0.002}},
                    }
                ],
                "supports": [{"on": {"box": spar}, "fix": "xyz"} for spar in spars],
            }
        },
        "time": {"end": END, "method": "hht", "step": STEP},
    }


def panels(rows, columns):
    """Corners of the panels, (p, 4, 3), counter-clockwise from leading edge, of values at the nodes, (n, 3)."""
    grid = rows.reshape(-1, columns + 1, 3)
    return np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2).reshape(-1, 4, 3)


def lattice(positions, columns):
    """The panels as PanelAero knows them."""
    a, b, c, d = np.moveaxis(panels(positions, columns), 1, 0)
    normal = np.cross(c - a, d - b)
    twice = np.linalg.norm(normal, axis=1)
    first, second = a + 0.25 * (b - a), d + 0.25 * (c - d)
    return {
        "n": len(a),
        "A": twice / 2,
        "N": normal / twice[:, None],
        # [m] mean chord
        "l": (np.linalg.norm(b - a, axis=1) + np.linalg.norm(c - d, axis=1)) / 2,
        "offset_P1": first,
        "offset_P3": second,
        "offset_l": (first + second) / 2,
        "offset_j": (a + 0.75 * (b - a) + d + 0.75 * (c - d)) / 2,
    }


def air(positions, velocities, wind=WIND, columns=COLUMNS):
    """Places [m] and forces [N] of the air on the panels, (p, 3) each, which stand in rows along the wind."""
    grid = lattice(positions, columns)
    relative = wind - panels(velocities, columns).mean(axis=1)
    # [-] flow through the panels that the vortices must cancel, over the speed
    through = np.einsum("px,px->p", relative, grid["N"]) / SPEED
    influence, _ = VLM.calc_Qjj(grid, Ma=0.0)
    pressure = 0.5 * DENSITY * SPEED**2 * (influence @ through)
    return grid["offset_l"], (pressure * grid["A"])[:, None] * grid["N"]


def lift(forces):
    """[-] lift coefficient of a force, (3,)."""
    up = np.array([-np.sin(INCIDENCE), 0.0, np.cos(INCIDENCE)])
    return float(forces @ up / (0.5 * DENSITY * SPEED**2 * CHORD * SPAN))


def run(end=END):
    """Simulates the cloth; rows of time [s], lift coefficient and camber at mid-span [-], and the last positions."""
    sim = cf.Simulation(case())
    triangles = sim.triangles.astype(np.int64)
    history = []
    for _ in range(round(end / STEP)):
        positions = sim.positions
        at, forces = air(positions, sim.velocities)
        sim.forces["air"] = nodal_forces(positions, triangles, at, forces)
        sim.step()
        middle = sim.positions.reshape(ROWS + 1, COLUMNS + 1, 3)[ROWS // 2, :, 2]
        history.append((sim.time, lift(forces.sum(axis=0)), middle.max() / CHORD))
    return np.array(history), sim.positions


def draw(path, history, positions):
    """Lift and camber over time, and the shape at the end."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(8, 3.2), dpi=90, layout="constrained")
    left = figure.add_subplot(1, 2, 1)
    left.plot(history[:, 0], history[:, 1], label="lift coefficient")
    left.plot(history[:, 0], 10 * history[:, 2], label="10 × camber / chord")
    left.set(xlabel="time [s]", ylim=(0, None))
    left.legend(frameon=False)
    right = figure.add_subplot(1, 2, 2, projection="3d")
    x, y, z = np.moveaxis(positions.reshape(ROWS + 1, COLUMNS + 1, 3), 2, 0)
    right.plot_surface(x, y, z, cmap="viridis", linewidth=0.3, edgecolor="white")
    right.set(xlabel="x [m]", ylabel="y [m]", zlim=(0, 0.2), box_aspect=(1.5 * CHORD, SPAN, 0.6))
    right.set(xticks=[0, 0.5, 1], yticks=[0, 1, 2, 3], zticks=[0, 0.1, 0.2])
    figure.savefig(path)


def main():
    """The command."""
    rigid = lift(air(cf.Simulation(case()).positions, np.zeros(((ROWS + 1) * (COLUMNS + 1), 3)))[1].sum(axis=0))
    history, positions = run()
    print(f"flat and rigid: lift coefficient {rigid:.3f}")
    print(f"cloth:          lift coefficient {history[-1, 1]:.3f}, camber {100 * history[-1, 2]:.2f} % of the chord")
    if len(sys.argv) > 1:
        draw(sys.argv[1], history, positions)


if __name__ == "__main__":
    main()
