#!/usr/bin/env python3
"""The tables of docs/xpbd.md: what `xpbd` and `vbd` cost on fourteen scenes, beside the cheapest other method that is as accurate.

    python3 docs/xpbd.py                                           # all scenes, some minutes
    python3 docs/xpbd.py --scenes taut-net,cloth-k1000 --details   # every run

Each run is a case with gauges of the tension of all springs and the displacement of all nodes. Read off are the largest tension of
the run, the largest displacement, and the mean over the run of the displacement that is largest at the time. Errors are those
against a reference by `dormand-prince` with a tolerance of 1e-8, or by `newmark` in short steps where that would take long; its own
error is its distance from one with a ten times wider tolerance, or twice the step. Seconds leave out the start of the program.
"""

import argparse
import json
import subprocess
from pathlib import Path

# [s] steps of a picture or ten of them
FRAME, SHORT = 0.01, 0.001
SWEEPS = [
    ("xpbd", {"substeps": 10, "iterations": 1}, FRAME),
    ("xpbd", {"substeps": 100, "iterations": 1}, FRAME),
    ("xpbd", {"substeps": 1000, "iterations": 1}, FRAME),
    ("xpbd", {"substeps": 1, "iterations": 100}, FRAME),
    ("vbd", {"iterations": 20}, FRAME),
    ("vbd", {"iterations": 200}, FRAME),
    ("vbd", {"iterations": 10}, SHORT),
    ("vbd", {"iterations": 100}, SHORT),
]
IMPLICIT = [0.01, 0.005, 0.002, 0.001, 0.0005]
# [-] error of a good run
GOOD = 0.05
# [-] shares of the critical step
EXPLICIT = [0.95, 0.5]
GAUGES = [{"name": "springs", "on": "all", "of": "tension"}, {"name": "nodes", "on": "all", "of": "displacement"}]
QUANTITIES = ["springs.tension.peak", "nodes.displacement_max.peak", "nodes.displacement_max.mean"]

SPRINGS = "system.network.springs.0"
STILL = [{"on": "all", "pressure": 54.1, "kind": "dead", "direction": [0, 0, 1]}]
FINE = {"system.network.mesh.annulus.nodes": 20000, "system.network.mesh.annulus.boundary_nodes": 672}
GRADED = {"annulus": {"inner_radius": 0.1, "outer_radius": 1.0, "nodes": 703, "grading": 10}}


def taut_net(cells=26, tension=1.0):
    """A square net of 1 m, held at its edge and stretched by a hundredth, that a weight bends."""
    return {
        "name": "taut-net",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": cells, "rows": cells}},
            "mass": {"areal_density": 1.0},
            "springs": [{"on": "all", "stiffness": 1e4, "rest_scale": 0.99, "dashpot": {"axial": {"time": 1e-3}}}],
            "supports": [{"on": "boundary", "fix": "xyz"}],
            "gravity": [0, 0, -9.81],
        }},
        "time": {"end": 0.2, "method": "velocity-verlet", "step": 1e-4},
    }


def scenes():
    """Name, the case or its file, end [s], and what is changed. The scenes of docs/tradeoff.md, a net for the pendulum, which has no springs."""
    stiff = lambda k, tau: {f"{SPRINGS}.stiffness": k, f"{SPRINGS}.dashpot.relative.time": tau}
    no_air = {"system.network.aero": None, "system.network.loads": STILL}
    return {
        "taut-net": (taut_net(), 0.2, {}),
        "spring-pendulum": ("spring-pendulum", 2.0, {}),
        "cloth-k100": ("cloth-k100", 0.5, {}),
        "cloth-k1000": ("cloth-k1000", 0.5, {}),
        "cloth-k10000": ("cloth-k10000", 0.2, {}),
        "cloth-k100000": ("cloth-k100000", 0.1, {}),
        "k1e6": ("cloth-k100000", 0.1, stiff(1e6, 1.6e-5)),
        "k1e7": ("cloth-k100000", 0.1, stiff(1e7, 5e-6)),
        "k1e7-no-air": ("cloth-k100000", 0.1, {**stiff(1e7, 5e-6), **no_air}),
        "k1e4-dashpot": ("cloth-k10000", 0.2, {f"{SPRINGS}.dashpot.relative.time": 1e-2}),
        "parachute-50ms": ("parachute-50ms", 0.1, {}),
        "nodes-20000": ("cloth-k1000", 0.1, FINE),
        "nodes-20000-no-air": ("cloth-k1000", 0.1, {**FINE, **no_air}),
        "graded": ("cloth-k1000", 0.2, {"system.network.mesh": GRADED}),
    }


class Bench:
    """One scene, run by the program with any method."""

    def __init__(self, program, out, name, scene, timeout):
        self.program, self.out, self.timeout = program, out / name, timeout
        case, self.end, self.sets = scene
        self.out.mkdir(parents=True, exist_ok=True)
        self.case = Path("assets/cases") / f"{case}.json"
        if isinstance(case, dict):
            self.case = self.out / "case.json"
            self.case.write_text(json.dumps(case))

    def run(self, method, step=None, tolerance=None):
        """A row: status, error message, quantities, seconds and counted work."""
        time = {"end": self.end, "method": method, "step": step}
        if tolerance:
            time = {"end": self.end, "method": method, "tolerance": {"relative": tolerance, "absolute": tolerance * 1e-2}}
        sets = {
            **self.sets,
            "time": time,
            "output": {"frames": None, "gauges": GAUGES},
            "study": {"quantities": QUANTITIES},
        }
        command = [self.program, "solve", str(self.case), "--out", str(self.out / "run"), "--force", "--quiet", "--threads", "1"]
        for key, value in sets.items():
            command += ["--set", f"{key}={json.dumps(value)}"]
        (self.out / "run" / "summary.json").unlink(missing_ok=True)
        try:
            ended = subprocess.run(command, capture_output=True, text=True, timeout=self.timeout)
        except subprocess.TimeoutExpired:
            return {"status": f"over {self.timeout:g} s"}
        try:
            summary = json.loads((self.out / "run" / "summary.json").read_text())
        except OSError:
            return {"status": "refused", "why": ended.stderr.strip()}
        found = summary.get("quantities") or {}
        values = [found.get(name, {}).get("value") for name in QUANTITIES]
        return {
            "status": summary["status"],
            "values": values,
            "seconds": summary["cpu_seconds"] - summary["startup"]["cpu_seconds"],
            "passes": summary["force_evaluations"],
            "sweeps": summary["sweeps"],
            "critical": summary.get("critical_step"),
        }


def rank(error):
    """What is not known is the largest."""
    return float("inf") if error != error else error


def errors(row, reference):
    if row["status"] != "completed" or None in row["values"]:
        return [float("nan")] * len(QUANTITIES)
    return [abs(value / true - 1.0) for value, true in zip(row["values"], reference)]


def figure(number):
    return f"{number:.2g}" if number < 10 else f"{number:.0f}"


def percent(error):
    if error != error:
        return ""
    return f"{100 * error:.2g} %" if error < 0.995 else f"{100 * error:.0f} %"


def words(method, parameters, step):
    numbers = " x ".join(str(number) for number in parameters.values())
    return f"`{method}` {numbers}, {1000 * step:g} ms" if numbers else f"`{method}`, {1000 * step:.3g} ms"


def study(bench, fine):
    """The reference with its own error, the rows of the sweeping methods, and those of others."""
    if fine:
        references = [bench.run("newmark", step) for step in (2e-4, 4e-4)]
    else:
        references = [bench.run("dormand-prince", tolerance=tolerance) for tolerance in (1e-8, 1e-7)]
    if not all(row["status"] == "completed" for row in references):
        raise SystemExit(f"the reference of {bench.out.name} did not end: {references}")
    reference = references[0]["values"]
    own = errors(references[1], reference)
    sweeps = [(words(m, p, h), bench.run({m: p}, h)) for m, p, h in SWEEPS]
    probe = bench.run("velocity-verlet", 1e-3)
    critical = probe.get("critical") or bench.run("velocity-verlet", 1e-6).get("critical")
    steps = [share * critical for share in EXPLICIT] if critical else []
    others = [(words("velocity-verlet", {}, h), bench.run("velocity-verlet", h)) for h in steps]
    for method in ("backward-euler", "newmark"):
        others += [(words(method, {}, h), bench.run(method, h)) for h in IMPLICIT if h <= bench.end / 5]
    return reference, own, sweeps, others


def cheapest(others, reference, wanted):
    """The cheapest of the other runs whose errors are all at most these."""
    fits = lambda row: all(error <= most for error, most in zip(errors(row, reference), wanted))
    good = [(what, row) for what, row in others if row["status"] == "completed" and fits(row)]
    return min(good, key=lambda found: found[1]["seconds"], default=None)


def report(name, reference, own, sweeps, others, details):
    print(f"\n### {name}\n")
    values = ", ".join(f"{what} {value:.4g}" for what, value in zip(("largest tension [N]", "largest displacement [m]", "its mean [m]"), reference))
    print(f"Reference: {values}; known to {', '.join(percent(error) for error in own)}.\n")
    print("| method | tension off by | displacement off by | its mean off by | CPU [s] | passes | sweeps | as accurate, cheapest other | times dearer |")
    print("|---|---|---|---|---|---|---|---|---|")
    for what, row in sweeps + (others if details else []):
        if row["status"] != "completed":
            print(f"| {what} | {row['status']} | | | | | | | |")
            continue
        found = errors(row, reference)
        best = cheapest(others, reference, found)
        other, ratio = (best[0], figure(row["seconds"] / best[1]["seconds"])) if best else ("", "")
        other = f"{other}: {figure(best[1]['seconds'])} s" if best else ""
        cells = [what, *map(percent, found), figure(row["seconds"]), row["passes"], row["sweeps"], other, ratio]
        print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def summary(studies):
    """For every scene the cheapest run of each method whose numbers are all right to `GOOD`, and what an other method takes."""
    print("\n| scene | `xpbd` within 5 % | CPU [s] | times dearer | `vbd` within 5 % | CPU [s] | times dearer | tension of `xpbd` 10 x 1 off by |")
    print("|---|---|---|---|---|---|---|---|")
    for name, (reference, _, sweeps, others) in studies.items():
        cells = [name]
        for method in ("xpbd", "vbd"):
            good = [(what, row) for what, row in sweeps if f"`{method}`" in what and max(map(rank, errors(row, reference))) <= GOOD]
            found = min(good, key=lambda found: found[1]["seconds"], default=None)
            best = found and cheapest(others, reference, errors(found[1], reference))
            ratio = figure(found[1]["seconds"] / best[1]["seconds"]) if best else ""
            cells += [found[0].split(" ", 1)[1], figure(found[1]["seconds"]), ratio] if found else ["none", "", ""]
        first = sweeps[0][1]
        cells.append(percent(errors(first, reference)[0]) or first["status"])
        print("| " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/canopy-fem")
    parser.add_argument("--scenes", default=",".join(scenes()))
    parser.add_argument("--out", type=Path, default=Path("out/xpbd"))
    parser.add_argument("--timeout", type=float, default=120.0, help="[s] of a run")
    parser.add_argument("--details", action="store_true", help="also the runs of the other methods")
    options = parser.parse_args()
    studies = {}
    for name in options.scenes.split(","):
        bench = Bench(options.program, options.out, name, scenes()[name], options.timeout)
        studies[name] = study(bench, name.startswith("nodes"))
        report(name, *studies[name], options.details)
    summary(studies)


if __name__ == "__main__":
    main()
