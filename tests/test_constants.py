"""Constants of the motion: the paper's, against its own formulas at eighty digits; periods, rates, ranges."""

import math
import random

import numpy as np
import pytest
from mpmath import mp, mpf, workdps

from attitude import RegimeError, RigidBody, ToleranceError, TorqueFreeMotion
from attitude.oracle import truth
from tests.bodies import (
    ATTITUDE,
    CONSTANT_RATE,
    GENERIC,
    LONG_AXIS,
    NAMED,
    SEPARATRIX,
    SHORT_AXIS,
    Body,
    distance,
    each,
    fastest,
    motion,
    random_bodies,
    sample,
    speed,
)
from tests.oracles.published_mpmath import published_motion

# Kept in two parts, each is rounded once or twice: an ulp or two.
TOLERANCE = 1e-15
# q = exp(-pi K'/K) is rounded in its exponent, by eps for each unit of it.
NOME_TOLERANCE = 2.0**-52
# A1 is an arc tangent plus another: rad.
ANGLE_TOLERANCE = 2e-15
DIGITS = 80

REGIMES = {
    "short_axis": SHORT_AXIS,
    "long_axis": LONG_AXIS,
    "separatrix": SEPARATRIX,
    "constant_rate": CONSTANT_RATE,
}


def facing_plus(body):
    """The body turned so that its momentum's extreme components are positive: so are the paper's signs."""
    omega = list(body.omega)
    for axis in np.argsort(body.inertia)[[0, 2]]:
        omega[axis] = abs(omega[axis])
    return Body(body.inertia, tuple(omega))


def relative_error(value, expected):
    return float(abs((mpf(float(value)) - expected) / expected))


def assert_constants_are_the_papers(body):
    body = facing_plus(body)
    actual = motion(body).constants
    with workdps(DIGITS):
        paper = published_motion(*body)
        for name in ("m", "K", "K_prime", "omega_p", "epsilon", "eta", "A2"):
            assert relative_error(getattr(actual, name), getattr(paper, name)) <= TOLERANCE, (name, body)
        exponent = float(mp.pi * paper.K_prime / paper.K)
        assert relative_error(actual.q, paper.nome) <= NOME_TOLERANCE * (4 + exponent), body
        turns = (mpf(float(actual.A1)) - paper.A1) / (2 * mp.pi)
        assert abs(turns - mp.nint(turns)) * 2 * mp.pi <= ANGLE_TOLERANCE, body


@pytest.mark.parametrize("body", **each(GENERIC))
def test_constants_of_named_bodies_are_the_papers(body):
    assert_constants_are_the_papers(body)


@pytest.mark.parametrize("seed", range(4))
def test_constants_of_random_bodies_are_the_papers(seed):
    for body, _ in random_bodies(random.Random(f"constants {seed}"), 25):
        assert_constants_are_the_papers(body)


BODY = (3.0, 4.0, 6.0)
LADDERS = {
    "to the separatrix": [
        Body(BODY, (2.0 * (1 + sign * 10.0**-k), 0.7, 1.0)) for k in range(1, 15) for sign in (1, -1)
    ],
    "to spin about the greatest axis": [Body(BODY, (10.0**-k, 0.7 * 10.0**-k, 1.0)) for k in range(1, 17)],
    "to spin about the least axis": [Body(BODY, (1.0, 0.7 * 10.0**-k, 10.0**-k)) for k in range(1, 17)],
    "to spin about the middle axis": [Body(BODY, (10.0**-k, 1.0, 0.7 * 10.0**-k)) for k in range(1, 13)],
    "to an oblate body": [Body((2.0, 2.0 + 10.0**-k, 3.0), (0.3, 0.4, 0.8)) for k in range(1, 15)],
    "to a prolate body": [Body((1.0, 2.0, 2.0 + 10.0**-k), (1.3, 0.4, 0.5)) for k in range(1, 15)],
}


@pytest.mark.parametrize("ladder", **each(LADDERS))
def test_constants_keep_their_digits_where_formulas_lose_theirs(ladder):
    for body in ladder:
        assert_constants_are_the_papers(body)


@pytest.mark.parametrize("body", **each(GENERIC))
def test_psi_is_the_papers_angle_and_starts_at_zero(body):
    """Printed whole, not wrapped: rounded as a double of its size, and its phases as doubles of theirs."""
    body = facing_plus(body)
    t = np.array([0.0, 1e-3, -1e-3, 2.0, -37.0, 1e3, -1e5]) / speed(body)
    psi = motion(body).constants.psi(t)
    assert psi[0] == 0.0
    with workdps(DIGITS):
        paper = published_motion(*body)
        for angle, instant in zip(psi, t, strict=True):
            expected = paper.psi(mpf(float(instant)))
            off = abs(mpf(float(angle)) - expected)
            assert off <= 4 * 2.0**-52 * (2 + abs(expected)), instant


@pytest.mark.parametrize("body", **each(SHORT_AXIS | LONG_AXIS | SEPARATRIX))
def test_psi_is_continuous(body):
    """psi' = L (I1 w1^2 + I2 w2^2) / (L1^2 + L2^2) lies between L/I_hi and L/I_lo."""
    t = np.arange(-100_000, 100_000) * 2.0**-10
    slope = np.diff(motion(body).constants.psi(t)) * 2.0**10
    L = math.hypot(*(moment * rate for moment, rate in zip(*body, strict=True)))
    noise = 4 * 2.0**-52 * 100 * fastest(body) * max(body.inertia) / min(body.inertia) * 2.0**10
    assert np.min(slope) >= L / max(body.inertia) - noise
    assert np.max(slope) <= L / min(body.inertia) + noise


def test_psi_takes_an_instant_and_any_shape():
    constants = motion(GENERIC["short axis"]).constants
    one, many = constants.psi(2.0), constants.psi(np.full((3, 2), 2.0))
    assert np.shape(one) == ()
    np.testing.assert_array_equal(many, np.full((3, 2), one))


def test_constants_of_symmetric_bodies_and_of_the_separatrix_are_the_limits():
    oblate, flip = motion(SHORT_AXIS["oblate"]).constants, motion(SEPARATRIX["separatrix"]).constants
    assert (oblate.m, oblate.q, oblate.K, oblate.K_prime) == (0.0, 0.0, math.pi / 2, math.inf)
    assert (flip.m, flip.q, flip.K, flip.K_prime) == (1.0, 1.0, math.inf, math.pi / 2)
    for constants in (oblate, flip):
        assert np.all(np.isfinite([constants.omega_p, constants.epsilon, constants.A1, constants.A2]))


@pytest.mark.parametrize("body", **each(CONSTANT_RATE))
def test_a_constant_rate_has_none_of_the_papers_constants(body):
    with pytest.raises(RegimeError, match="constant body rate"):
        _ = motion(body).constants


# Periods, rates, ranges


def circled(actual):
    """The body axis that the momentum circles."""
    moments = actual.body.moments
    return int(np.argmax(moments) if actual.regime == "short_axis" else np.argmin(moments))


def assert_periods_are_true(body):
    actual = motion(body)
    assert relative_error(actual.polhode_period, truth.polhode_period(*body)) <= TOLERANCE
    for rate, axis in (
        (actual.mean_precession_rate, None),
        (actual.spin_axis_precession_rate, circled(actual)),
    ):
        expected = 2 * mp.pi / truth.precession_period(*body, axis)
        assert relative_error(rate, expected) <= 2 * TOLERANCE


@pytest.mark.parametrize("body", **each(GENERIC))
def test_periods_of_named_bodies_are_true(body):
    assert_periods_are_true(body)


def test_periods_of_random_bodies_are_true():
    for body, _ in random_bodies(random.Random("periods"), 20, decades=1.0):
        assert_periods_are_true(body)


@pytest.mark.parametrize("body", **each(SEPARATRIX | CONSTANT_RATE))
def test_what_never_returns_has_an_infinite_period(body):
    assert motion(body).polhode_period == math.inf


def test_a_period_beyond_the_range_of_a_double_is_infinite_and_no_overflow():
    actual = motion(Body((2.0, 2.0, 4.0), (0.0, 1e-200, 1e-310)))
    assert actual.polhode_period == math.inf
    assert actual.mean_precession_rate == pytest.approx(1e-200, rel=4e-16)
    assert actual.spin_axis_precession_rate == pytest.approx(1e-200, rel=4e-16)


@pytest.mark.parametrize("body", **each(CONSTANT_RATE))
def test_a_constant_rate_is_its_own_precession_and_does_not_nutate(body):
    actual = motion(body)
    expected = math.hypot(*body.omega)
    assert actual.mean_precession_rate == pytest.approx(expected, rel=4e-16)
    assert actual.spin_axis_precession_rate == pytest.approx(expected, rel=4e-16)
    np.testing.assert_array_equal(actual.nutation_range, 0.0)


@pytest.mark.parametrize("body", **each(GENERIC))
def test_the_momentum_reaches_both_ends_of_the_nutation_range_and_never_leaves_it(body):
    actual = motion(body)
    first = -actual.constants.epsilon / actual.constants.omega_p
    quarters = first + actual.polhode_period / 4 * np.arange(-8, 9)
    between = first + actual.polhode_period * np.linspace(-2, 2, 1001)
    least, greatest = actual.nutation_range
    angles = [nutation(body, t, circled(actual)) for t in (quarters[::2], quarters[1::2], between)]
    np.testing.assert_allclose(angles[0], least, rtol=0, atol=1e-14)
    np.testing.assert_allclose(angles[1], greatest, rtol=0, atol=1e-14)
    assert np.min(angles[2]) >= least - 1e-14
    assert np.max(angles[2]) <= greatest + 1e-14


def nutation(body, t, axis):
    """Angle between the momentum and an axis of the body, from the sampled rates."""
    _, omega = sample(body, t)
    momentum = omega * body.inertia
    across = np.linalg.norm(np.delete(momentum, axis, axis=1), axis=1)
    return np.arctan2(across, np.abs(momentum[:, axis]))


def test_regimes_are_named():
    for regime, bodies in REGIMES.items():
        assert {motion(body).regime for body in bodies.values()} == {regime}


def batch(bodies):
    moments, rates = zip(*bodies.values(), strict=True)
    return TorqueFreeMotion(RigidBody.from_moments(moments), ATTITUDE, rates, order="wxyz")


PROPERTIES = ("regime", "angular_momentum", "kinetic_energy", "polhode_period")
PROPERTIES += ("mean_precession_rate", "nutation_range")


def test_a_batch_has_the_constants_of_its_bodies():
    for name in PROPERTIES:
        expected = [getattr(motion(body), name) for body in NAMED.values()]
        np.testing.assert_array_equal(getattr(batch(NAMED), name), expected)
    for name in ("m", "K", "K_prime", "q", "omega_p", "epsilon", "eta", "A1", "A2"):
        expected = [getattr(motion(body).constants, name) for body in GENERIC.values()]
        np.testing.assert_array_equal(getattr(batch(GENERIC).constants, name), expected)
    t = np.linspace(-5, 5, 7)
    expected = [motion(body).constants.psi(t) for body in GENERIC.values()]
    np.testing.assert_array_equal(batch(GENERIC).constants.psi(t), expected)


@pytest.mark.parametrize("body", **each(NAMED))
def test_momentum_and_energy_are_those_of_the_state(body):
    whole, ephemeris = motion(body), motion(body).at(np.linspace(-40.0, 100.0, 57))
    energy = 0.5 * sum(moment * rate**2 for moment, rate in zip(*body, strict=True))
    np.testing.assert_allclose(whole.kinetic_energy, energy, rtol=4e-16)
    np.testing.assert_allclose(ephemeris.kinetic_energy, np.full(57, energy), rtol=4e-15)
    assert distance(ephemeris.angular_momentum, whole.angular_momentum).max() <= 1e-14


def test_slow_body_of_a_batch_is_not_held_to_the_turns_of_a_fast_one():
    """A batch keeps the rate of its fastest phase once it was sampled."""
    rates = [(1e3, 1e3, 2e3), (1e-3, 1e-3, 2e-3)]
    both = TorqueFreeMotion(RigidBody([(1.0, 1.6, 2.1)] * 2), [1, 0, 0, 0], rates, order="wxyz")
    both.at([0.0])
    fast = TorqueFreeMotion(RigidBody((1.0, 1.6, 2.1)), [1, 0, 0, 0], rates[0], order="wxyz")
    far = next(t for t in 10.0 ** np.arange(9, 30) if refuses(fast, t))
    assert refuses(both, far)
    assert both[1].at([far]).shape == (1,)


def refuses(motion, t):
    try:
        motion.at([t])
    except ToleranceError:
        return True
    return False
