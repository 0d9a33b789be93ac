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
# [-] Steps of the case over those of the reference.
FINER = 16
# What is asked for beside the numbers of the report.
ASKED = ["displacement_end", "max_displacement", "max_speed", "max_strain"] + [
    f"energy.{kind}.{statistic}" for kind in ("kinetic", "elastic") for statistic in ("peak", "last")
]


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


def finer(case: str) -> list[str]:
    """Arguments for steps 16 times smaller; for a tolerance, that of an error of order 2 with such steps."""
    time = json.loads((ROOT / case).read_text())["time"]
    if "step" in time:
        return ["--step", repr(time["step"] / FINER)]
    if "tolerance" not in time:
        return []
    return [
        argument
        for key, value in time["tolerance"].items()
        for argument in ("--set", f"time.tolerance.{key}={value / FINER**3!r}")
    ]


def numbers(case: str, own: dict, fine: dict) -> list[tuple[str, float, float | None, float]]:
    """Name, value, stated and true error of each number of a run."""
    print(f"\n{name(case)}\n\n| quantity | value | stated | true | true/stated |\n|---|---|---|---|---|")
    rows = []
    for quantity, of in own["quantities"].items():
        other = fine["quantities"].get(quantity, {})
        if of.get("value") is None or other.get("value") is None:
            continue
        value, stated, true = of["value"], of.get("error"), abs(of["value"] - other["value"])
        rows.append((quantity, value, stated, true))
        shown, ratio = ("not settled", "") if stated is None else (f"{stated:.2g}", f"{true / stated:.2f}" if stated else "")
        print(f"| {quantity} | {value:.5g} | {shown} | {true:.2g} | {ratio} |", flush=True)
    return rows


def errors(cases: list[str]) -> None:
    """A table a case, and one of all cases."""
    compared = {}
    for case in cases:
        arguments = [argument for quantity in ASKED for argument in ("--quantity", quantity)]
        fine = solved(case, [*arguments, *finer(case)])[1] if finer(case) else None
        own = solved(case, [*arguments, "--verify"])[1] if fine else None
        if own and fine:
            compared[case] = numbers(case, own, fine)
        else:
            print(f"\n{name(case)}: no reference, or the run fails")
    summed(compared)


def of_stated(true: float, stated: float) -> float:
    """[-] The true error over the stated one; 0 of 0 is none."""
    return true / stated if stated else (0.0 if true == 0.0 else float("inf"))


def summed(compared: dict[str, list[tuple[str, float, float | None, float]]]) -> None:
    """One row a case, and one for those of the guide: how many numbers, and the worst; then those beyond 3 times."""
    groups: dict[str, list[tuple[str, str, float | None, float]]] = {}
    for case, rows in compared.items():
        group = groups.setdefault("cases of the guide" if "guide" in case else name(case), [])
        group += [(name(case), quantity, stated, true) for quantity, _, stated, true in rows]
    print("\n| case | numbers | not settled | median of true/stated | largest | of |\n|---|---|---|---|---|---|")
    every = []
    for group, rows in groups.items():
        own = sorted((of_stated(true, stated), quantity, case) for case, quantity, stated, true in rows if stated is not None)
        every += own
        (worst, which, _), middle = own[-1] if own else (0.0, "", ""), own[len(own) // 2][0] if own else 0.0
        print(f"| {group} | {len(rows)} | {len(rows) - len(own)} | {middle:.2f} | {worst:.2f} | {which} |")
    every.sort()
    below = [sum(ratio < most for ratio, _, _ in every) for most in (1.0, 3.0, 10.0)]
    print(
        f"\n{len(every)} numbers with a stated error: {below[0]} below it, {below[1]} below 3 times, {below[2]} below 10 times, "
        f"median {every[len(every) // 2][0] if every else 0.0:.2f}; {sum(map(len, compared.values())) - len(every)} not settled"
    )
    beyond = [f"{case} {quantity} {ratio:.1f}" for ratio, quantity, case in every if ratio >= 3.0]
    print(f"beyond 3 times: {', '.join(beyond) or 'none'}")


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
