"""Figures of docs/fit.md: `python -m tests.benchmarks.fit_truth speed`, `... coverage`, `... gaps`."""

import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

from attitude import Ephemeris, RigidBody, TorqueFreeMotion, fit
from attitude.estimation.gaps import fill_gaps
from attitude.frames import rotations
from attitude.times.instants import Instants
from tests.estimation import simulated
from tests.estimation.test_fit import pulls

SETS, ATTITUDES = 500, 100_000


def speed():
    """Seconds of processor time for 100,000 attitudes, from a start and without one."""
    truth = simulated.motion()
    observed = simulated.attitudes(truth, np.random.default_rng(1), np.arange(ATTITUDES) * 1.0, 1e-4)
    near = simulated.motion(rate=(0.02, -0.03, 0.05 + 1e-8))
    cases = {"from a start": {"start": near}, "without": {"body": RigidBody((10.0, 13.0, 17.1))}}
    for name, options in cases.items():
        fit(observed[:1000], **options)
        begun, wall = time.process_time(), time.perf_counter()
        fit(observed, **options)
        print(f"{name}: {time.process_time() - begun:.2f} s of processor, {time.perf_counter() - wall:.2f} s")


def coverage():
    """Chi-square, and how many estimates lie within one standard deviation, of random bodies and motions."""
    random, within, sums, degrees = np.random.default_rng(2), [], 0.0, 0
    for index in range(SETS):
        moments = np.sort(random.uniform(1.0, 2.0, 3)) * (1.0, 1.0, 1.0)
        moments[2] = min(moments[2], 0.95 * (moments[0] + moments[1]))
        rate = random.normal(size=3) * 0.05
        truth = TorqueFreeMotion(RigidBody(moments), random_attitude(random), rate, order="wxyz")
        observed = [simulated.attitudes(truth, random), simulated.rates(truth, random)][: 1 + index % 2]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = fit(observed, start=truth)
        within.append(np.abs(pulls(result, truth)) < 1.0)
        sums, degrees = sums + result.chi_square, degrees + result.degrees_of_freedom
    inside = np.concatenate(within)
    print(f"{SETS} sets: chi-square {sums:.0f} of {degrees} +- {np.sqrt(2.0 * degrees):.0f}")
    print(
        f"within 1 sigma: {100 * inside.mean():.1f} % of {inside.size} (68.3 +- {46.5 / np.sqrt(SETS):.1f})"
    )


def gaps():
    """How many gaps of a free motion with Gaussian errors are doubted, by the attitudes on each side."""
    truth, errors = simulated.motion(), np.random.default_rng(3)
    with tempfile.TemporaryDirectory() as folder:
        for before, after in ((100, 100), (16, 100), (4, 100), (2, 100), (1, 100), (10, 10), (3, 3)):
            seconds = np.concatenate([np.arange(1.0 - before, 1.0), 60.0 + np.arange(after)]) * 2.0
            is_doubted = []
            for _ in range(SETS):
                q = simulated.attitudes(truth, errors, seconds, 1e-4).attitude
                path = Path(folder) / "gappy.csv"
                Ephemeris(rotations.sign_continuous(q), Instants(seconds, None, None), "ICRF").write(path)
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    _, (gap,) = fill_gaps(Ephemeris.read(path), truth.body)
                is_doubted.append(bool(gap.doubts))
            print(f"{before} and {after} attitudes: {sum(is_doubted)} of {SETS} doubted")


def random_attitude(random):
    q = random.normal(size=4)
    return q / np.sqrt(q @ q)


if __name__ == "__main__":
    {"speed": speed, "coverage": coverage, "gaps": gaps}[sys.argv[1]]()
