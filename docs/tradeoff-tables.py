#!/usr/bin/env python3
"""Tables of docs/tradeoff.md from the result folders of `canopy-fem tradeoff`: how much cheaper the better family is, scene by scene;
then the cheapest run of every method for each accuracy.

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


def read(folder: Path) -> tuple[list[dict], float]:
    rows = list(csv.DictReader((folder / "tradeoff.csv").open()))
    study = json.loads((folder / "tradeoff.json").read_text())
    families = {row["id"]: row["family"] for row in study["rows"]}
    for row, family in zip(rows, families.values()):
        row["implicit"] = family == "implicit"
    return rows, study["plan"]["variants"][0]["reference"]["error"]


def cheapest(rows: list[dict], wanted: float, floor: float) -> dict | None:
    if wanted < floor:
        return None
    good = [r for r in rows if r["status"] == "completed" and r["error"] and float(r["error"]) <= wanted]
    return min(good, key=lambda r: float(r["cpu_seconds"]), default=None)


def headings() -> list[str]:
    return [f"{w:.0e}".replace("e-0", "e-") for w in WANTED]


def summary(folders: list[Path]) -> str:
    lines = ["| scene | " + " | ".join(headings()) + " |", "|---|" + "---|" * len(WANTED)]
    for folder in folders:
        rows, floor = read(folder)
        cells = []
        for wanted in WANTED:
            explicit = cheapest([r for r in rows if not r["implicit"]], wanted, floor)
            implicit = cheapest([r for r in rows if r["implicit"]], wanted, floor)
            if explicit and implicit:
                ratio = float(implicit["cpu_seconds"]) / float(explicit["cpu_seconds"])
                best, factor = (explicit, ratio) if ratio > 1 else (implicit, 1 / ratio)
                cells.append(f"`{best['method']}` {factor:.2g}x" if factor < 100 else f"`{best['method']}` {factor:.0f}x")
            else:
                best = explicit or implicit
                cells.append(f"`{best['method']}` alone" if best else "")
        lines.append(f"| {folder.name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def table(folder: Path) -> str:
    rows, floor = read(folder)
    lines = ["| method | " + " | ".join(headings()) + " | no result |", "|---|" + "---|" * (len(WANTED) + 1)]
    best = {wanted: cheapest(rows, wanted, floor) for wanted in WANTED}
    for method in dict.fromkeys(row["method"] for row in rows):
        mine = [row for row in rows if row["method"] == method]
        cells = []
        for wanted in WANTED:
            chosen = cheapest(mine, wanted, floor)
            cell = f"{figure(float(chosen['cpu_seconds']))} s ({used(chosen)})" if chosen else ""
            cells.append(f"**{cell}**" if chosen and best[wanted] is chosen else cell)
        failed = {}
        for row in mine:
            if row["status"] != "completed":
                failed[row["status"]] = failed.get(row["status"], 0) + 1
        lines.append(f"| `{method}` | " + " | ".join(cells) + " | " + ", ".join(f"{n} {s}" for s, n in failed.items()) + " |")
    return "\n".join(lines)


folders = [Path(name) for name in sys.argv[1:]]
print(summary(folders))
for folder in folders:
    print(f"\n### {folder.name}\n\n{table(folder)}")
