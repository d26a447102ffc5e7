"""Windows: a day's search, and 1,000 random tumblers against a scan at 1/1000 of their shortest period.

python -m tests.benchmarks.windows [bodies]
"""

from __future__ import annotations

import sys
import time

import astropy.units as u
import numpy as np
from scipy.spatial.transform import Rotation

from attitude import RigidBody, TorqueFreeMotion
from attitude.windows import angle

PERIODS, PER_PERIOD = 20, 1000
DAY = 86400.0


def main(bodies: int = 1000) -> None:
    """Print what was found, and what was missed."""
    one_rpm = TorqueFreeMotion(RigidBody([1.0, 1.6, 2.1]), [1, 0, 0, 0], [0.02, 0.08, 0.06], order="wxyz")
    condition = angle("z", to=[1.0, 2.0, 3.0]) < 10 * u.deg
    seconds = []
    for _ in range(9):
        begun = time.perf_counter()
        windows = one_rpm.crossings(condition, 0.0, DAY)
        seconds.append(time.perf_counter() - begun)
    print(f"a day at 1 rpm: {len(windows)} windows, median {np.median(seconds):.3f} s")
    counts = np.array([counted(seed) for seed in range(bodies)])
    found, scanned, missed, apart = counts.sum(axis=0)
    print(f"{bodies} tumblers, {PERIODS} periods each: {found:.0f} windows, {scanned:.0f} of the scan")
    print(f"instants of the scan that the windows miss: {missed:.0f}, or wrongly hold: {apart:.0f}")


def counted(seed: int) -> tuple[int, int, int, int]:
    """Windows found and scanned; instants of the scan outside the windows, and wrongly inside."""
    rng = np.random.default_rng(seed)
    moments = np.sort(rng.uniform(1.0, 2.0, 3))
    rate = rng.normal(size=3) * 10.0 ** rng.uniform(-4, 0)
    motion = TorqueFreeMotion(RigidBody(moments), Rotation.random(rng=rng), rate)
    target, axis = rng.normal(size=3), rng.normal(size=3)
    limit = 10.0 ** rng.uniform(-2.0, np.log10(np.pi))
    span = PERIODS * 2.0 * np.pi / float(np.sqrt(rate @ rate))
    t = np.linspace(0.0, span, PERIODS * PER_PERIOD + 1)
    holds = motion.at(t).angle(axis, target) < limit
    windows = motion.crossings(angle(axis, to=target) < limit, 0.0, span)
    begun = np.searchsorted(windows.start.seconds, t, side="right")
    inside = begun > np.searchsorted(windows.stop.seconds, t, side="left")
    runs = np.count_nonzero(np.diff(np.concatenate([[False], holds])) & holds)
    return len(windows), runs, int((holds & ~inside).sum()), int((inside & ~holds).sum())


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
