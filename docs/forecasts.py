#!/usr/bin/env python3
"""What `check` predicts against what runs cost, and the errors that `solve --verify` states against true ones.

    docs/forecasts.py costs [CASE …]     processor time: predicted, of the run, and of check itself
    docs/forecasts.py errors [CASE …]    stated errors over those against a run with steps 16 times smaller

Needs target/release/canopy-fem and Python alone. Without cases: all that ship. Prints Markdown.
"""

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target" / "release" / "canopy-fem"
SHIPPED = ["assets/cases/*.json", "assets/cases/parachute/*.json", "docs/guide/cases/*.json"]
# [-] Steps of the reference over those of the case.
FINER = 16


def cpu(arguments: list[str]) -> tuple[float, subprocess.CompletedProcess[str]]:
    """Processor time of the program [s], and what it printed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(PROGRAM), *arguments], capture_output=True, text=True, cwd=ROOT, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done


def solved(case: str, more: list[str]) -> tuple[float, dict | None]:
    """Processor time of a run [s], and its summary; none if it failed."""
    with tempfile.TemporaryDirectory() as out:
        seconds, done = cpu(["solve", case, "--out", out, "--quiet", *more])
        summary = Path(out) / "summary.json"
        return seconds, json.loads(summary.read_text()) if done.returncode == 0 and summary.exists() else None


def costs(cases: list[str]) -> None:
    """One row a case."""
    print("| case | run [s] | predicted [s] | ratio | check [s] | of the run |\n|---|---|---|---|---|---|")
    ratios = []
    for case in cases:
        spent, checked = cpu(["check", case, "--json"])
        if checked.returncode != 0:
            continue
        told = json.loads(checked.stdout).get("this_case")
        seconds, summary = solved(case, [])
        if summary is None or told is None or json.loads(checked.stdout).get("refused"):
            print(f"| {name(case)} | {'fails' if summary is None else f'{seconds:.2f}'} | not told | | {spent:.2f} | |", flush=True)
            continue
        ratio = told["cpu_seconds"] / seconds
        ratios.append(ratio)
        share = spent / seconds
        print(f"| {name(case)} | {seconds:.2f} | {told['cpu_seconds']:.2f} | {ratio:.2f} | {spent:.2f} | {share:.2f} |", flush=True)
    within = sum(0.5 <= ratio <= 2.0 for ratio in ratios)
    print(f"\n{within} of {len(ratios)} within a factor of two")


def errors(cases: list[str]) -> None:
    """One row a case and quantity."""
    print("| case | quantity | value | stated | true | true/stated |\n|---|---|---|---|---|---|")
    ratios = []
    for case in cases:
        text = json.loads(cpu(["check", case, "--json"])[1].stdout or "{}")
        step = text.get("step")
        if not step:
            continue
        _, own = solved(case, ["--verify"])
        _, fine = solved(case, ["--step", repr(step / FINER)])
        if own is None or fine is None:
            print(f"| {name(case)} | fails | | | | |", flush=True)
            continue
        for quantity, of in own["quantities"].items():
            other = fine["quantities"].get(quantity, {})
            if of.get("value") is None or other.get("value") is None:
                continue
            true = abs(of["value"] - other["value"])
            stated = of.get("error")
            ratio = true / stated if stated else None
            if ratio is not None:
                ratios.append(ratio)
            shown = "not settled" if stated is None else f"{stated:.2g}"
            told = "" if ratio is None else f"{ratio:.2f}"
            print(f"| {name(case)} | {quantity} | {of['value']:.5g} | {shown} | {true:.2g} | {told} |", flush=True)
    below = [sum(ratio < most for ratio in ratios) for most in (1.0, 3.0, 10.0)]
    print(f"\nof {len(ratios)}: {below[0]} below the stated error, {below[1]} below 3 times, {below[2]} below 10 times")


def name(case: str) -> str:
    """Of a case, short."""
    return Path(case).stem


def main() -> None:
    """Runs what is asked for."""
    what = {"costs": costs, "errors": errors}.get(sys.argv[1] if len(sys.argv) > 1 else "")
    if what is None:
        sys.exit(__doc__)
    shipped = sorted(str(path.relative_to(ROOT)) for pattern in SHIPPED for path in ROOT.glob(pattern))
    what(sys.argv[2:] or shipped)


if __name__ == "__main__":
    main()
