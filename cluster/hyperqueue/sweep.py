"""Works a planned sweep off with HyperQueue: python sweep.py SWEEP [--workers N] [--server DIR].

Without --server a server and N workers of one core are started on this machine (`LocalCluster`); with it a running server is used, whose
workers may stand anywhere that the sweep's folder is seen. HyperQueue comes with `pip install hyperqueue`.
"""

import argparse
import contextlib
import os
import pathlib
import subprocess
import sys

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig


@contextlib.contextmanager
def client(server, workers):
    if server is not None:
        yield Client(server)
        return
    with LocalCluster() as cluster:
        for _ in range(workers):
            cluster.start_worker(WorkerConfig(cores=1))
        yield cluster.client()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("sweep", type=pathlib.Path)
    arguments.add_argument("--workers", type=int, default=os.cpu_count())
    arguments.add_argument("--server", type=pathlib.Path)
    given = arguments.parse_args()
    dpn = os.environ.get("DPN", "dpn")
    sweep = given.sweep.resolve()
    limits = subprocess.run([dpn, "sweep", "status", sweep, "--limits"], check=True, capture_output=True, text=True)
    shards = int(limits.stdout.split()[0])
    logs = sweep / "logs"
    logs.mkdir(exist_ok=True)
    job = Job()
    for shard in range(shards):
        job.program(
            [dpn, "sweep", "run", str(sweep), "--shard", str(shard), "--threads", "1"],
            cwd=sweep,
            stdout=logs / f"{shard}.out",
            stderr=logs / f"{shard}.err",
            name=f"shard {shard}",
        )
    with client(given.server, given.workers) as server:
        submitted = server.submit(job)
        done = server.wait_for_jobs([submitted], raise_on_error=False)
    if not done:
        sys.exit(f"some shards failed; `{dpn} sweep status {sweep}` says which and why, and this command goes on with them")


if __name__ == "__main__":
    main()
