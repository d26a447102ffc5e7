"""Random numbers of each body: those of numpy's generator at the documented counters, in any part."""

import numpy as np
import pytest
from mpmath import mp
from scipy.special import ndtri

from attitude import InputError
from attitude.ensemble.sources.dispersion import Sampled
from tests.ensemble.scenes import PLATE, scene

# Deviates about zero, of a spread of one, come out as they are; moments of one part in a million as
# 1 + 1e-6 n, whose rounding is 1.1e-16 of one.
EXACT, ROUNDED = 4e-15, 4e-10
SEED = 2**127 + 12345


def deviates(counter, seed=SEED):
    """Three normal deviates of numpy's words at a counter, by scipy's quantiles."""
    words = np.random.Philox(key=seed, counter=counter).random_raw(3)
    return ndtri(((words >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53)


def at_rest(**changes):
    return scene(angular_velocity={"value": [0, 0, 0], "unit": "rad/s"}, **changes)


@pytest.mark.parametrize("body", [0, 1, 4095, 4096, 2**33 - 1])
def test_rates_are_numpys_numbers_at_the_documented_counter(body):
    drawn = Sampled(at_rest(), 2**33, SEED, angular_velocity=1.0).part(body, body + 1)
    expected = deviates(3 * body + 1)
    assert np.abs(drawn.angular_velocity[0] / expected - 1.0).max() <= EXACT


@pytest.mark.parametrize("body", [0, 77, 2**32])
def test_moments_are_numpys_numbers_at_the_documented_counter(body):
    drawn = Sampled(scene(), 2**33, SEED, moments=1e-6).part(body, body + 1)
    actual = (drawn.body.moments[0] / [1.0, 1.6, 2.1] - 1.0) / 1e-6
    assert np.abs(actual - deviates(3 * body)).max() <= ROUNDED


def test_attitudes_are_numpys_numbers_at_the_documented_counter():
    identity = scene(attitude={"quaternion": [1, 0, 0, 0], "order": "wxyz"})
    drawn = Sampled(identity, 10, SEED, attitude=[1e-3, 2e-3, 3e-3]).part(5, 6)
    w, *vector = drawn.attitude[0]
    angle = 2 * np.arctan2(np.linalg.norm(vector), w)
    actual = np.array(vector) / np.linalg.norm(vector) * angle / [1e-3, 2e-3, 3e-3]
    assert np.abs(actual - deviates(3 * 5 + 2)).max() <= 1e-12


def test_moments_that_no_body_has_are_drawn_again_from_the_next_range():
    drawn = Sampled(scene(body=PLATE), 400, SEED, moments=0.3).part(0, 400)
    attempts = []
    for body, moments in enumerate(drawn.body.moments):
        for attempt in range(100):
            tried = np.array([1.0, 1.0, 2.0]) * (1.0 + 0.3 * deviates(3 * body + attempt * 2**192))
            if (tried > 0.0).all() and (2.0 * tried <= tried.sum()).all():
                break
        attempts.append(attempt)
        assert np.abs(moments / tried - 1.0).max() <= 1e-14
    assert max(attempts) >= 5
    assert 0.3 < np.mean(np.array(attempts) == 0) < 0.7


def test_deviates_are_quantiles_to_the_last_digits():
    """Against the inverse of the distribution to 30 digits, in the centre and both tails of many words."""
    drawn = Sampled(at_rest(), 30_000, 3, angular_velocity=1.0).part(0, 30_000).angular_velocity
    rows = np.argsort(np.abs(drawn[:, 0]))
    with mp.workdps(30):
        for row in [*rows[:20], *rows[10_000:10_020], *rows[-20:]]:
            (word,) = np.random.Philox(key=3, counter=3 * int(row) + 1).random_raw(1)
            p = (mp.mpf(int(word) >> 11) + mp.mpf(0.5)) / 2**53
            true = mp.sqrt(2) * mp.erfinv(2 * p - 1)
            assert abs(drawn[row, 0] / true - 1) <= 1e-15 * max(1, abs(true) ** -1), row


@pytest.mark.parametrize("seed", [-1, 2**128, 1.0, "7", None, True])
def test_seed_that_is_none_is_refused(seed):
    with pytest.raises(InputError, match=r"seed: a whole number from 0 to 2\*\*128 - 1; got"):
        Sampled(scene(), 10, seed)


def test_seeds_and_bodies_are_independent():
    first = Sampled(at_rest(), 20_000, 1, angular_velocity=1.0).part(0, 20_000).angular_velocity
    second = Sampled(at_rest(), 20_000, 2, angular_velocity=1.0).part(0, 20_000).angular_velocity
    both = np.concatenate([first, second, np.roll(first, 1, axis=0)], axis=1)
    correlation = np.corrcoef(both.T) - np.eye(9)
    assert np.abs(correlation).max() < 5 / np.sqrt(20_000)
