"""A local cluster of two worker processes beside two threads, and a worker that is killed half-way.

    python tests/benchmarks/ensemble_cluster.py [--bodies 1000000] [--instants 100] [--turns 3]

Each of statistics and of a run to Zarr in turns by both; the cluster is running before.  Then the run once
more, one of the workers killed at half of it: every file has to be the same.
"""

from __future__ import annotations

import argparse
import filecmp
import os
import signal
import statistics
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from distributed import LocalCluster

from attitude import Scene
from attitude.ensemble import Ensemble

Engine = dict[str, Any]
THREADS: Engine = {"workers": 2}


def gather(ensemble: Ensemble, times: np.ndarray, engine: Engine) -> np.ndarray:
    return ensemble.statistics(times, **engine).covariance


def stored(ensemble: Ensemble, times: np.ndarray, engine: Engine) -> None:
    with tempfile.TemporaryDirectory() as folder:
        ensemble.run(times, Path(folder) / "out.zarr", **engine)


def compared(name: str, work: Callable[[Engine], Any], engines: dict[str, Engine], turns: int) -> None:
    """Medians of both, and the ratio of what they do in the same time."""
    taken: dict[str, list[float]] = {engine: [] for engine in engines}
    for _ in range(turns):
        for engine, options in engines.items():
            begun = perf_counter()
            work(options)
            taken[engine].append(perf_counter() - begun)
    threads, cluster = (statistics.median(taken[engine]) for engine in engines)
    print(
        f"{name:<12} threads {threads:6.2f} s, cluster {cluster:6.2f} s: {threads / cluster:.2f} x throughput"
    )


def killed(ensemble: Ensemble, times: np.ndarray, cluster: LocalCluster) -> None:
    victims: list[int] = []

    def kill(done: float) -> None:
        if done >= 0.5 and not victims:
            victims.append(cluster.workers[0].pid)
            os.kill(victims[0], signal.SIGKILL)

    with tempfile.TemporaryDirectory() as folder:
        places = [Path(folder) / "threads.zarr", Path(folder) / "cluster.zarr"]
        ensemble.run(times, places[0], **THREADS)
        result = ensemble.run(times, places[1], scheduler=cluster.scheduler_address, progress=kill)
        files = [[file for file in place.rglob("*") if file.is_file()] for place in places]
        names = [sorted(str(f.relative_to(p)) for f in found) for p, found in zip(places, files, strict=True)]
        same = names[0] == names[1] and filecmp.cmpfiles(*places, names[0], shallow=False)[0] == names[0]
        print(f"killed at half of {result.chunks} chunks: {len(names[0])} files, bits equal: {same}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--bodies", type=int, default=1_000_000)
    parser.add_argument("--instants", type=int, default=100)
    parser.add_argument("--turns", type=int, default=3)
    options = parser.parse_args()
    spreads = {"moments": "2 %", "angular_velocity": "0.1 deg/d", "attitude": "1 deg"}
    ensemble = Ensemble.sample(Scene.builtin("toutatis"), options.bodies, 7, **spreads)
    times = np.linspace(0.0, 40 * 86400.0, options.instants)
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:
        engines = {"threads": THREADS, "cluster": {"scheduler": cluster.scheduler_address}}
        first = [gather(ensemble, times, engine) for engine in engines.values()]  # kernels are loaded
        assert (first[0] == first[1]).all()
        compared("statistics", lambda engine: gather(ensemble, times, engine), engines, options.turns)
        compared("to Zarr", lambda engine: stored(ensemble, times, engine), engines, options.turns)
        killed(ensemble, times, cluster)


if __name__ == "__main__":
    main()
