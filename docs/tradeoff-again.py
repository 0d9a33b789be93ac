#!/usr/bin/env python3
"""Compares two studies of the same case: errors and counters of every run to the digit, and the order of the methods at each accuracy.

    python3 docs/tradeoff-again.py out/cloth-k1000 out/cloth-k1000-again
"""

import csv
import sys
from pathlib import Path

COUNTED = ["error", "error_max", "energy_error", "force_evaluations", "tangent_assemblies", "factorizations", "linear_solves", "status"]
WANTED = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]


def rows(folder: str) -> dict:
    key = lambda row: (row["method"], row["step"], row["tolerance"])
    return {key(row): row for row in csv.DictReader((Path(folder) / "tradeoff.csv").open())}


def best(study: dict, wanted: float) -> list[tuple[float, str]]:
    """Cheapest run of every method that is good enough, cheapest first."""
    found = {}
    for (method, *_), row in study.items():
        if row["status"] == "completed" and row["error"] and float(row["error"]) <= wanted:
            found[method] = min(found.get(method, 1e300), float(row["cpu_seconds"]))
    return sorted((seconds, method) for method, seconds in found.items())


a, b = (rows(folder) for folder in sys.argv[1:3])
both = [k for k in a if k in b and "not-run" not in (a[k]["status"], b[k]["status"])]
differing = [k for k in both if any(a[k][c] != b[k][c] for c in COUNTED)]
print(f"{len(both)} runs in both, {len(differing)} with other errors or counters {differing or ''}")
for wanted in WANTED:
    one, two = best(a, wanted), best(b, wanted)
    if one and two:
        first, again = one[0][1], two[0][1]
        worth = dict((method, seconds) for seconds, method in two)[first] / two[0][0]
        print(f"{wanted:.0e}: {first}, then {again}" + ("" if first == again else f" ({first} {worth:.2f} times as expensive there)"))
