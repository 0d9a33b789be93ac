#!/usr/bin/env python3
"""Runs the shards of a planned study on a HyperQueue cluster of this machine, then joins them.

    pip install hyperqueue
    canopy-fem tradeoff CASE --plan --out study
    python examples/sweeps/hyperqueue_local.py canopy-fem study 8

A task that is killed is started again by HyperQueue, and goes on where the run it was making had come to.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="canopy-fem, by name or path")
    parser.add_argument("out", type=Path, help="folder with the plan")
    parser.add_argument("shards", type=int, help="number of tasks")
    parser.add_argument("--cores", type=int, default=None, help="cores of the worker [default: all]")
    given = parser.parse_args()

    study = [given.program, "tradeoff", "--out", str(given.out)]
    logs = given.out / "tradeoff" / "logs"
    logs.mkdir(parents=True, exist_ok=True)
    worker = WorkerConfig(cores=given.cores)
    # server_dir is passed on as text: HyperQueue 0.27 takes no Path there.
    with tempfile.TemporaryDirectory() as server, LocalCluster(server_dir=server, worker_config=worker) as cluster:
        client = cluster.client()
        job = Job(default_workdir=Path.cwd(), max_fails=None)
        for shard in range(1, given.shards + 1):
            part = f"{shard}/{given.shards}"
            job.program(
                [*study, "--shard", part, "--quiet"],
                name=f"shard-{shard}",
                stdout=str((logs / f"{shard}.out").resolve()),
                stderr=str((logs / f"{shard}.err").resolve()),
            )
        submitted = client.submit(job)
        if not client.wait_for_jobs([submitted], raise_on_error=False):
            print(f"some shards failed; see {logs}", file=sys.stderr)
            return 1
    return subprocess.run([*study, "--merge"], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
