"""The oracles against each other; tests/test_published.py has published numbers."""

import math
import random
from fractions import Fraction
from itertools import pairwise
from operator import mul

import pytest
from mpmath import mp, mpf

from attitude.oracle import exact, taylor, theta, truth
from tests.oracles import published_mpmath

# Ten digits below the fifty that each route promises.
AGREEMENT = 1e-40

QUATERNION = (0.5, -0.1, 0.7, 0.3)
GENERIC = {
    "short_axis": ((1.0, 1.6, 2.1), (0.3, -0.5, 0.9)),
    "long_axis": ((1.0, 1.6, 2.1), (-1.1, 0.4, 0.2)),
    "spindle": ((0.01, 1.0, 1.005), (2.0, 0.7, -0.4)),
    "plate": ((1.0, 1.125, 2.125), (0.2, 0.25, -1.0)),
    "toutatis": ((3.0836, 3.235, 1.0), (14.51, 33.529, -98.709)),
    "turning_point": ((3.0, 1.0, 2.0), (0.5, 1.0, 0.0)),
    "flip": ((3.0, 5.0, 9.0), (0.0, 0.4, 0.01 / 9)),
}
SYMMETRIC = {
    "oblate": ((2.0, 2.0, 3.0), (0.3, -0.4, -1.2)),
    "prolate": ((1.0, 2.0, 2.0), (1.3, -0.4, 0.5)),
    "equal_outer": ((2.0, 1.0, 2.0), (1.3, -0.4, 0.5)),
}
CONSTANT_RATE = {
    "rest": ((1.0, 2.0, 2.5), (0.0, 0.0, 0.0)),
    "sphere": ((2.0, 2.0, 2.0), (0.3, -0.4, 1.2)),
    "pure_spin_x": ((1.0, 2.0, 2.5), (-0.7, 0.0, 0.0)),
    "pure_spin_y": ((1.0, 2.0, 2.5), (0.0, 0.7, 0.0)),
    "pure_spin_z": ((1.0, 2.0, 2.5), (0.0, 0.0, 0.7)),
    "equatorial": ((2.0, 2.0, 2.5), (0.3, 0.4, 0.0)),
}
# 2.25 (2.25 - 2) 1^2 = 1 (2 - 1) 0.75^2 in binary fractions
SEPARATRIX = ((1.0, 2.0, 2.25), (0.75, 0.3, 1.0))


def assert_same(got, expected, tolerance=AGREEMENT):
    """Attitudes with their signs, and rates."""
    assert truth.component_error(got[0], expected[0]) < tolerance
    assert truth.rate_error(got[1], expected[1]) < tolerance


def assert_routes_agree(moments, omega, t, q0=QUATERNION):
    """Taylor series with their period map, and theta functions."""
    expected = theta.attitude_and_rate(moments, omega, q0, t)
    assert_same(taylor.attitude_and_rate(moments, omega, q0, t), expected)


def times(omega, radians=(1e-3, -2.7, 41.3, -1e3, 1e9, 1e12)):
    rate = math.hypot(*omega)
    return [angle / rate for angle in radians]


def random_body(seed):
    """Physical moments over two decades of thinness, a rate, an attitude: all generic."""
    rng = random.Random(seed)
    masses = [10 ** rng.uniform(-2, 0) for _ in range(3)]
    moments = tuple(sum(masses) - mass for mass in masses)
    omega, q0 = (tuple(rng.gauss(0, 1) for _ in range(n)) for n in (3, 4))
    return moments, omega, q0


# Taylor with its period map, against theta functions


@pytest.mark.parametrize("name", GENERIC | SYMMETRIC)
def test_period_map_and_theta_agree_to_any_horizon(name):
    moments, omega = (GENERIC | SYMMETRIC)[name]
    for t in times(omega):
        assert_routes_agree(moments, omega, t)


@pytest.mark.parametrize("seed", range(16))
def test_routes_agree_for_random_bodies(seed):
    moments, omega, q0 = random_body(seed)
    for t in times(omega, (3.3, -77.0, 1e12)):
        assert_routes_agree(moments, omega, t, q0)


@pytest.mark.parametrize("name", ["short_axis", "long_axis", "turning_point", "oblate"])
def test_period_map_is_what_plain_integration_gives(name):
    moments, omega = (GENERIC | SYMMETRIC)[name]
    period = truth.polhode_period(moments, omega)
    for cycles in (2.6, -1.3):
        t = float(cycles * period)
        expected = taylor.integrate(moments, omega, QUATERNION, t)
        assert_same(taylor.attitude_and_rate(moments, omega, QUATERNION, t), expected)


@pytest.mark.parametrize("off", [1e-4, 1e-15])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_routes_agree_beside_a_principal_axis(axis, off):
    omega = [off, -off, off]
    omega[axis] = -1.0
    for t in (5.0, -123.4, 1e9):
        assert_routes_agree((1.0, 2.0, 2.5), omega, t)


@pytest.mark.parametrize("off", [1e-8, -1e-8, 2e-15, -2e-15])
def test_routes_agree_on_either_side_of_the_separatrix(off):
    moments, (w1, w2, w3) = SEPARATRIX
    for t in (5.0, -43.2, 1e9, 1e12):
        assert_routes_agree(moments, (w1, w2, w3 + off), t)


@pytest.mark.parametrize("t", [1e-3, 2.0, -7.0, 25.0, -25.0])
@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1), (1, 1, -1), (-1, -1, -1)])
def test_separatrix_in_hyperbolic_functions_is_what_integration_gives(signs, t):
    moments, omega = SEPARATRIX
    omega = [sign * component for sign, component in zip(signs, omega, strict=True)]
    assert theta.motion(exact.fractions(moments), exact.fractions(omega)).regime == "separatrix"
    assert_routes_agree(moments, omega, t)


@pytest.mark.parametrize("off", [1e-6, 2**-50])
@pytest.mark.parametrize("shape", [(1, 0, 0), (0, 1, 0), (1, -1, 0), (0, -2, 1)])
def test_routes_agree_beside_the_sphere_and_symmetric_bodies(shape, off):
    near_sphere = [1 + off * step for step in shape]
    near_symmetric = [1 + off, 1.0, 1.5]
    for moments in (near_sphere, near_symmetric):
        for t in (5.0, 1e9, -1e12):
            assert_routes_agree(moments, (0.3, 0.4, -0.8), t)


@pytest.mark.parametrize("name", ["pure_spin_x", "pure_spin_z", "equatorial", "sphere"])
def test_constant_rate_is_the_limit_of_nearby_motions(name):
    moments, omega = CONSTANT_RATE[name]
    tiny = Fraction(1, 10**60)
    nearby_moments = [exact.fraction(moment) + k * tiny for k, moment in enumerate(moments)]
    nearby = [exact.fraction(component) + tiny for component in omega]
    for t in (3.0, -1e3):
        assert_same(
            theta.attitude_and_rate(moments, omega, QUATERNION, t),
            theta.attitude_and_rate(nearby_moments, nearby, QUATERNION, t),
        )


@pytest.mark.parametrize(("moments", "omega"), CONSTANT_RATE.values(), ids=CONSTANT_RATE.keys())
def test_constant_rate_is_recognised_exactly(moments, omega):
    assert theta.motion(exact.fractions(moments), exact.fractions(omega)).regime == "constant_rate"
    q, rate = truth.attitude_and_rate(moments, omega, (1, 0, 0, 0), 2.5)
    assert rate == omega
    with mp.workdps(60):
        half_turn = [mpf(component) * 1.25 for component in omega]
        assert abs(q[0] - mp.cos(mp.norm(half_turn))) < AGREEMENT


# Theta functions alone: digits, one rate, extremes


def closed_sums(known):
    """The rates of alpha and of beta as closed sums, from their own third-kind integrals."""
    (a1, _, a3), A3, L, h = known["a"], known["A"][2], known["L"], known["h"]
    Q2, v_rate, n = known["nome2"], known["v_rate"], range(1, 400)
    alpha = 4 * mp.fsum(Q2**k / (1 - Q2 ** (2 * k)) * mp.sinh(2 * k * h) for k in n)
    beta = mp.coth(h) - 4 * mp.fsum(Q2 ** (2 * k) / (1 - Q2 ** (2 * k)) * mp.sinh(2 * k * h) for k in n)
    return L / 2 * (a1 + (a3 - a1) * A3) + v_rate * alpha, L / 2 * (a1 - (a3 - a1) * A3) - v_rate * beta


def log_rate_of_beta(known):
    """beta'/beta at t = 0 less that of its theta1: 2 beta' = (omega1 + i omega2) alpha - i omega3 beta."""
    w1, w2, w3 = (known["L"] * a * gamma for a, gamma in zip(known["a"], known["gamma"], strict=True))
    z = mp.mpc(known["v0"], -known["h"])
    theta1_rate = known["v_rate"] * mp.jtheta(1, z, known["nome2"], 1) / mp.jtheta(1, z, known["nome2"])
    return (mp.mpc(w1, w2) / known["ratio"] - 1j * w3) / 2 - theta1_rate


@pytest.mark.parametrize(("moments", "omega"), GENERIC.values(), ids=GENERIC.keys())
def test_one_rate_serves_alpha_and_beta(moments, omega):
    motion = theta.motion(exact.fractions(moments), exact.fractions(omega))
    with mp.workdps(90):
        known = motion.constants()
        assert abs(log_rate_of_beta(known) / known["log_rate"] - 1) < 1e-50
        for rate in closed_sums(known):
            assert abs(rate / known["lambda"] - 1) < 1e-50


EXTREME = {
    "axis_150": ((1.0, 2.0, 2.5), (1e-150, 3e-150, 1.0)),
    "long_axis_150": ((1.0, 2.0, 2.5), (1.0, 3e-150, 1e-150)),
    "middle_150": ((1.0, 2.0, 2.5), (1e-150, 1.0, 3e-150)),
    "sphere_15": ((1.0, 1 + 2**-50, 1 - 2**-50), (0.2, -0.3, 0.4)),
    "tiny_moments": ((1e-170, 2e-170, 2.5e-170), (0.2, -0.3, 0.4)),
    "huge_rate": ((1.0, 2.0, 2.5), (2e160, -3e160, 4e160)),
}


@pytest.mark.parametrize(("moments", "omega"), EXTREME.values(), ids=EXTREME.keys())
def test_fifty_digits_are_kept_at_the_extremes(moments, omega):
    for t in times(omega, (1e-3, -17.0, 2e3, 1e9, 1e14)):
        assert_same(
            theta.attitude_and_rate(moments, omega, QUATERNION, t),
            theta.attitude_and_rate(moments, omega, QUATERNION, t, digits=90),
            1e-50,
        )


def test_attitude_is_continuous_through_period_wraps():
    moments, omega = GENERIC["flip"]
    quaternions = [truth.attitude_and_rate(moments, omega, QUATERNION, 0.5 * k)[0] for k in range(-250, 500)]
    steps = [truth.component_error(q, p) for q, p in pairwise(quaternions)]
    # |q'| = |omega| / 2
    assert max(steps) < 0.5 * 0.45 / 2


def test_two_part_time_is_summed_exactly():
    moments, omega = GENERIC["short_axis"]
    together = Fraction(1e9) + Fraction(1e-9)
    split, summed, first = (
        truth.attitude_and_rate(moments, omega, QUATERNION, t) for t in ((1e9, 1e-9), together, 1e9)
    )
    assert_same(split, summed, 1e-50)
    assert truth.attitude_error(split[0], first[0]) > 1e-10


# The published route


@pytest.mark.parametrize("seed", range(100, 104))
def test_published_route_mended_agrees(seed):
    moments, omega, q0 = random_body(seed)
    for t in times(omega, (0.0, 3.3, -77.0, 1e9)):
        q, rate = published_mpmath.attitude_and_rate(moments, omega, q0, t, digits=80)
        expected = truth.attitude_and_rate(moments, omega, q0, t)
        assert truth.attitude_error(q, expected[0]) < AGREEMENT
        assert truth.rate_error(rate, expected[1]) < AGREEMENT


# Tensors and errors


def test_tensor_gives_the_attitude_of_its_own_axes():
    """J = R diag(I) R^T for a rational R: the same motion, q_IB = q_IP * conj(q_R)."""
    R = [[1, -2, 2], [2, -1, -2], [2, 2, 1]]
    moments, omega_P = (9.0, 12.0, 17.0), (0.25, -0.5, 0.75)
    tensor = [[sum(R[i][k] * moments[k] * R[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    omega_B = [sum(R[i][k] * omega_P[k] for k in range(3)) for i in range(3)]
    with mp.workdps(80):
        q_R = exact.quaternion_of_matrix([[mpf(entry) / 3 for entry in row] for row in R])
        q0_P = exact.multiply(exact.normalised(QUATERNION), q_R)
        for t in (3.0, -1e6):
            q_P, rate_P = truth.attitude_and_rate(moments, [3 * w for w in omega_P], q0_P, t)
            expected = exact.multiply(q_P, exact.conjugate(q_R)), exact.rotate(q_R, rate_P)
            assert_same(truth.attitude_and_rate_of_tensor(tensor, omega_B, QUATERNION, t), expected)


def test_diagonal_tensor_is_its_principal_moments():
    moments, omega = GENERIC["turning_point"]
    tensor = [[moment * (i == j) for j in range(3)] for i, moment in enumerate(moments)]
    assert_same(
        truth.attitude_and_rate_of_tensor(tensor, omega, QUATERNION, 8.0),
        truth.attitude_and_rate(moments, omega, QUATERNION, 8.0),
        1e-49,
    )


def test_errors_are_measured_from_nothing_to_half_a_turn():
    with mp.workdps(60):
        tiny = mpf(10) ** -30
        assert truth.attitude_error((1, tiny / 2, 0, 0), (-1, 0, 0, 0)) == pytest.approx(1e-30)
    assert truth.attitude_error((0, 0, 2, 0), (3, 0, 0, 0)) == pytest.approx(math.pi)
    assert truth.component_error((1, 0, 0, 0), (-1, 0, 0, 0)) == 2
    assert truth.rate_error((1, 1e-20, 0), (1, 0, 0)) == pytest.approx(1e-20)
    assert truth.rate_error((0, 0, 0), (0, 0, 0)) == 0


def test_nasa_tumbling_brick():
    """NASA/TM-2015-218675, case 2, at 30 s."""
    moments = (0.001894220, 0.006211019, 0.007194665)
    omega = [math.radians(rate) for rate in (10, 20, 30)]
    quaternion = (-0.8811471853104235, 0.4701825277666925, 0.01172825232487118, 0.04868753947208377)
    rate = (12.61839077591422, -17.39747476161139, 31.11958888694434)
    for route in truth.ROUTES:
        got, got_rate = truth.attitude_and_rate(moments, omega, (1, 0, 0, 0), 30, route=route)
        assert truth.component_error(got, quaternion) < 1e-15
        assert truth.rate_error(got_rate, [math.radians(component) for component in rate]) < 1e-15
    assert float(truth.polhode_period(moments, omega)) == pytest.approx(17.384489271939, abs=1e-12)
    assert float(truth.precession_period(moments, omega)) == pytest.approx(10.076492250293, abs=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("name", ["short_axis", "long_axis", "toutatis"])
def test_precession_period_is_that_of_the_azimuth_of_each_axis(name, axis):
    moments, omega = GENERIC[name]
    momentum = [moment * rate for moment, rate in zip(moments, omega, strict=True)]
    across = (momentum[1], -momentum[0], 0.0)
    toward = exact.multiply((0, *momentum), (0, *across))[1:]
    period, azimuth, samples = float(truth.polhode_period(moments, omega)), [], 64
    for k in range(samples + 1):
        q = truth.attitude_and_rate(moments, omega, (1, 0, 0, 0), k * period / samples, digits=15)[0]
        pointing = exact.rotate(q, [float(k == axis) for k in range(3)])
        x, y = (float(sum(map(mul, pointing, v))) / math.hypot(*v) for v in (across, toward))
        azimuth.append(math.atan2(y, x))
    steps = [math.remainder(b - a, 2 * math.pi) for a, b in pairwise(azimuth)]
    expected = 2 * math.pi * period / sum(steps)
    assert float(truth.precession_period(moments, omega, axis)) == pytest.approx(expected, rel=1e-12)
