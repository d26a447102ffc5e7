"""Constants of many bodies in vector lanes: the same as of each alone, and as the truth.

That attitudes are right is shown elsewhere (test_against_truth.py): every motion passes through the lanes.
Here: bits that may not depend on a body's company, and the edges at which a body is left to the other kernel.
"""

import numpy as np
import pytest
from mpmath import mp

from attitude import RigidBody, TorqueFreeMotion
from attitude.kernels.layout import Route
from attitude.oracle.exact import fractions
from attitude.oracle.theta import motion as truth_of
from attitude.rigid_body.constants_of_motion import Batch

RNG = np.random.default_rng(20261129)
N = 150


def moments_of(n):
    moments = RNG.uniform(0.2, 2.0, (n, 3))
    others = moments.sum(axis=1, keepdims=True) - moments
    return np.minimum(moments, 0.999 * others)


def rotated(moments):
    axes = np.linalg.qr(RNG.normal(size=(len(moments), 3, 3)))[0]
    tensors = axes @ (moments[:, :, None] * np.swapaxes(axes, 1, 2))
    return 0.5 * (tensors + np.swapaxes(tensors, 1, 2))


def states(n):
    """Attitudes and rates: plain, beside an axis, about one, at rest, beside the separatrix."""
    attitudes, rates = RNG.normal(size=(n, 4)), RNG.normal(size=(n, 3))
    beside = np.where(np.arange(3) == RNG.integers(0, 3, (n, 1)), 1.0, 10.0 ** -RNG.uniform(1, 30, (n, 1)))
    rates[::3] *= beside[::3]
    rates[::10, 1:] = 0.0
    rates[::17] = 0.0
    return attitudes / np.linalg.norm(attitudes, axis=1, keepdims=True), rates


def bodies(kind):
    moments = np.sort(moments_of(N), axis=1)
    if kind == "symmetric":
        moments[::2, 1], moments[1::2, 1] = moments[::2, 0], moments[1::2, 2]
    if kind == "nearly symmetric":
        moments[:, 1] = moments[:, 0] * (1.0 + 10.0 ** -RNG.uniform(3, 16, N))
        moments[:, 2] = np.maximum(moments[:, 2], moments[:, 1])
        moments[:, 2] = np.minimum(moments[:, 2], 1.999 * moments[:, 0])
    if kind == "needles":
        moments[:, 0] *= 10.0 ** -RNG.uniform(1, 14, N)
        moments[:, 2] = moments[:, 1] * (1.0 + 0.5 * moments[:, 0])
    if kind == "nearly spheres":
        moments = 1.0 + 10.0 ** -RNG.uniform(2, 16, (N, 1)) * RNG.uniform(size=(N, 3))
    return RigidBody(moments, physical=False) if kind != "tensors" else RigidBody(rotated(moments))


KINDS = ("plain", "tensors", "symmetric", "nearly symmetric", "needles", "nearly spheres")


@pytest.mark.parametrize("kind", KINDS)
def test_no_bit_of_a_body_depends_on_its_company(kind):
    body, (attitudes, rates) = bodies(kind), states(N)
    together = Batch(body, attitudes, rates, (N,))._cached
    order = RNG.permutation(N)
    elsewhere = Batch(body[order], attitudes[order], rates[order], (N,))._cached
    assert elsewhere.tobytes() == together[order].tobytes()
    part = slice(3, 76)
    assert (
        Batch(body[part], attitudes[part], rates[part], (73,))._cached.tobytes() == together[part].tobytes()
    )
    for b in range(0, N, 5):
        alone = Batch(body[b], attitudes[b], rates[b], ())._cached
        assert alone.tobytes() == together[b].tobytes()


@pytest.mark.parametrize("exponent", [0, -300, 280])
def test_only_ratios_of_moments_and_a_power_of_two_of_rates_matter(exponent):
    moments, (attitudes, rates) = moments_of(40), states(40)
    plain = TorqueFreeMotion(RigidBody(moments), attitudes, rates, order="wxyz").at(10.0)
    scaled = TorqueFreeMotion(
        RigidBody(moments * 2.0**exponent, physical=False), attitudes, rates * 2.0**9, order="wxyz"
    ).at(10.0 / 2.0**9)
    assert scaled.quaternion("wxyz").tobytes() == plain.quaternion("wxyz").tobytes()
    assert (scaled.angular_velocity == plain.angular_velocity * 2.0**9).all()


def test_phase_rates_have_thirty_digits_on_both_sides_of_each_edge():
    """Beside m1 = 0.03, where the series change, and where numbers become too small for the lanes."""
    cases = [((1.0, 2.0, 3.0), (0.5, 1.0, x)) for x in (0.32, 0.30, 0.295, 0.29, 1e-9, 1e-12, 1e-13, 1e-14)]
    cases += [((1.0, 1.0 + d, 1.5), (0.3, 0.4, 0.8)) for d in (1e-15, 1e-9)]
    cases += [((d, 1.0, 1.0 + 0.5 * d), (0.3, 0.4, 0.8)) for d in (1e-2, 2e-10, 1e-10, 5e-11)]
    routes = set()
    for moments, rate in cases:
        record = Batch(
            RigidBody(moments, physical=False), np.array([1.0, 0, 0, 0]), np.array(rate), ()
        )._cached
        routes.add(int(record["route"][0]))
        with mp.workdps(50):
            truth = truth_of(fractions(moments), fractions(rate), 50).constants()
            u_rate, K, K_prime = (mp.mpf(truth[name]) for name in ("u_rate", "K", "K_prime"))
            on_theta = record["route"][0] == Route.THETA
            expected = u_rate / (4 * K) if on_theta else mp.pi * u_rate / (4 * K_prime)
            assert abs(mp.fsum(record["argument"][0].tolist()) / expected - 1) < 1e-30
            turns = mp.fsum(record["precession"][0].tolist()) * 2 * mp.pi
            assert abs(turns / truth["lambda"] - 1) < 1e-30
    assert routes == {Route.THETA, Route.TRANSFORMED}
