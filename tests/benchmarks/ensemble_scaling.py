"""How long an ensemble takes on a cluster: a simulation, fed by what is measured here and checked against it.

    python tests/benchmarks/ensemble_scaling.py                 measure, check, and simulate (3 minutes)
    python tests/benchmarks/ensemble_scaling.py --no-measure    simulate with the figures below

Simulated are the tasks of `attitude.ensemble.cluster`: one client and scheduler, which submits a task and
takes its result, one after the other; threads of workers, which have two tasks each; disks, or one store that
all share.  docs/scaling.md says what came of it.
"""

from __future__ import annotations

import argparse
import heapq
import statistics
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from attitude import Scene
from attitude.ensemble import Ensemble, engine
from attitude.ensemble.cluster import MAX_TASKS_PER_BATCH, REMAINING_PER_BATCH, TASKS_PER_THREAD

SAMPLE_BYTES = 56  # quaternion and rate
SUM_BYTES = 240  # of a part's statistics, each instant
GRID = np.linspace(0.0, 40 * 86400.0, 1000)


@dataclass(frozen=True)
class Costs:
    """Measured here, docs/scaling.md; s, and bytes a second.

    body, sample : of a thread, for the constants of a body, and for one attitude of it, gathered
    stored : of a thread, for an attitude and rate in a chunk, disk left out
    part : of a thread, for each part besides
    task : of client and scheduler, for each task
    result : of client and scheduler, for each byte of a result
    start : of client and scheduler, once: to connect, and to send the work
    """

    body: float = 7.0e-6
    sample: float = 10e-9
    stored: float = 60e-9
    part: float = 0.5e-3
    task: float = 5e-3
    result: float = 1e-9
    start: float = 0.3


@dataclass(frozen=True)
class Cluster:
    """machines with threads each; disk : bytes/s that one machine writes, shared : that all do together.

    crowded : client and scheduler have no processor of their own, as in a check on one machine
    """

    machines: int
    threads: int
    disk: float = np.inf
    shared: float = np.inf
    crowded: bool = False


@dataclass(frozen=True)
class Job:
    """bodies by instants, in parts of so many bodies, gathered or stored."""

    bodies: int
    instants: int
    chunk: int
    stores: bool = False

    @property
    def parts(self) -> int:
        return -(-self.bodies // self.chunk)

    @property
    def bytes(self) -> float:
        return float(self.bodies) * self.instants * SAMPLE_BYTES if self.stores else 0.0


@dataclass(frozen=True)
class Outcome:
    """seconds : of all; busy : part of them that threads, and that client and scheduler, had work."""

    seconds: float
    tasks: int
    threads_busy: float
    client_busy: float


def simulate(job: Job, cluster: Cluster, costs: Costs) -> Outcome:
    """Tasks through one client, as the engine gives and takes them."""
    threads = cluster.machines * cluster.threads
    one = _part_seconds(job, cluster, costs)
    result = 0.0 if job.stores else costs.result * SUM_BYTES * job.instants  # of each part
    left, pending, tasks = job.parts, 0, 0
    free = [0.0] * threads  # when each thread has done what it was given
    done: list[tuple[float, int]] = []  # (when, parts) of tasks under way
    now, worked, taken = costs.start, 0.0, costs.start
    while left or pending:
        while left and pending < TASKS_PER_THREAD * threads:
            together = min(max(left // (REMAINING_PER_BATCH * threads), 1), MAX_TASKS_PER_BATCH, left)
            begun = max(heapq.heappop(free), now)
            end = begun + together * one
            heapq.heappush(free, end)
            heapq.heappush(done, (end, together))
            worked, left, pending, tasks = worked + together * one, left - together, pending + 1, tasks + 1
        when, together = heapq.heappop(done)
        own = costs.task + together * result
        now, taken, pending = max(now, when) + own, taken + own, pending - 1
    if cluster.crowded:  # what a task costs the client, it costs the worker too
        now = max(now, (worked + 2.0 * taken) / threads)
    return Outcome(now, tasks, worked / (threads * now), taken / now)


def _part_seconds(job: Job, cluster: Cluster, costs: Costs) -> float:
    """Of a thread, for a part of `chunk` bodies; what it writes goes through its share of the disks."""
    each = costs.body + job.instants * (costs.stored if job.stores else costs.sample)
    threads = cluster.machines * cluster.threads
    rate = min(cluster.disk / cluster.threads, cluster.shared / threads)
    written = job.chunk * job.instants * SAMPLE_BYTES if job.stores else 0.0
    return costs.part + job.chunk * each + written / rate


# -- measured here --------------------------------------------------------------------------------------


def ensemble(bodies: int) -> Ensemble:
    spreads = {"moments": "2 %", "angular_velocity": "0.1 deg/d", "attitude": "1 deg"}
    return Ensemble.sample(Scene.builtin("toutatis"), bodies, 7, **spreads)


def timed(work, repeats=3):
    """Median seconds."""
    taken = []
    for _ in range(repeats):
        begun = perf_counter()
        work()
        taken.append(perf_counter() - begun)
    return statistics.median(taken)


def nothing(part, size=0):
    return bytes(size)


def drained(work, parts, address):
    for _ in engine.mapped(work, parts, address):
        pass


def measured(address: str, bodies: int = 200_000) -> Costs:
    """Of workers, side by side, by long parts; of client and scheduler, by tasks that do nothing."""
    some = ensemble(bodies)
    long = [(a, min(a + 10_000, bodies)) for a in range(0, bodies, 10_000)]

    def of(count):
        return 2.0 * timed(partial(drained, _gathering(some, GRID[:count]), long, address))

    of(10)
    few, many = of(10), of(1000)
    sample = (many - few) / (990.0 * bodies)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "a.zarr"
        stored = [timed(lambda n=n: some.run(GRID[:n], place, overwrite=True, workers=1)) for n in (10, 200)]
    parts = list(range(2000))
    start = timed(partial(drained, nothing, parts[:2], address))
    plain = timed(partial(drained, nothing, parts, address)) / 2000
    heavy = timed(partial(drained, partial(nothing, size=1_000_000), parts[:400], address)) / 400
    return Costs(
        body=few / bodies - 10 * sample,
        sample=sample,
        stored=(stored[1] - stored[0]) / (190.0 * bodies),
        part=_of_a_part(some),
        task=(plain * 2000 - start) / _tasks(2000, 2),
        result=max(heavy - plain, 0.0) / 1e6,
        start=start,
    )


def _of_a_part(some: Ensemble) -> float:
    """What a part takes besides its bodies: many short ones beside one of as many bodies."""
    work, bodies, size = _gathering(some, GRID[:10]), 16384, 64
    whole = timed(lambda: work((0, bodies)))
    short = timed(lambda: [work((a, a + size)) for a in range(0, bodies, size)])
    return (short - whole) / (bodies / size)


def _tasks(parts: int, threads: int) -> int:
    return simulate(Job(parts, 0, 1), Cluster(1, threads), Costs()).tasks


def checked(address: str, costs: Costs) -> None:
    """What a cluster of two processes takes, beside what is simulated for it."""
    print(f"{'bodies x instants, in parts of':<36} {'measured':>9} {'simulated':>9}")
    for bodies, instants, chunk in (
        (200_000, 10, 64),
        (200_000, 10, 256),
        (400_000, 100, 1024),
        (400_000, 100, 4096),
    ):
        some = ensemble(bodies)
        work = _gathering(some, GRID[:instants])
        parts = [(a, min(a + chunk, bodies)) for a in range(0, bodies, chunk)]
        seconds = timed(partial(drained, work, parts, address))
        told = simulate(Job(bodies, instants, chunk), Cluster(1, 2, crowded=True), costs).seconds
        print(f"{f'{bodies} x {instants}, {chunk}':<36} {seconds:7.2f} s {told:7.2f} s")


def _gathering(some: Ensemble, times: np.ndarray):
    from attitude.ensemble.accumulation import MomentAccumulation

    instants = some.instants(times)
    reference = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (len(times), 4)).copy()
    return MomentAccumulation(some.source, some.scene, None, instants, reference)


# -- 1e9 bodies -------------------------------------------------------------------------------------------


def foreseen(costs: Costs) -> None:
    """A thousand million bodies at a thousand instants, on a hundred machines."""
    print("\n1e9 bodies x 1000 instants                 time   tasks  threads busy  client busy")
    for machines, threads in ((100, 2), (100, 16), (100, 64)):
        for chunk in (1024, 4096, 16384, 65536):
            cluster = Cluster(machines, threads)
            _told(f"{machines} x {threads}, gathered, {chunk}", Job(10**9, 1000, chunk), cluster, costs)
    for name, cluster in (
        ("each to a disk of its own, 1 GB/s", Cluster(100, 16, disk=1e9)),
        ("all to one store, 10 GB/s", Cluster(100, 16, shared=1e10)),
    ):
        for chunk in (512, 4096, 16384):
            _told(f"100 x 16, {name}, {chunk}", Job(10**9, 1000, chunk, True), cluster, costs)


def _told(name: str, job: Job, cluster: Cluster, costs: Costs) -> None:
    found = simulate(job, cluster, costs)
    busy = f"{found.threads_busy:6.0%} {found.client_busy:6.0%}"
    print(f"{name:<52} {found.seconds:8.0f} s {found.tasks:8d} {busy}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--no-measure", action="store_true")
    options = parser.parse_args()
    costs = Costs()
    if not options.no_measure:
        from distributed import LocalCluster

        with LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
        ) as cluster:
            address = cluster.scheduler_address
            drained(_gathering(ensemble(5000), GRID[:10]), [(i, i + 10) for i in range(0, 5000, 10)], address)
            costs = measured(address)
            print(costs)
            checked(address, costs)
    foreseen(costs)


if __name__ == "__main__":
    main()
