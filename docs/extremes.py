#!/usr/bin/env python3
"""The tables of docs/extremes.md: which methods stay bounded in steps far above the explicit limit, and on extreme scenes.

    python3 docs/extremes.py                                       # all methods on all scenes, some minutes
    python3 docs/extremes.py --scenes slack --methods newmark,hht --steps 50 --details

A scene is run in steps that are multiples of the explicit limit 2/w, in the same number of steps each. The table gives the
largest multiple up to which all runs were bounded. With `--details`, a cell tells how a run ended, or the largest energy
that the method made, over the largest energy of the scene itself.
"""

import argparse
import csv
import itertools
import json
import random
import shutil
import subprocess
from pathlib import Path

SIZES = [0.5, 2, 10, 1e2, 1e3, 1e4, 1e6]
# [-] energy made over the scene's own, up to which a run is called bounded
BOUNDED = 1e-2


def case(nodes, springs, mass, velocity, supports=(), **network):
    """A network of nodes [m] and springs; `mass` [kg] of each node, or `velocity` [m/s] of each."""
    held = [{"on": {"ids": list(supports)}, "fix": "xyz"}] if supports else []
    return {
        "mesh": {"explicit": {"nodes": nodes, "springs": [ends for ends, _ in springs]}},
        "mass": {"nodal": mass},
        "springs": [{"on": {"ids": [i]}, **law} for i, (_, law) in enumerate(springs)],
        "supports": held,
        "initial": {"velocity": velocity},
        **network,
    }


def net(cells, law, displacement=(0.0, 0.0), **network):
    """A square net with diagonals, cells of 0.1 m and nodes of 1 g that spin and move apart a little."""
    pseudo = random.Random(1)
    at = lambda i, j: i * (cells + 1) + j
    inside = range(cells)
    pairs = [(at(i, j), at(i + 1, j)) for i in inside for j in range(cells + 1)]
    pairs += [(at(i, j), at(i, j + 1)) for i in range(cells + 1) for j in inside]
    pairs += [(at(i, j), at(i + 1, j + 1)) for i in inside for j in inside]
    nodes = [[0.1 * i, 0.1 * j, 0.0] for i in range(cells + 1) for j in range(cells + 1)]
    middle = 0.05 * cells
    spin = lambda x, y: [-5.0 * (y - middle), 5.0 * (x - middle), 0.1 * pseudo.uniform(-1.0, 1.0)]
    velocity = [spin(x, y) for x, y, _ in nodes]
    for support in network.get("supports", ()):
        velocity[support] = [0.0, 0.0, 0.0]
    return case(nodes, [(pair, law) for pair in pairs], [1e-3] * len(nodes), velocity, **network)


def chain(stiffness, mass):
    """A chain of 1 m links that hangs from its first node, pushed aside."""
    count = len(mass)
    nodes = [[0.0, 0.0, -float(i)] for i in range(count)]
    springs = [((i, i + 1), {"stiffness": k}) for i, k in enumerate(stiffness)]
    velocity = [[0.0 if i == 0 else 1.0, 0.0, 0.0] for i in range(count)]
    return case(nodes, springs, mass, velocity, supports=[0])


def scenes():
    """Name, what it is, the network, and the same with taut springs of the edges' lengths, which sets the explicit limit."""
    edge = list(range(7))
    spring, gravity = {"stiffness": 1e4}, [0, 0, -9.81]
    free, green = net(6, spring), net(6, {"axial_rigidity": 1e3, "law": "green"})
    hung = lambda more: net(6, {**spring, **more}, supports=edge, gravity=gravity)
    held = lambda more: net(6, {**spring, **more}, supports=edge + [i + 42 for i in edge], gravity=gravity)
    pendulum = chain([1e6], [1.0, 1.0])
    stiffness, mass = chain([1.0, 1e12] * 4, [1.0] * 9), chain([1e3] * 8, [1e-6, 1e6] * 4 + [1e-6])
    slack = {"slack": "tension-only", "rest_scale": 1.02}
    return {
        "pendulum": ("one mass on a spring of 1e6 N/m, thrown aside", pendulum, pendulum),
        "free": ("a free net of springs, 6 x 6 cells, which spins", free, free),
        "green": ("the same of bars with Green's strain", green, green),
        "slack": ("the net without compression, held along an edge, all slack at the start", hung(slack), hung({})),
        "buckled": ("the net of springs a tenth too long, held along two edges", held({"rest_scale": 1.1}), held({})),
        "stiffness": ("a chain, every second link 1e12 times as stiff", stiffness, stiffness),
        "mass": ("a chain, every second node 1e12 times as heavy", mass, mass),
    }


def limit(program, network, out):
    """[s] The explicit limit 2/w at the start."""
    row = run(program, network, "velocity-verlet", 1e-12, 1, out)
    return row["critical_step"]


def run(program, network, method, step, count, out):
    problem = {
        "name": "extreme",
        "system": {"network": network},
        "time": {"end": count * step, "method": method, "step": step},
        "output": {"frames": None, "history": {"every": 1}},
    }
    out.mkdir(parents=True, exist_ok=True)
    (out / "case.json").write_text(json.dumps(problem))
    # Nothing of the run before, if a method does not take the scene.
    shutil.rmtree(out / "run", ignore_errors=True)
    command = [program, "solve", str(out / "case.json"), "--out", str(out / "run"), "--quiet"]
    ended = subprocess.run(command, capture_output=True, text=True)
    try:
        summary = json.loads((out / "run" / "summary.json").read_text())
        rows = list(csv.DictReader((out / "run" / "history.csv").open()))
    except OSError:
        if ended.stderr.startswith(f"error: {method}: "):
            return {"status": "refused"}
        raise SystemExit(ended.stderr) from None
    summary["rows"] = rows
    return summary


def energies(rows):
    """[J] the largest energy that the method made, and the largest that the scene itself had or was given."""
    number = lambda row, key: float(row[key])
    first = rows[0]
    start = number(first, "kinetic") + number(first, "elastic")
    given = max(start + number(first, "gravity") - number(row, "gravity") for row in rows)
    made = max(-number(row, "numerical") for row in rows)
    return made, max(start, given)


def cell(summary):
    if summary["status"] == "refused":
        return "refused"
    if summary["status"] == "diverged":
        return f"diverges ({summary['steps']})"
    if summary["status"] != "completed":
        return f"{summary['status']} ({summary['steps']})"
    made, scale = energies(summary["rows"])
    share = made / scale
    if share <= BOUNDED:
        return "bounded"
    return f"makes {share:.0%}" if share < 10 else f"makes {share:.0e} times"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="canopy-fem", help="the program, if it is not on the path")
    parser.add_argument("--methods", help="names, separated by commas; all if not given")
    parser.add_argument("--scenes", help="names, separated by commas; all if not given")
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--details", action="store_true", help="a table of every scene, too")
    parser.add_argument("--out", type=Path, default=Path("out/extremes"))
    asked = parser.parse_args()
    listed = subprocess.run([asked.program, "methods", "--json"], capture_output=True, text=True)
    methods = asked.methods.split(",") if asked.methods else [m["name"] for m in json.loads(listed.stdout)]
    chosen = {name: of for name, of in scenes().items() if not asked.scenes or name in asked.scenes.split(",")}
    held = {method: [] for method in methods}
    for name, (what, network, taut) in chosen.items():
        longest = limit(asked.program, taut, asked.out)
        if asked.details:
            print(f"\n### {name}\n\n{what[0].upper()}{what[1:]}. The explicit limit is {longest:.3g} s.\n")
            print(table_head(f"{size:g}" for size in SIZES))
        for method in methods:
            found = [cell(run(asked.program, network, method, size * longest, asked.steps, asked.out)) for size in SIZES]
            bounded = list(itertools.takewhile(lambda pair: pair[1] == "bounded", zip(SIZES, found)))
            held[method].append(f"{bounded[-1][0]:g}" if bounded else "refused" if "refused" in found else "none")
            if asked.details:
                print(f"| `{method}` | " + " | ".join(found) + " |", flush=True)
    print("\n" + table_head(chosen))
    for method, largest in held.items():
        print(f"| `{method}` | " + " | ".join(largest) + " |")


def table_head(columns):
    columns = list(columns)
    return "| method | " + " | ".join(columns) + " |\n|---|" + "---|" * len(columns)


main()
