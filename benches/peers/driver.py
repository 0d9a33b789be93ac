"""Runs the scenes through all programs in turn and prints what came of it; started by `run`."""

import argparse
import itertools
import json
import os
import platform
import resource
import subprocess
import sys
import time

import numpy as np
import report
from catalogue import OURS, PEERS, SCENES, TARGET, name_of_case, whole_command
from measure import Reference, Run, cheapest
from peer_common import read_scene
from setup import MISSING, ROOT
from workers import SINGLE, Lost, Worker

REFERENCES = [("canopy-fem", "dop853", 1e-11), ("scipy", "DOP853", 1e-11), ("sundials", "erk8", 1e-11)]
# [s] A run that takes longer is made in so many rounds only.
REPEATS = [(2.0, 1), (0.7, 2), (0.2, 3)]


def arguments():
    """The command line."""
    told = "Error against processor time of canopy-fem and of what one could use instead."
    parser = argparse.ArgumentParser(prog="benches/peers/run", description=told)
    parser.add_argument("--quick", action="store_true", help="the first scene, every second step, two rounds")
    parser.add_argument(
        "--scene", help="scenes, parted by commas: " + ", ".join(s.name + " (else left out)" * s.asked for s in SCENES)
    )
    parser.add_argument(
        "--only", help="programs, parted by commas, besides canopy-fem: " + ", ".join(p.name for p in PEERS[1:])
    )
    parser.add_argument(
        "--whole",
        action="store_true",
        help="time whole processes too: the cheapest run to every accuracy, as a process of its own",
    )
    parser.add_argument("--rounds", type=int, help="times every run is made, in turn with all others (default 5)")
    parser.add_argument(
        "--limit", type=float, default=10.0, help="[s] a run may take (default 10); what would take longer is not run"
    )
    parser.add_argument(
        "--out", default=str(ROOT / "out" / "peers"), help="folder for tables and diagrams (default out/peers)"
    )
    args = parser.parse_args()
    scenes = args.scene or (SCENES[0].name if args.quick else None)
    args.scenes = [s for s in SCENES if (s.name in scenes.split(",") if scenes else not s.asked)]
    args.peers = [p for p in PEERS if args.only is None or p.name in ["canopy-fem", *args.only.split(",")]]
    for asked, known in ((args.scene, SCENES), (args.only, PEERS)):
        unknown = set(asked.split(",") if asked else []) - {thing.name for thing in known}
        if unknown:
            parser.error("unknown: " + ", ".join(sorted(unknown)))
    args.rounds = args.rounds or (2 if args.quick else 5)
    return args


class Bench:
    """One scene with the programs that can run it."""

    def __init__(self, spec, args, missing):
        # Other work on the machine makes the clock run faster than the processor.
        self.spec, self.limit, self.workers, self.absent = spec, 4 * args.limit, {}, {}
        self.file, self.frames = TARGET / f"{spec.name}.txt", TARGET / "frames.bin"
        case = [name_of_case(spec), *spec.overrides]
        exported = subprocess.run([TARGET / OURS, "export", *case], check=True, capture_output=True, text=True)
        self.file.write_text(exported.stdout)
        self.scene = read_scene(self.file)
        for peer in args.peers:
            lacking = [missing[need] for need in peer.needs if need in missing]
            if lacking:
                self.absent[peer.name] = lacking[0]
            elif lacking := spec.has - peer.knows:
                self.absent[peer.name] = "its model here has no " + ", no ".join(sorted(lacking))
            elif not peer.runs(spec):
                self.absent[peer.name] = "every run would take minutes"
            else:
                scene = case if peer.name == "canopy-fem" else [str(self.file)]
                self.add(peer, Worker([*peer.command, *scene], TARGET / f"{peer.name}.log", peer.environment))

    def add(self, peer, worker):
        try:
            worker.start()
            self.workers[peer.name] = worker
        except Lost as why:
            self.absent[peer.name] = str(why)

    def solve(self, peer, method, kind, value):
        """One run and its frames."""
        self.frames.unlink(missing_ok=True)
        try:
            status, seconds, note = self.workers[peer].run(method, kind, value, self.frames, self.limit)
        except Lost as why:
            return "too slow" if "no answer" in str(why) else "failed", None, str(why), np.zeros(0)
        frames = np.fromfile(self.frames, "<f8") if self.frames.exists() else np.zeros(0)
        return status, seconds, note, frames

    def reference(self):
        """Our tightest solution, and how far those of others are from it."""
        told, found = [], None
        for peer, method, tolerance in REFERENCES:
            if peer not in self.workers:
                continue
            status, _, note, frames = self.solve(peer, method, "tol", tolerance)
            if found is None:
                if status != "done":
                    sys.exit(f"{self.spec.name}: no reference: {note}")
                found = Reference(frames, self.scene.x0, ~self.scene.fixed)
            else:
                away = (
                    f"is {found.errors(frames)[0]:.1e} of the motion away"
                    if status == "done"
                    else f"gave no solution ({note})"
                )
                told.append(f"{peer} {method} {away}")
        return found, told

    def stop(self):
        for worker in self.workers.values():
            worker.stop()


def plan(bench, args):
    """Every run, program by program in turn, so that what disturbs the machine disturbs all alike."""
    lists = []
    for peer in args.peers:
        if peer.name in bench.workers:
            runs = [
                (m, kind, v) for m, kind, values in peer.runs(bench.spec) for v in values[:: 2 if args.quick else 1]
            ]
            lists.append([Run(peer.name, *run) for run in runs])
    return [run for turn in itertools.zip_longest(*lists) for run in turn if run is not None]


def progress(text):
    """On a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)


def expected(run, runs):
    """[s] What a run will take, from the one before with the same method; 0 if there is none."""
    before = [r for r in runs[: runs.index(run)] if (r.peer, r.method, r.kind) == (run.peer, run.method, run.kind)]
    if not before:
        return 0.0
    last = before[-1]
    if last.status == "too slow" or last.status == "not run":
        return float("inf")
    return last.median * last.value / run.value if last.seconds and run.kind == "step" else 0.0


def due(run, runs, number, args):
    """Whether a run is made in this round."""
    if number == 0:
        if (seconds := expected(run, runs)) > args.limit:
            run.note = "would take " + (f"about {seconds:.0f} s" if seconds < float("inf") else "longer than a run may")
            return False
        return True
    return run.status == "done" and all(run.median <= least or number < times for least, times in REPEATS)


def time_whole(bench, runs, args):
    """The cheapest run of every program to every accuracy as a process of its own, all in turn."""
    chosen = {}
    for peer in args.peers:
        mine = [r for r in runs if r.peer == peer.name]
        for run in filter(None, (cheapest(target, mine) for target in bench.spec.targets)):
            chosen[id(run)] = (run, *whole_command(peer, bench.spec, run, TARGET))
    environment = os.environ | SINGLE
    for number in range(args.rounds):
        for run, command, line in chosen.values():
            if number and run.whole[0] > REPEATS[0][0]:
                continue
            peer = next(p for p in args.peers if p.name == run.peer)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            process = {"input": line, "env": environment | peer.environment, "cwd": TARGET}
            subprocess.run(command, **process, text=True, check=True, capture_output=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            run.whole.append(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)


def compare(spec, args, missing):
    """All rounds of a scene."""
    bench = Bench(spec, args, missing)
    try:
        reference, agreement = bench.reference()
        runs = plan(bench, args)
        for number in range(args.rounds):
            began = time.monotonic()
            for count, run in enumerate(runs):
                if not due(run, runs, number, args):
                    continue
                progress(f"  {spec.name}, round {number + 1}: {count + 1} of {len(runs)}, {run.peer} {run.method}")
                status, seconds, note, frames = bench.solve(run.peer, run.method, run.kind, run.value)
                run.status, run.note = status, note
                if status == "done":
                    run.seconds.append(seconds)
                    run.error, run.error_max = reference.errors(frames)
            progress("")
            print(
                f"  {spec.name}: round {number + 1} of {args.rounds}, {time.monotonic() - began:.0f} s",
                file=sys.stderr,
                flush=True,
            )
        if args.whole:
            time_whole(bench, runs, args)
        versions = {name: worker.version for name, worker in bench.workers.items()}
        elements = len(bench.scene.ends) + len(bench.scene.triangles) + len(bench.scene.membranes)
        return report.Result(spec, runs, agreement, versions, bench.absent, args.rounds, elements)
    finally:
        bench.stop()


def main():
    args = arguments()
    missing = json.loads(MISSING.read_text()) if MISSING.exists() else {}
    os.makedirs(args.out, exist_ok=True)
    started = time.monotonic()
    command = "benches/peers/run " + " ".join(sys.argv[1:])
    results = []
    for spec in args.scenes:
        result = compare(spec, args, missing)
        results.append(result)
        print(report.text(result), flush=True)
        report.diagram(result, args.out)
    head = f"`{command.strip()}` on {platform.machine()}, {report.processor()}, Python {platform.python_version()}"
    report.write(results, args.out, head)
    print(
        f"written to {os.path.relpath(args.out)}: peers.md, peers.csv and a diagram a scene;"
        f" {time.monotonic() - started:.0f} s in all"
    )


if __name__ == "__main__":
    main()
