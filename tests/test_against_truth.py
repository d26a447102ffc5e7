"""Whole attitudes and rates against fifty-digit truth: regimes, axes, signs, horizons, and every hard corner.

The truth takes the same binary numbers and shares no code with the library, so nothing here is forgiven to
conditioning: an error is an error of the arithmetic.
"""

import math
import random
from fractions import Fraction
from itertools import permutations, product
from operator import mul

import numpy as np
import pytest
from astropy.time import TimeDelta
from mpmath import workdps
from scipy.spatial.transform import Rotation

from attitude.oracle import exact, truth
from tests.bodies import (
    ATTITUDE,
    ATTITUDE_TOLERANCE,
    GENERIC,
    NAMED,
    RATE_TOLERANCE,
    SEPARATRIX,
    TRUTH_DIGITS,
    Body,
    angle_between,
    assert_true,
    distance,
    each,
    errors,
    fastest,
    motion,
    random_bodies,
    sample,
    speed,
    times,
)

# Angles turned at the first rate, rad.
ANY_REGIME = (0.0, 1e-3, 2.0, -37.0, 1e3, -1e6, 1e9, -1e9)
GENERIC_ONLY = (1e12, -1e12)
# The library refuses times beyond 2^42 turns of its fastest phase, which is near 3e13 rad.
FARTHEST = (1e13, -1e13)


@pytest.mark.parametrize("seed", range(8))
def test_random_bodies_keep_every_digit_to_1e12_rad(seed):
    for body, attitude in random_bodies(random.Random(seed), 25):
        assert_true(body, times(body, ANY_REGIME + GENERIC_ONLY), attitude)


@pytest.mark.parametrize("body", **each(NAMED))
def test_named_bodies_are_true_in_every_order_of_axes_and_with_every_sign(body):
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            moments = tuple(body.inertia[k] for k in order)
            omega = tuple(sign * body.omega[k] for sign, k in zip(signs, order, strict=True))
            turned = Body(moments, omega)
            assert_true(turned, times(turned, (2.0, -1e9)))


@pytest.mark.parametrize("body", **each(NAMED))
def test_named_bodies_are_true_at_every_horizon(body):
    assert_true(body, times(body, ANY_REGIME))


@pytest.mark.parametrize("body", **each(GENERIC))
def test_generic_bodies_are_true_as_far_as_the_library_answers(body):
    assert_true(body, times(body, GENERIC_ONLY + FARTHEST))


# Ladders: each step a decade nearer to where formulas break


def both_sides(steps):
    return [(sign, 10.0**-k) for k in steps for sign in (1, -1)]


def off_axis(axis):
    """Nearly pure spin, the other two rates in several proportions down to 1e-150 of it."""
    for k in (*range(1, 18), 30, 75, 150):
        for first, second in ((1, 1), (1, 0), (0, 1), (-1, 3)):
            omega = [-1.0, -1.0, -1.0]
            omega[axis - 2], omega[axis - 1] = first * 10.0**-k, second * 10.0**-k
            yield Body((2.0, 1.0, 2.5), tuple(omega))


RATE = (0.3, 0.4, -0.8)
DECADES = range(1, 16)
LADDERS = {
    "to the separatrix, by the least axis": [
        Body((3.0, 4.0, 6.0), (2.0 * (1 + sign * off), 0.7, 1.0)) for sign, off in both_sides(DECADES)
    ],
    "to the separatrix, by the greatest axis": [
        Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 * (1 + sign * off))) for sign, off in both_sides(DECADES)
    ],
    "to the separatrix, by a moment": [
        Body((3.0, 4.0, 6.0 * (1 + sign * off)), (2.0, 0.7, 1.0)) for sign, off in both_sides(DECADES)
    ],
    "to both saddle and separatrix": [
        Body((3.0, 4.0, 6.0), (2.0 * off, -1.0, off * (1 + sign * off))) for sign, off in both_sides(DECADES)
    ],
    "along the separatrix": [
        Body((3.0, 4.0, 6.0), (2 * first, middle, third))
        for middle in (0.7, -0.7, 0.0, 1e-5, 1e-150, 10.0, 1e10)
        for first, third in product((1.0, -1.0), repeat=2)
    ],
    "to the separatrix of a nearly symmetric body": [
        Body((1.0, 1.5 + sign * off, 1.5), (1e-2, 0.4, 0.8)) for sign, off in both_sides(DECADES)
    ],
    "to spin about the middle axis": list(off_axis(0)),
    "to spin about the least axis": list(off_axis(1)),
    "to spin about the greatest axis": list(off_axis(2)),
    "to an oblate body": [Body((1.0 + sign * off, 1.0, 1.5), RATE) for sign, off in both_sides(DECADES)],
    "to a prolate body": [Body((1.0, 1.5 + sign * off, 1.5), RATE) for sign, off in both_sides(DECADES)],
    "to the sphere": [
        Body((1.0 + sign * off, 1.0, 1.0 + part * off), RATE)
        for part in (0.0, 0.5, 2.0)
        for sign, off in both_sides(DECADES)
    ],
    "to a needle, spinning about any axis": [
        Body((off, 1.0, 1.0 + sign * off), RATE) for sign, off in both_sides(DECADES)
    ],
    "to a symmetric needle": [
        Body((off, 1.0, 1.0), (spin, *RATE[1:])) for off in (0.1**k for k in DECADES) for spin in (0.3, off)
    ],
    "to a needle, spinning about itself": [
        Body((off, 1.0, 1.0 - 0.5 * off), (0.3 / math.sqrt(off), *RATE[1:]))
        for _, off in both_sides(DECADES)[::2]
    ],
    "to a disc": [Body((1.0, 1.0 + off, 2.0), RATE) for _, off in both_sides(DECADES)[::2]],
    "symmetric, any order of axes": [
        Body(moments, omega)
        for shape in ((2.0, 2.0, 3.0), (1.0, 2.0, 2.0))
        for moments in sorted(set(permutations(shape)))
        for omega in (RATE, (1e-8, 1.0, 2.0), (1.0, 1e-100, -1.0), (0.0, -1.0, 1.0), (1e-5, -1e-5, 1e-9))
    ],
    "scale of the moments": [
        Body((2 * scale, scale, 2.5 * scale), RATE) for scale in (1e-150, 1e-75, 1e-10, 1e10, 1e75, 1e150)
    ],
    "scale of the rates": [
        Body((2.0, 1.0, 2.5), tuple(scale * rate for rate in RATE))
        for scale in (1e-150, 1e-75, 1e-10, 1e10, 1e75, 1e150)
    ],
    "scale of rates against moments": [
        Body((2 / scale, 1 / scale, 2.5 / scale), tuple(scale * rate for rate in RATE))
        for scale in (1e-150, 1e-75, 1e75, 1e150)
    ],
}


@pytest.mark.parametrize("ladder", **each(LADDERS))
def test_every_step_of_a_ladder_is_true(ladder):
    for body in ladder:
        assert_true(body, times(body, ANY_REGIME))


def euler_factors(moments):
    """(I2 - I3)/I1 and so on: what the moments do to the rate; none exceeds one in a real body."""
    first, second, third = map(Fraction, moments)
    return [(second - third) / first, (third - first) / second, (first - second) / third]


def physical_sensitivity(body, limit, t):
    """A bound on the angle between two motions after t, and on the difference of their rates.

    omega' = f(omega) with |df/domega| <= sqrt(2) k W, where k is the greatest Euler factor and W bounds the
    rate. By Gronwall, |d omega| <= (|d omega_0| + W^2 t |d k|) exp(sqrt(2) k W t); the angle is its integral.
    """
    here, there = euler_factors(body.inertia), euler_factors(limit.inertia)
    W = max(fastest(body), fastest(limit))
    growth = math.exp(math.sqrt(2) * W * t * float(max(map(abs, here + there))))
    shift = math.hypot(*(float(a - b) for a, b in zip(here, there, strict=True)))
    start = math.dist(body.omega, limit.omega)
    rate = (start + W * W * t * shift) * growth
    return rate * t, rate


def assert_no_jump(body, limit, t):
    """Attitudes, with their signs, and rates differ by no more than the bodies do."""
    (q, rate), (q_limit, rate_limit) = sample(body, t), sample(limit, t)
    angle, difference = physical_sensitivity(body, limit, t)
    assert angle_between(q, q_limit) <= angle + 2 * ATTITUDE_TOLERANCE, body
    assert distance(rate, rate_limit) <= difference / speed(limit) + 2 * RATE_TOLERANCE, body


LIMITS = {
    "to the separatrix, by the least axis": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0)),
    "to the separatrix, by the greatest axis": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0)),
    "to the separatrix, by a moment": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0)),
    "to both saddle and separatrix": Body((3.0, 4.0, 6.0), (0.0, -1.0, 0.0)),
    "to spin about the middle axis": Body((2.0, 1.0, 2.5), (-1.0, 0.0, 0.0)),
    "to spin about the least axis": Body((2.0, 1.0, 2.5), (0.0, -1.0, 0.0)),
    "to spin about the greatest axis": Body((2.0, 1.0, 2.5), (0.0, 0.0, -1.0)),
    "to an oblate body": Body((1.0, 1.0, 1.5), RATE),
    "to a prolate body": Body((1.0, 1.5, 1.5), RATE),
    "to the sphere": Body((1.0, 1.0, 1.0), RATE),
    "to a disc": Body((1.0, 1.0, 2.0), RATE),
}


@pytest.mark.parametrize("name", LIMITS)
def test_no_jump_between_a_ladder_and_its_limit(name):
    for body in LADDERS[name]:
        assert_no_jump(body, LIMITS[name], 2.0)


@pytest.mark.parametrize("body", **each(SEPARATRIX))
def test_separatrix_is_recognised_exactly_and_one_ulp_to_either_side_joins_it(body):
    (w1, w2, w3), moments = body.omega, body.inertia
    outside, inside = (
        Body(moments, (math.nextafter(w1, 0), w2, w3)),
        Body(moments, (w1, w2, math.nextafter(w3, 0))),
    )
    assert [motion(each).regime for each in (outside, body, inside)] == [
        "short_axis",
        "separatrix",
        "long_axis",
    ]
    for beside in (outside, inside):
        assert_true(beside, times(beside, ANY_REGIME))
        assert_no_jump(beside, body, 2.0)


# Families through the separatrix, where x begins, and out of the nearness where the modular transform serves.
SWITCHING = {
    "short axis": (lambda x: Body((3.0, 4.0, 6.0), (x, 0.7, 1.0)), 2.0, 1.0),
    "long axis": (lambda x: Body((4.0, 6.0, 3.0), (-0.7, 1.0, x)), 2.0, 3.0),
    "by a moment": (lambda x: Body((3.0, 4.0, x), (2.0, 0.7, 1.0)), 6.0, 7.0),
}


def route(body):
    return motion(body)._batch.fields("route")["route"]


def at_the_switch(family, near, far):
    """Bodies one ulp of x apart, on either side of m = 0.97, by bisection."""
    of_near = route(family(near))
    assert route(family(far)) != of_near
    while (middle := 0.5 * (near + far)) not in (near, far):
        near, far = (middle, far) if route(family(middle)) == of_near else (near, middle)
    return near, far


@pytest.mark.parametrize(("family", "near", "far"), **each(SWITCHING))
def test_both_routes_are_true_where_they_meet_and_there_is_no_step(family, near, far):
    near, far = at_the_switch(family, near, far)
    assert math.nextafter(near, far) == far
    here = family(near)
    assert motion(here).constants.m == pytest.approx(0.97, abs=1e-14)
    for x in (near, far, near - 1e-12, far + 1e-12):
        assert_true(family(x), times(here, ANY_REGIME + GENERIC_ONLY))
        assert_no_jump(family(x), here, 2.0)


LEAST_NUMBERS = {
    "beside the greatest axis": Body((3.0, 4.0, 6.0), (5e-324, 5e-324, 1.0)),
    "beside the least axis": Body((3.0, 4.0, 6.0), (1.0, 1e-300, 0.0)),
    "beside the middle axis": Body((3.0, 4.0, 6.0), (1e-300, 1.0, -1e-300)),
    "oblate, beside its equator": Body((3.0, 3.0, 4.0), (-1.0, 1e-17, 1e-300)),
    "prolate, beside its equator": Body((2.0, 3.0, 3.0), (5e-324, 1e-17, -1.0)),
    "nearly a sphere": Body((1.0, 1.0, 1.0 + 2**-52), (-1.0, 1e-170, 1e-160)),
    "sphere": Body((2.0, 2.0, 2.0), (1.0, 1e-145, 1e-150)),
}


@pytest.mark.parametrize("body", **each(LEAST_NUMBERS))
def test_the_least_numbers_a_double_holds_are_no_exception(body):
    assert_true(body, times(body, ANY_REGIME))


# Tensors and two-part time


def random_tensors(rng, count):
    """Of five points in a box down to a thousand times longer than wide, any way up: physical, and full."""
    for _ in range(count):
        normal = np.array([[rng.gauss(0, 1) for _ in range(3)] for _ in range(8)])
        box = 10.0 ** np.array([rng.uniform(-3, 0) for _ in range(3)])
        turn, _ = np.linalg.qr(normal[5:])
        places = normal[:5] * box @ turn * 10 ** rng.uniform(-3, 3)
        second = places.T @ places
        tensor = np.trace(second) * np.eye(3) - second
        yield tuple(map(tuple, ((tensor + tensor.T) / 2).tolist()))


@pytest.mark.parametrize("seed", range(4))
def test_full_tensors_are_true_to_1e9_rad(seed):
    rng = random.Random(seed)
    for tensor in random_tensors(rng, 12):
        body = Body(tensor, tuple(rng.gauss(0, 1) for _ in range(3)))
        assert_true(body, times(body, (0.0, 3.0, -1e3, 1e9, -1e9)))


def symmetric(diagonal, xy, xz, yz):
    x, y, z = diagonal
    return ((x, xy, xz), (xy, y, yz), (xz, yz, z))


@pytest.mark.parametrize(
    "diagonal", [(2.0, 1.0, 2.5), (2.0, 2.0, 3.0), (1.0, 2.0, 2.0), (2.0, 2.0, 2.0)], ids=str
)
@pytest.mark.parametrize("omega", [RATE, (0.0, 0.0, -1.0), (0.6, 0.0, 0.8)], ids=str)
def test_tensors_down_to_diagonal_are_true(diagonal, omega):
    rng = random.Random(1)
    for k in (1, 2, 4, 8, 12, 15, 16, 17, 20, 33, 35, 40, 100, 150):
        body = Body(symmetric(diagonal, *(10.0**-k * rng.uniform(-1, 1) for _ in range(3))), omega)
        assert_true(body, times(body, (3.0, 1e9)))


TURNS = [(1, 2, 0, -1), (2, -1, 1, 3), (0, 1, 1, 0), (3, 1, -2, 2)]


def turned(body, turn):
    """The body about other axes, exactly, and the same about its own.

    An integer quaternion of norm N gives an integer N R; N R I (N R)^T and N R omega belong to moments
    N^2 I and rate N omega.
    """
    N = sum(part * part for part in turn)
    NR = [
        [round(N * entry) for entry in row] for row in Rotation.from_quat(turn, scalar_first=True).as_matrix()
    ]
    moments, omega = (tuple(map(Fraction, vector)) for vector in body)
    tensor = [[sum(map(mul, map(mul, row, column), moments)) for column in NR] for row in NR]
    rate = [sum(map(mul, row, omega)) for row in NR]
    rounded = Body(tuple(tuple(map(float, row)) for row in tensor), tuple(map(float, rate)))
    assert list(map(Fraction, rounded.omega)) == rate
    straight = Body(tuple(N * N * moment for moment in moments), tuple(N * component for component in omega))
    return rounded, straight


def assert_turned_is_true(body, turn, radians):
    """Against the truth of the moments: q_IB = q_IP * conj(q_R), omega_B = R omega_P."""
    rounded, straight = turned(body, turn)
    q_R = exact.normalised(turn)
    t = times(rounded, radians)
    for instant, q, rate in zip(t, *sample(rounded, t), strict=True):
        with workdps(60):
            q0_P = exact.multiply(exact.normalised(ATTITUDE), q_R)
            true_q, true_rate = truth.attitude_and_rate(*straight, q0_P, instant, TRUTH_DIGITS)
            true_q, true_rate = exact.multiply(true_q, exact.conjugate(q_R)), exact.rotate(q_R, true_rate)
        assert truth.attitude_error(q.tolist(), true_q) <= ATTITUDE_TOLERANCE, (body, turn)
        assert truth.component_error(q.tolist(), true_q) <= ATTITUDE_TOLERANCE, (body, turn)
        assert truth.rate_error(rate.tolist(), true_rate) <= RATE_TOLERANCE, (body, turn)


# The middle moment of a tensor is known to 1e-46, not exactly: D = 0 may come out as that, and the motion
# then leaves the truth as 1e-46 exp(u' t), with u' t at most 34 after this many radians.
LEAVING_SEPARATRIX = (0.0, 1e-3, 2.0, -37.0, 100.0)


@pytest.mark.parametrize("turn", TURNS, ids=str)
def test_full_tensors_are_true_on_the_separatrix_until_the_saddle(turn):
    for omega in ((2.0, 0.75, 1.0), (-2.0, 0.0, 1.0), (2.0**-40, -1.0, -(2.0**-41))):
        assert_turned_is_true(Body((3.0, 4.0, 6.0), omega), turn, LEAVING_SEPARATRIX)


@pytest.mark.parametrize("turn", TURNS, ids=str)
def test_full_tensors_are_true_on_the_way_to_the_separatrix(turn):
    for k in (1, 3, 5, 10, 20, 30, 40):
        for sign in (1, -1):
            body = Body((3.0, 4.0, 6.0), (2.0 * (1 + sign * 2.0**-k), 0.75, 1.0))
            assert_turned_is_true(body, turn, ANY_REGIME)


def tensors_beside_the_separatrix(seed):
    """Random axes, and a rate that D = 0 asks for, off by 1e-1 to 1e-15 of itself to either side."""
    rng, edge = np.random.default_rng(seed), math.sqrt(1 / (2.7 * 0.7))
    for sign, off in both_sides(DECADES):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        tensor = axes * (1.0, 2.0, 2.7) @ axes.T
        tensor = 0.5 * (tensor + tensor.T)
        omega = np.linalg.eigh(tensor)[1] @ (1.0, 0.7, edge * (1 + sign * off))
        yield Body(tuple(map(tuple, tensor.tolist())), tuple(omega.tolist()))


@pytest.mark.parametrize("seed", range(2))
def test_rounded_tensors_are_true_a_hair_off_the_separatrix(seed):
    for body in tensors_beside_the_separatrix(seed):
        assert_true(body, times(body, ANY_REGIME))


@pytest.mark.parametrize("scale", [1e-150, 1e150])
def test_scale_of_a_tensor_does_not_matter(scale):
    tensor = tuple(
        tuple(scale * entry for entry in row) for row in ((2, 0.1, 0.2), (0.1, 2.5, -0.3), (0.2, -0.3, 3))
    )
    body = Body(tensor, RATE)
    assert_true(body, times(body, (3.0, 1e9)))


@pytest.mark.parametrize(
    "body", **each({name: NAMED[name] for name in ("short axis", "separatrix", "sphere")})
)
def test_both_parts_of_a_time_reach_the_phase(body):
    """A TimeDelta holds days in two parts, 86400 times their exact sum in seconds."""
    delta = TimeDelta([1e4, -1e4, 3.0], [0.1, 1 / 3, 1e-20], format="jd")
    q = motion(body).at(delta).quaternion("wxyz")
    for k, (day, rest) in enumerate(zip(delta.jd1.tolist(), delta.jd2.tolist(), strict=True)):
        seconds = 86400 * (Fraction(day) + Fraction(rest))
        expected, _ = truth.attitude_and_rate(*body, ATTITUDE, seconds)
        assert truth.attitude_error(q[k].tolist(), expected) <= ATTITUDE_TOLERANCE


def test_truth_can_tell_a_wrong_answer():
    """One ulp of a rate, 1e9 rad on, is a million tolerances: what passes here is not luck."""
    body = NAMED["short axis"]
    w1, w2, w3 = body.omega
    later = times(body, (1e9,))
    q, _ = sample(Body(body.inertia, (math.nextafter(w1, 1), w2, w3)), later)
    expected, _ = truth.attitude_and_rate(*body, ATTITUDE, later[0])
    assert truth.attitude_error(q[0].tolist(), expected) > 1e6 * ATTITUDE_TOLERANCE
    assert errors(body, later).attitude <= ATTITUDE_TOLERANCE
