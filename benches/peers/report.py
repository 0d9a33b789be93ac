"""Tables and diagrams of the comparison."""

import csv
import os
from dataclasses import dataclass

from measure import cheapest, time_to

OURS = "canopy-fem"
END = 0.2  # [s] of every run


@dataclass
class Result:
    """What came of a scene."""

    spec: object
    runs: list
    agreement: list
    versions: dict
    absent: dict
    rounds: int
    elements: int  # springs and triangles


def seconds(t):
    """Three figures with a unit."""
    return f"{t:.3g} s" if t >= 0.9995 else f"{1e3 * t:.3g} ms"


def a_step(result, run):
    """Nanoseconds an element and step, where steps are fixed."""
    return f"{1e9 * run.median * run.value / (END * result.elements):.3g}" if run.kind == "step" else ""


def error_rows(result):
    """Every run, program by program, dearest last."""
    head = [
        "program",
        "method",
        "step or tolerance",
        "error",
        "largest",
        "CPU",
        "least",
        "most",
        "ns/element/step",
        "runs",
        "work",
    ]
    rows = []
    for run in sorted(result.runs, key=lambda r: (list(result.versions).index(r.peer), r.method, r.kind, -r.value)):
        told = [run.peer, run.method, run.pace]
        if run.done:
            spread = [seconds(t) for t in (run.median, min(run.seconds), max(run.seconds))]
            errors, each = [f"{run.error:.3e}", f"{run.error_max:.1e}"], a_step(result, run)
            rows.append([*told, *errors, *spread, each, str(len(run.seconds)), run.note])
        else:
            rows.append([*told, run.status, *[""] * 6, run.note])
    return head, rows + [[peer, "", "not run", *[""] * 7, why] for peer, why in result.absent.items()]


def target_rows(result):
    """Time to each accuracy, and how many times ours it is."""
    head = ["program"]
    targets = result.spec.targets
    for target in targets:
        head += [f"to {target:.2g}", "times ours", "by"]
    ours = {target: time_to(target, [r for r in result.runs if r.peer == OURS]) for target in targets}
    rows = []
    for peer in result.versions:
        row = [peer]
        for target in targets:
            found = time_to(target, [r for r in result.runs if r.peer == peer])
            if found is None:
                row += ["not reached", "", ""]
                continue
            ratio = f"{found[0] / ours[target][0]:.2f}" if ours[target] else ""
            row += [seconds(found[0]), ratio, f"{found[1].method}, {'near ' if found[2] else ''}{found[1].pace}"]
        rows.append(row)
    return head, rows + [[peer, "not run", *[""] * (3 * len(targets) - 1)] for peer in result.absent]


def whole_rows(result):
    """The cheapest run to every accuracy: its integration, its whole process, and what these are of ours."""
    head = ["to", "program", "by", "error", "integration", "times ours", "whole process", "times ours"]
    rows = []
    for target in result.spec.targets:
        best = {peer: cheapest(target, [r for r in result.runs if r.peer == peer]) for peer in result.versions}
        for peer, run in best.items():
            if run is None or not run.whole:
                continue
            shown = [f"{target:.2g}", peer, f"{run.method}, {run.pace}", f"{run.error:.1e}"]
            ours = best[OURS]
            for mine, yours in ((run.median, ours and ours.median), (run.whole_median, ours and ours.whole_median)):
                shown += [seconds(mine), f"{mine / yours:.2f}" if ours else ""]
            rows.append(shown)
    return head, rows


def losses(result):
    """A sentence for every accuracy at which another program needs less time."""
    told, targets = [], result.spec.targets
    for target in targets:
        ours = time_to(target, [r for r in result.runs if r.peer == OURS])
        for peer in result.versions:
            found = time_to(target, [r for r in result.runs if r.peer == peer])
            if found and (ours is None or found[0] < ours[0]):
                share = f"{found[0] / ours[0]:.2f} of our time" if ours else "which we do not reach"
                told.append(f"we lose at {target:.2g}: {peer} ({found[1].method}) takes {share}")
    return told or [f"no program here takes less time than ours at {', '.join(f'{t:.2g}' for t in targets)}"]


def aligned(head, rows):
    """A table in monospaced text."""
    widths = [max(len(row[i]) for row in [head, *rows]) if i < len(head) - 1 else 0 for i in range(len(head))]

    def line(row):
        return "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()

    return "\n".join(map(line, [head, *rows]))


def markdown(head, rows):
    """The same for a page."""

    def line(row):
        return "| " + " | ".join(row) + " |"

    return "\n".join([line(head), "|" + "---|" * len(head), *map(line, rows)])


def preface(result):
    """What was run and how far to trust the reference."""
    agreed = "; ".join(result.agreement) or "nobody checked it"
    versions = "; ".join(f"{peer}: {version}" for peer, version in result.versions.items())
    return [
        f"{result.spec.name}: {result.spec.told}; {END} s, 10 frames",
        f"at most {result.rounds} rounds, programs in turn; CPU: median processor time of the integration, one thread",
        f"reference: canopy-fem dop853 at 1e-11; {agreed}",
        f"versions: {versions}",
    ]


def text(result):
    """For the terminal."""
    parts = [*preface(result), "", aligned(*error_rows(result)), "", aligned(*target_rows(result)), ""]
    if any(run.whole for run in result.runs):
        parts += [aligned(*whole_rows(result)), ""]
    parts += [*losses(result), ""]
    return "\n".join(parts)


def write(results, out, head):
    """peers.md and peers.csv."""
    with open(os.path.join(out, "peers.md"), "w", encoding="utf-8") as page:
        page.write(f"# canopy-fem and what one could use instead\n\n{head}\n")
        for result in results:
            page.write(f"\n## {result.spec.name}\n\n" + "\n\n".join(preface(result)) + "\n\n")
            if any(run.whole for run in result.runs):
                page.write(markdown(*whole_rows(result)) + "\n\n")
            page.write(
                markdown(*target_rows(result)) + "\n\n" + "\n".join(f"* {row}" for row in losses(result)) + "\n\n"
            )
            page.write(f"![error against time]({result.spec.name}.svg)\n\n{markdown(*error_rows(result))}\n")
    with open(os.path.join(out, "peers.csv"), "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        head = "scene program version method kind value status error error_max"
        head += " cpu_seconds cpu_least cpu_most rounds whole_seconds note"
        rows.writerow(head.split())
        for r in results:
            for run in r.runs:
                shown = [""] * 7
                if run.done:
                    shown = [
                        run.error,
                        run.error_max,
                        run.median,
                        min(run.seconds),
                        max(run.seconds),
                        len(run.seconds),
                        run.whole_median,
                    ]
                what = [run.peer, r.versions[run.peer], run.method, run.kind, run.value, run.status]
                rows.writerow([r.spec.name, *what, *shown, run.note])
            for peer, why in r.absent.items():
                rows.writerow([r.spec.name, peer, "", "", "", "", "not run", *[""] * 7, why])


def diagram(result, out):
    """Error against time, a colour a program, a mark a method; without matplotlib there is none."""
    try:
        import matplotlib
    except ImportError:
        return
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "peers"
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(10, 7))
    marks = "osD^v<>Px*hXp8"
    for colour, peer in enumerate(result.versions):
        # An error of 1 is as good as no motion.
        mine = [r for r in result.runs if r.peer == peer and r.done and r.error < 1]
        for mark, key in zip(marks, dict.fromkeys((r.method, r.kind) for r in mine), strict=False):
            line = sorted((r for r in mine if (r.method, r.kind) == key), key=lambda r: -r.value)
            label = f"{peer}: {key[0]}{', adaptive' if key[1] == 'tol' else ''}"
            look = {
                "color": f"C{colour}",
                "lw": 2.2 if peer == OURS else 1.0,
                "ms": 5,
                "ls": "--" if key[1] == "tol" else "-",
            }
            axes.loglog([r.median for r in line], [r.error for r in line], marker=mark, label=label, **look)
    axes.set_xlabel("processor time of the integration [s]")
    axes.set_ylabel("error: distance from the reference over the motion, root mean squares [-]")
    axes.set_title(f"{result.spec.name}: {result.spec.told}", fontsize=10)
    axes.grid(True, which="major", alpha=0.4)
    axes.legend(fontsize=7, ncols=1, loc="center left", bbox_to_anchor=(1.01, 0.5))
    figure.savefig(os.path.join(out, f"{result.spec.name}.svg"), bbox_inches="tight", metadata={"Date": None})
    pyplot.close(figure)


def processor():
    """The processor's name, where the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as rows:
            return next(
                (row.split(":", 1)[1].strip() for row in rows if row.startswith("model name")), "unknown processor"
            )
    except OSError:
        return "unknown processor"
