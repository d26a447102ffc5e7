"""What statistics of ensembles have to reach: time against that of the plain motion, memory, cost by size.

    python -m pytest -o addopts= -s tests/benchmarks/test_ensemble.py
    python tests/benchmarks/test_ensemble.py 1e5 1e6 1e7        time a body and memory, each in a new process

Answers are asserted equal first; times are medians of runs in turns.  The rows fail on a busy machine: run
them alone.
"""

import os
import resource
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter, process_time

import numpy as np
import pytest
from test_speed import in_turns, report

from attitude import Scene, TorqueFreeMotion
from attitude.ensemble import Ensemble

TIMES = np.linspace(0.0, 40 * 86400.0, 100)
SPREADS = {"moments": "2 %", "angular_velocity": "0.1 deg/d", "attitude": "1 deg"}
BLOCK = 4096
GIB = 2**30


def ensemble(count):
    return Ensemble.sample(Scene.builtin("toutatis"), count, 7, **SPREADS)


def motion(states):
    return TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")


def plainly(blocks, threads):
    """Attitudes of all bodies, block by block, each dropped."""
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(lambda states: motion(states).at(TIMES) and None, blocks):
            pass


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core")
def test_statistics_against_the_plain_motion_of_as_many(benchmark):
    """1e6 bodies at 100 instants, drawn, moved, gathered on two threads; the plain motion is given states."""
    count = 1_000_000
    bodies = ensemble(count)
    few = ensemble(1000)
    quaternions = motion(few.states()).at(TIMES).quaternion("wxyz")
    mean = np.linalg.eigh(np.einsum("nmi,nmj->mij", quaternions, quaternions))[1][..., -1]
    assert np.abs(np.abs((few.statistics(TIMES).mean * mean).sum(axis=1)) - 1.0).max() <= 1e-14
    blocks = [bodies.states(a, min(a + BLOCK, count)) for a in range(0, count, BLOCK)]
    assert np.array_equal(blocks[0].attitude[:1000], few.states().attitude)
    ours, plain = in_turns(lambda: bodies.statistics(TIMES, workers=2), lambda: plainly(blocks, 2), repeats=5)
    benchmark.pedantic(lambda: bodies.statistics(TIMES, workers=2), rounds=1)
    print(f"\n    {ours / count * 1e6:.3g} us a body, plain {plain / count * 1e6:.3g} us")
    report(benchmark, ours / plain, "<= 1.3 x the plain motion")
    assert ours <= 1.3 * plain


def test_drawing_bodies(benchmark):
    bodies = ensemble(100_000)

    def draw():
        for first in range(0, bodies.size, BLOCK):
            bodies.states(first, min(first + BLOCK, bodies.size))

    (seconds,) = in_turns(draw)
    benchmark.pedantic(draw, rounds=3)
    report(benchmark, seconds / bodies.size * 1e6, "<= 0.5 us a body")
    assert seconds <= 0.5e-6 * bodies.size


def measured(count):
    """(s, s of processors, bytes at the peak) of statistics in a process of their own."""
    run = subprocess.run(
        [sys.executable, __file__, "one", str(count)], capture_output=True, text=True, check=True
    )
    seconds, busy, size = run.stdout.split()
    return float(seconds), float(busy), int(size)


def test_memory_does_not_grow_with_bodies(benchmark):
    sizes = {count: measured(count)[2] for count in (10_000, 100_000)}
    benchmark.pedantic(lambda: measured(10_000), rounds=1)
    print("\n   ", {count: f"{size / 2**20:.0f} MiB" for count, size in sizes.items()})
    report(benchmark, sizes[100_000] / GIB, "<= 1 GiB")
    assert sizes[100_000] <= min(GIB, sizes[10_000] + 64 * 2**20)


def one(count):
    """Print seconds, and those of processors, after a warm-up, and the greatest memory."""
    ensemble(10_000).statistics(TIMES, workers=2)
    bodies = ensemble(count)
    runs = []
    for _ in range(max(1, min(9, 3_000_000 // count))):  # of short ones the median
        begun, busy = perf_counter(), process_time()
        bodies.statistics(TIMES, workers=2)
        runs.append((perf_counter() - begun, process_time() - busy))
    seconds, processors = sorted(runs)[len(runs) // 2]
    print(seconds, processors, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)


def table(counts):
    for count in counts:
        seconds, busy, size = measured(count)
        time = f"{seconds / count * 1e6:.3f} us a body ({busy / count * 1e6:.3f} of processors)"
        print(f"{count:10d} bodies: {time}, {size / 2**20:.0f} MiB", flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "one":
        one(int(sys.argv[2]))
    else:
        table([int(float(each)) for each in sys.argv[1:]])
