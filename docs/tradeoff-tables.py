#!/usr/bin/env python3
"""Tables of docs/tradeoff.md from folders that `canopy-fem tradeoff` has left: cheapest run of every method for each accuracy.

    python3 docs/tradeoff-tables.py out/pendulum out/k1e7 ...
"""

import csv
import json
import sys
from pathlib import Path

WANTED = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8]


def figure(seconds: float) -> str:
    return f"{seconds:.2g}" if seconds < 10 else f"{seconds:.0f}"


def used(row: dict) -> str:
    return f"{float(row['step']):.4g} s" if row["step"] else f"tol {float(row['tolerance']):.0e}".replace("e-0", "e-")


def table(folder: Path) -> str:
    rows = list(csv.DictReader((folder / "tradeoff.csv").open()))
    study = json.loads((folder / "tradeoff.json").read_text())
    floor = study["plan"]["variants"][0]["reference"]["error"]
    methods = list(dict.fromkeys(row["method"] for row in rows))
    lines = ["| method | " + " | ".join(f"{w:.0e}".replace("e-0", "e-") for w in WANTED) + " | no result |"]
    lines.append("|---|" + "---|" * (len(WANTED) + 1))
    best = {}
    for method in methods:
        mine = [row for row in rows if row["method"] == method]
        cells = []
        for wanted in WANTED:
            good = [r for r in mine if r["status"] == "completed" and r["error"] and float(r["error"]) <= wanted]
            good = [r for r in good if wanted >= floor]
            chosen = min(good, key=lambda r: float(r["cpu_seconds"]), default=None)
            cells.append(chosen)
            if chosen and float(chosen["cpu_seconds"]) < best.get(wanted, (1e300, ""))[0]:
                best[wanted] = (float(chosen["cpu_seconds"]), method)
        failed = {}
        for row in mine:
            if row["status"] != "completed":
                failed[row["status"]] = failed.get(row["status"], 0) + 1
        lines.append((method, cells, ", ".join(f"{n} {status}" for status, n in failed.items())))
    out = lines[:2]
    for method, cells, failed in lines[2:]:
        text = []
        for wanted, chosen in zip(WANTED, cells):
            if chosen is None:
                text.append("")
                continue
            cell = f"{figure(float(chosen['cpu_seconds']))} s ({used(chosen)})"
            text.append(f"**{cell}**" if best[wanted][1] == method else cell)
        out.append(f"| `{method}` | " + " | ".join(text) + f" | {failed} |")
    return "\n".join(out)


for name in sys.argv[1:]:
    print(f"\n### {name}\n\n{table(Path(name))}")
