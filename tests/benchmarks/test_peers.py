"""Ours against the peers on one question in one run: 4179 Toutatis, 1e5 samples over 100 polhode periods.

    python -m pytest -s tests/benchmarks/test_peers.py

Every peer at its most exact and set up beforehand; quaternions and rates; one thread.  Equal answers are
asserted first, then medians of calls: of each method in a row, as in `attitude cost`, and of both in turns,
where each finds the other's data in the caches.
"""

import statistics
from itertools import chain
from time import perf_counter

import numpy as np
import pytest

from attitude import Scene
from attitude.cost import AbsentError, InitialValueProblem
from attitude.cost.machine import processor, versions
from attitude.cost.methods import FAMILIES
from attitude.oracle import truth
from attitude.times.instants import as_instants

SAMPLES, PERIODS = 100_000, 100.0
COMPARED = 40  # samples, the last among them

# Family: how many times as long as ours a call takes at least, and the error, rad, that is still an answer.
PEERS = {"heyoka": (10.0, 1e-10), "orekit": (50.0, 1e-10), "dop853": (100.0, 1e-9)}
TIMES_MORE_EXACT = 100.0

MOTION = Scene.builtin("toutatis").motion()
PROBLEM = InitialValueProblem.of_motion(MOTION)
SECONDS = np.linspace(0.0, PERIODS * PROBLEM.unit, SAMPLES)
INSTANTS = as_instants(SECONDS, None)


def ours():
    ephemeris = MOTION.ephemeris(INSTANTS, rate=True)
    return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity


@pytest.fixture(scope="module")
def exact():
    """(index, attitude, rate) of some samples, to fifty digits."""
    others = np.random.default_rng(0).choice(SAMPLES - 1, COMPARED - 1, replace=False)
    body = [
        vector.tolist() for vector in (np.diag(PROBLEM.tensor), PROBLEM.angular_velocity, PROBLEM.attitude)
    ]
    return [(i, *truth.attitude_and_rate(*body, float(SECONDS[i]))) for i in (*others, SAMPLES - 1)]


def errors(answer, exact):
    """Largest attitude error, rad, and relative rate error."""
    attitudes, rates = answer
    return (
        max(truth.attitude_error(attitudes[i].tolist(), q) for i, q, _ in exact),
        max(truth.rate_error(rates[i].tolist(), rate) for i, _, rate in exact),
    )


def medians(calls, rounds, successive):
    """Median seconds of each, timed so many times in succession in so many rounds, after one call."""
    for call in calls:
        call()
    runs = [[[timed(call) for _ in range(successive)] for call in calls] for _ in range(rounds)]
    return [statistics.median(chain.from_iterable(columns)) for columns in zip(*runs, strict=True)]


def timed(call):
    start = perf_counter()
    call()
    return perf_counter() - start


@pytest.mark.parametrize("name", PEERS)
def test_ours_is_faster_and_more_exact(name, exact):
    slower, an_answer = PEERS[name]
    method = FAMILIES[name]()[-1]
    try:
        solve = method.prepare(PROBLEM)
    except AbsentError as absent:
        pytest.skip(str(absent))
    our_error, our_rate_error = errors(ours(), exact)
    error, rate_error = errors(solve(SECONDS), exact)
    assert max(our_error, our_rate_error) < 4e-15
    assert max(error, rate_error) < an_answer
    calls = ours, lambda: solve(SECONDS)
    our_seconds, seconds = medians(calls, rounds=3, successive=5)
    ours_in_turn, in_turn = medians(calls, rounds=7, successive=1)
    print(f"\n{processor()}, {', '.join(' '.join(pair) for pair in versions().items())}")
    for label, s, e in (("ours", our_seconds, our_error), (method.name, seconds, error)):
        print(f"{label:<30} {s / SAMPLES * 1e9:9.1f} ns a sample   {e:.1e} rad")
    print(f"{'ratio':<30} {seconds / our_seconds:9.1f}               {error / our_error:.0f}")
    print(f"{'ratio, calls in turns':<30} {in_turn / ours_in_turn:9.1f}")
    assert seconds >= slower * our_seconds
    assert in_turn >= slower * ours_in_turn
    assert error >= TIMES_MORE_EXACT * our_error
