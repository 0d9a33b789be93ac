#!/usr/bin/env python3
"""Thin surfaces in a stream, with the flow of Kratos: a rigid disc, a rigid cup, and a canopy that fills.

    surface.py rigid disc TABLE.csv --size 0.2       drag of a disc or a cup, open upstream, of 1 m
    surface.py fill RUN.npz --size 0.08              a canopy of 1 m, let go with a narrow skirt in a wind of 10 m/s
    surface.py plot PICTURE.png RUN.npz              pictures of the canopy while it fills
    surface.py drag PICTURE.svg TABLE.csv ...        drag of rigid surfaces over time

What is not modelled: porosity of the cloth, friction, turbulence below the size of the mesh.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from canopy_fem.background import box
from canopy_fem.coupling import Structure
from canopy_fem.embedded import Flow
from canopy_fem.embedded_coupling import Coupled

# [m/s], [m]
WIND, DIAMETER = 10.0, 1.0


def rigid(kind, rings=10, sectors=40):
    """Nodes [m] and triangles of a disc or a hemisphere of 1 m in diameter, which is open towards -z."""
    ring, sector = np.meshgrid(np.arange(1, rings + 1) / rings, 2 * np.pi * np.arange(sectors) / sectors, indexing="ij")
    slope = np.pi / 2 * ring
    radius = 0.5 * ring if kind == "disc" else 0.5 * np.sin(slope)
    height = 0.0 * ring if kind == "disc" else 0.5 * np.cos(slope) - 0.25
    nodes = np.stack([radius * np.cos(sector), radius * np.sin(sector), height], axis=2).reshape(-1, 3)
    nodes = np.concatenate([[[0.0, 0.0, 0.0 if kind == "disc" else 0.25]], nodes])
    number = 1 + np.arange(rings * sectors).reshape(rings, sectors)
    a, b = number[:-1], number[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    inner = np.stack([0 * number[0], number[0], np.roll(number[0], -1)], axis=1)
    rows = [np.stack(three, axis=2).reshape(-1, 3) for three in ((a, b, c), (a, c, d))]
    # A little off the planes of the mesh.
    return nodes + [0.0031, 0.0017, 0.0113], np.concatenate([inner, *rows])


def drag(kind, table, size, end):
    """Writes time [D/V] and drag coefficient, referred to the area of the opening."""
    points, triangles = rigid(kind)
    mesh = box([-4, -4, -3.2], [4, 4, 6.4], [[-0.75, -0.75, -0.5], [0.75, 0.75, 1.0]], size, 1.45)
    flow = Flow(mesh, points, triangles, stream=[0, 0, 1], step=0.8 * size, density=1.0, viscosity=1e-5)
    began, count = time.monotonic(), 0
    with open(table, "w", newline="", encoding="utf-8", buffering=1) as file:
        csv.writer(file).writerow(("time", "drag_coefficient"))
        while flow.time < end:
            coefficient = flow.advance()[:, 2].sum() / (0.5 * np.pi / 4)
            csv.writer(file).writerow((flow.time, coefficient))
            count += 1
    each = (time.monotonic() - began) / count
    print(f"{kind}: {len(mesh.tetrahedra)} tetrahedra, {each:.2f} s a step, drag coefficient {coefficient:.3f}")


def canopy():
    """A flat circular canopy of 1 m with 12 lines to a point that is held; its skirt is narrow at the start."""
    tape = {"axial_rigidity": 500.0, "slack": "tension-only", "dashpot": {"axial": {"time": 0.002}}}
    cloth = {"membrane": {"modulus": 5e7, "thickness": 1e-4}, "slack": "tension-only"}
    return {
        "name": "filling",
        "system": {
            "network": {
                "mesh": {
                    "parachute": {
                        "type": "flat-circular",
                        "nominal_diameter": DIAMETER,
                        "gores": 12,
                        "radial_segments": 6,
                        "vent_diameter": 0.08,
                        "lines": {"length": 0.9, "segments": 1},
                        "reefing": {"diameter": 0.3},
                        "start": "inflated",
                    }
                },
                "mass": {"areal_density": 0.2},
                "springs": [
                    {"on": {"group": "cloth"}, **cloth, "dashpot": {"axial": {"time": 0.002}}},
                    {"on": {"group": "radials"}, "linear_density": 0.001, **tape},
                    {"on": {"group": "lines"}, "linear_density": 0.002, **tape},
                ],
                "supports": [{"on": {"group": "confluence"}, "fix": "xyz"}],
            }
        },
        "time": {"end": 1.0, "method": "hht", "step": 0.002},
    }


def widths(positions):
    """[m] Twice the greatest distance of a node from the middle, seen along the wind, of nodes at some times."""
    aside = positions[:, :, :2] - positions[:, :, :2].mean(axis=1, keepdims=True)
    return 2 * np.linalg.norm(aside, axis=2).max(axis=1)


def fill(run, size, steps):
    """Writes times, positions, triangles and forces of the canopy."""
    structure = Structure(canopy(), ["canopy"])
    points, triangles = Coupled.surface(structure, "canopy")
    low, high = points[:, 2].min(), points[:, 2].max()
    fine = [[-0.48, -0.48, low - 0.15], [0.48, 0.48, high + 0.1]]
    mesh = box([-1.5, -1.5, low - 1.0], [1.5, 1.5, high + 1.8], fine, size, 1.7)
    flow = Flow(mesh, points, triangles, stream=[0, 0, WIND], step=0.8 * size / WIND, iterations=2)
    # The flow forms while the canopy is held.
    for _ in range(5):
        flow.advance()
    coupled = Coupled(flow, structure, "canopy", tolerance=2e-2)
    began, rows = time.monotonic(), [(structure.time, points, np.zeros_like(points), 0)]
    for _ in range(steps):
        count = coupled.advance()
        rows.append((structure.time, flow.points, coupled.forces, count))
        x, y, z = coupled.forces.sum(axis=0)
        width = widths(flow.points[None])[0]
        line = f"t {structure.time:.4f} s: {count} iterations, width {width:.3f} m, force {x:.1f} {y:.1f} {z:.1f} N"
        print(line, flush=True)
        times, positions, forces, counts = (np.array(column) for column in zip(*rows, strict=True))
        np.savez(run, time=times, positions=positions, forces=forces, iterations=counts, triangles=triangles)
    each = (time.monotonic() - began) / steps
    print(f"{len(mesh.tetrahedra)} tetrahedra, {each:.2f} s a step, {counts[1:].mean():.1f} iterations a step")


def plot(picture, run):
    """Six pictures of the canopy from the side, and width and force over time."""
    plt = _pyplot()
    from matplotlib.collections import LineCollection, PolyCollection

    structure, data = Structure(canopy(), ["canopy"]), np.load(run)
    skirt = np.flatnonzero(np.isin(structure.interfaces["canopy"].nodes, structure.sim.select("skirt")))
    held = structure.sim.positions[structure.sim.select("confluence")[0]]
    times, positions, triangles = data["time"], data["positions"], data["triangles"]
    figure = plt.figure(figsize=(9, 6), dpi=80, layout="constrained")
    grid = figure.add_gridspec(2, 6, height_ratios=[1.1, 1])
    # From a little above: the axes of the picture, and the depth.
    right, up, depth = np.array([1.0, 0, 0]), np.array([0, -0.2, 0.98]), np.array([0, 0.98, 0.2])
    for column, index in enumerate(np.linspace(0, len(times) - 1, 6).round().astype(int)):
        axes = figure.add_subplot(grid[0, column])
        nodes = positions[index]
        flat = np.stack([nodes @ right, nodes @ up], axis=1)
        faces = triangles[np.argsort(-(nodes @ depth)[triangles].mean(axis=1))]
        normal = np.cross(nodes[faces[:, 1]] - nodes[faces[:, 0]], nodes[faces[:, 2]] - nodes[faces[:, 0]])
        shade = 0.3 + 0.6 * np.abs(normal @ [0.5, -0.6, 0.6]) / np.linalg.norm(normal, axis=1)
        lines = [(flat[node], (held @ right, held @ up)) for node in skirt]
        axes.add_collection(LineCollection(lines, colors="grey", linewidths=0.5))
        axes.add_collection(PolyCollection(flat[faces], facecolors=plt.cm.Blues(shade), edgecolors="k", linewidths=0.2))
        axes.set(xlim=(-0.54, 0.54), ylim=(-0.8, 0.5), aspect="equal", title=f"{times[index]:.3f} s")
        axes.set_axis_off()
    width = widths(positions)
    force = data["forces"].sum(axis=1)[:, 2]
    for half, values, label in ((grid[1, :3], width, "width [m]"), (grid[1, 3:], force, "force [N]")):
        axes = figure.add_subplot(half)
        axes.plot(times, values)
        axes.set(xlabel="time [s]", ylabel=label, ylim=(0, None))
    figure.savefig(picture)


def compare(picture, tables):
    """Drag coefficients over time."""
    plt = _pyplot()
    figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
    for table in tables:
        rows = np.genfromtxt(table, delimiter=",", skip_header=1)
        axes.plot(rows[:, 0], rows[:, 1], label=Path(table).stem)
    axes.axhline(1.17, color="grey", linestyle=":", label="disc, measured")
    axes.axhspan(1.33, 1.42, color="grey", alpha=0.3, linewidth=0, label="cup, measured")
    axes.set(xlabel="time [D/V]", ylabel="drag coefficient [-]", ylim=(0, 2.5))
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(picture)


def _pyplot():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot

    return matplotlib.pyplot


def main():
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("rigid")
    one.add_argument("kind", choices=["disc", "cup"])
    one.add_argument("table")
    one.add_argument("--size", type=float, default=0.2, help="[m] of the bricks about the surface")
    one.add_argument("--end", type=float, default=8.0, help="[D/V]")
    one = commands.add_parser("fill")
    one.add_argument("run")
    one.add_argument("--size", type=float, default=0.08, help="[m] of the bricks about the canopy")
    one.add_argument("--steps", type=int, default=36)
    one = commands.add_parser("plot")
    one.add_argument("picture")
    one.add_argument("run")
    one = commands.add_parser("drag")
    one.add_argument("picture")
    one.add_argument("tables", nargs="+")
    given = parser.parse_args()
    if given.command == "rigid":
        drag(given.kind, given.table, given.size, given.end)
    elif given.command == "fill":
        fill(given.run, given.size, given.steps)
    elif given.command == "plot":
        plot(given.picture, given.run)
    else:
        compare(given.picture, given.tables)


if __name__ == "__main__":
    main()
