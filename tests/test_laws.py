"""Laws that free rotation obeys, over many bodies: symmetries, the flow, conservation, smoothness in time."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.bodies import (
    ATTITUDE_TOLERANCE,
    CONSTANT_RATE,
    LONG_AXIS,
    NAMED,
    RATE_TOLERANCE,
    SHORT_AXIS,
    Body,
    angle_between,
    conjugate,
    distance,
    each,
    fastest,
    motion,
    product,
    sample,
    speed,
    unit,
)

EPS = 2.0**-52
# Two answers to one question, each within tolerance of the truth.
SAME_ATTITUDE = 2 * ATTITUDE_TOLERANCE
SAME_RATE = 2 * RATE_TOLERANCE

laws = settings(max_examples=100, deadline=None, derandomize=True, database=None)

# Inputs of few bits, so that the symmetries act on them without rounding; degenerate bodies turn up too.
small = st.integers(-24, 24).map(lambda n: n / 8)
attitudes = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: math.hypot(*q) > 0.1).map(unit)
rates = st.tuples(small, small, small)


@st.composite
def moments(draw):
    """Sums of two of three masses, the third among them at most 24 times the others."""
    a, b, c = draw(st.tuples(*[st.integers(1, 24)] * 3))
    return (b + c) / 4, (c + a) / 4, (a + b) / 4


bodies = st.builds(Body, moments(), rates)
angles = st.one_of(st.floats(-10, 10), st.floats(-1e9, 1e9))


def seconds(body, angle):
    """A time in which the body turns about that far, of so few bits that small factors leave it exact."""
    return math.ldexp(round(angle / speed(body) * 2**10), -10)


def assert_same(answer, expected, attitude=SAME_ATTITUDE, rate=SAME_RATE):
    """Attitudes with their signs, and rates."""
    assert np.all(angle_between(answer[0], expected[0]) <= attitude)
    assert np.all(distance(answer[1], expected[1]) <= rate)


# The flow


@laws
@given(bodies, attitudes, st.floats(20, 1e9), st.floats(-3, 3), st.sampled_from([1, -1]))
def test_a_motion_restarted_on_its_way_goes_on(body, attitude, first, further, direction):
    """q(t2; q0) = q(t2 - t1; q(t1; q0)), however far t1 is.

    The restart takes the rate with its rounding, which grows by Gronwall's exp(sqrt(2) W t) at most: W bounds
    the rate, and no Euler factor of a real body exceeds one. t2 - t1 is exact since t2 / 2 < t1 < 2 t2.
    """
    t1 = direction * first / speed(body)
    t2 = t1 + further / speed(body)
    q1, omega1 = sample(body, t1, attitude)
    restarted = Body(body.inertia, tuple(omega1.tolist()))
    W, t = fastest(body), abs(t2 - t1)
    grown = 2 * RATE_TOLERANCE * math.exp(math.sqrt(2) * W * t) * (speed(restarted) / speed(body))
    assert_same(
        sample(restarted, t2 - t1, tuple(q1.tolist())),
        sample(body, t2, attitude),
        attitude=3 * ATTITUDE_TOLERANCE + grown * speed(body) * t,
        rate=SAME_RATE + grown * W / speed(body),
    )


@laws
@given(bodies, attitudes, angles)
def test_turned_back_a_body_retraces_its_way(body, attitude, angle):
    """omega -> -omega, t -> -t."""
    t = seconds(body, angle)
    reversed_body = Body(body.inertia, tuple(-rate for rate in body.omega))
    q, omega = sample(reversed_body, -t, attitude)
    assert_same((q, -omega), sample(body, t, attitude))


# Scales


@laws
@given(bodies, attitudes, angles, st.integers(-200, 200), st.integers(-200, 200))
def test_powers_of_two_in_moments_and_time_change_no_bit(body, attitude, angle, of_moments, of_time):
    t = seconds(body, angle)
    scaled = Body(
        tuple(math.ldexp(moment, of_moments) for moment in body.inertia),
        tuple(math.ldexp(rate, -of_time) for rate in body.omega),
    )
    q, omega = sample(scaled, math.ldexp(t, of_time), attitude)
    expected_q, expected_omega = sample(body, t, attitude)
    np.testing.assert_array_equal(q, expected_q)
    np.testing.assert_array_equal(np.ldexp(omega, of_time), expected_omega)


@laws
@given(bodies, attitudes, angles, st.sampled_from([3, 7, 10]))
def test_only_ratios_of_moments_matter(body, attitude, angle, factor):
    t = seconds(body, angle)
    scaled = Body(tuple(factor * moment for moment in body.inertia), body.omega)
    assert_same(sample(scaled, t, attitude), sample(body, t, attitude))


@laws
@given(bodies, attitudes, angles, st.sampled_from([3, 7, 10]))
def test_a_faster_body_does_the_same_sooner(body, attitude, angle, factor):
    t = seconds(body, angle)
    faster = Body(body.inertia, tuple(factor * rate for rate in body.omega))
    q, omega = sample(faster, t, attitude)
    assert_same((q, omega / factor), sample(body, factor * t, attitude))


# Axes of the body

CUBE = Rotation.create_group("O")
CUBE_MATRICES = np.rint(CUBE.as_matrix())
# Components of the turns of the cube are 0, 1/2, sqrt(1/2), 1: four products of a quaternion with them round.
TURNED_ROUNDING = 8 * EPS


@settings(laws, max_examples=25)
@given(bodies, attitudes, angles)
def test_order_and_signs_of_axes_do_not_matter(body, attitude, angle):
    """Body axes renamed by each proper signed permutation R: v' = R v, q' = q * conj(q_R)."""
    t = seconds(body, angle)
    q, omega = sample(body, t, attitude)
    back = CUBE.inv().as_quat(scalar_first=True)
    for R, q_back in zip(CUBE_MATRICES, back, strict=True):
        turned = Body(tuple(abs(R) @ body.inertia), tuple(R @ body.omega))
        turned_q, turned_omega = sample(turned, t, unit(product(attitude, q_back).tolist()))
        expected = product(q, q_back), omega @ R.T
        assert_same((turned_q, turned_omega), expected, attitude=SAME_ATTITUDE + TURNED_ROUNDING)


@laws
@given(bodies, attitudes, angles, st.tuples(*[st.integers(-3, 3)] * 4).filter(any))
def test_a_tensor_turned_with_the_body_gives_the_same_motion(body, attitude, angle, turn):
    """An integer quaternion of norm N gives an integer N R: N^2 R I R^T and N R omega are exact.

    They belong to moments N^2 I and rate N omega.
    """
    w, x, y, z = turn
    norm = w * w + x * x + y * y + z * z
    NR = np.rint(norm * Rotation.from_quat(turn, scalar_first=True).as_matrix())
    t = seconds(body, angle / norm)
    straight = Body(body.inertia, tuple(norm * rate for rate in body.omega))
    turned = Body((NR * body.inertia) @ NR.T, tuple(NR @ body.omega))
    q_back = np.array([w, -x, -y, -z]) / math.sqrt(norm)
    q, omega = sample(straight, t, attitude)
    expected = product(q, q_back), omega @ NR.T / norm
    answer = sample(turned, t, unit(product(attitude, q_back).tolist()))
    assert_same(answer, expected, SAME_ATTITUDE + TURNED_ROUNDING, SAME_RATE + TURNED_ROUNDING)


@laws
@given(bodies, attitudes, attitudes, angles)
def test_a_turn_of_the_inertial_frame_turns_the_answer(body, attitude, turn, angle):
    t = seconds(body, angle)
    q, omega = sample(body, t, attitude)
    turned = sample(body, t, unit(product(turn, attitude).tolist()))
    assert_same(turned, (product(turn, q), omega), attitude=SAME_ATTITUDE + TURNED_ROUNDING)


# Conservation

TENSOR = Body(((2.0, 0.3, -0.2), (0.3, 2.5, 0.1), (-0.2, 0.1, 1.5)), (0.4, -0.9, 0.3))
NEEDLE = Body((1e-3, 1.0, 1.0005), (3.0, 0.4, -0.8))
CONSERVING = {name: NAMED[name] for name in NAMED if name != "rest"} | {"tensor": TENSOR, "needle": NEEDLE}

SAMPLES, SPAN = 200_000, 1e9
SPREAD = 4e-15
# A least-squares slope times the span: white noise of 2.5e-16 a sample would leave 2e-18.
TREND = 1e-17


@pytest.mark.parametrize("body", **each(CONSERVING))
def test_momentum_and_energy_neither_spread_nor_drift_over_1e9_s(body):
    motion_ = motion(body)
    ephemeris = motion_.at(np.linspace(0.0, SPAN, SAMPLES))
    momentum, energy = motion_.angular_momentum, motion_.kinetic_energy
    off_momentum = (ephemeris.angular_momentum - momentum) / np.linalg.norm(momentum)
    off_energy = ephemeris.kinetic_energy / energy - 1
    assert np.max(np.linalg.norm(off_momentum, axis=1)) <= SPREAD
    assert np.max(np.ptp(off_momentum, axis=0)) <= SPREAD
    assert np.ptp(off_energy) <= SPREAD
    when = np.linspace(-0.5, 0.5, SAMPLES)
    for off in (*off_momentum.T, off_energy):
        assert abs(when @ (off - off.mean())) / (when @ when) <= TREND


# Smoothness in time


def binary_step(body, radians):
    """The power of two, s, in which a body turns at most so far: its multiples are exact instants."""
    return 2.0 ** math.floor(math.log2(radians / speed(body)))


# Twice weights that sum to 110/60, over a step of at least 2^-8 rad, on quaternions off by 5e-16 at worst;
# the sixth-order difference itself is off by some (2^-7)^6 / 140 = 2e-15.
DERIVATIVE_TOLERANCE = 2 * 110 / 60 * 2**8 * 5e-16
WEIGHTS = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60


@pytest.mark.parametrize("body", **each(NAMED | {"tensor": TENSOR}))
def test_body_rate_is_twice_conj_q_times_the_derivative_of_q(body):
    """dq/dt = q omega / 2, the convention of every output."""
    h = binary_step(body, 2.0**-7)
    for t in 100 * h * np.arange(-30, 31):
        q, omega = sample(body, t + h * np.arange(-3, 4))
        twice = 2 * product(conjugate(q[3]), WEIGHTS @ q / h)
        assert distance(twice, [0.0, *omega[3]]) <= DERIVATIVE_TOLERANCE


FAR = 2.0**30


@pytest.mark.parametrize("start", [0.0, -FAR, FAR], ids=["near", "long ago", "far ahead"])
@pytest.mark.parametrize("body", **each(NAMED))
def test_neighbouring_attitudes_never_flip_sign(body, start):
    """|dq/dt| = |omega| / 2 <= W / 2, so neighbours are at most W dt / 2 apart."""
    dt = 2.0**-5
    q, _ = sample(body, start + dt * np.arange(200_000))
    chord = np.max(np.linalg.norm(np.diff(q, axis=0), axis=1))
    assert chord <= fastest(body) * dt / 2 + 2 * ATTITUDE_TOLERANCE


# A fourth difference is at most 16 times a component's error, 2.5e-16 at worst against the truth, and as much
# again for good measure; the motion's own, (W h)^4 / 16 for a spin, is below 5e-16.
JITTER = 16 * 5e-16
TURN, WINDOW = 2e-4, 2**19


@pytest.mark.parametrize("start", [None, FAR], ids=["about the epoch", "far ahead"])
@pytest.mark.parametrize("body", **each(NAMED))
def test_no_component_jitters_across_wraps_of_any_phase(body, start):
    step = binary_step(body, TURN)
    first = -step * WINDOW / 2 if start is None else start
    q, omega = sample(body, first + step * np.arange(WINDOW))
    assert np.max(np.abs(np.diff(q, 4, axis=0))) <= JITTER
    assert np.max(np.abs(np.diff(omega, 4, axis=0))) <= JITTER * speed(body)


def test_jitter_is_looked_for_across_a_half_turn_of_every_polhode():
    for body in (SHORT_AXIS | LONG_AXIS).values():
        assert motion(body).polhode_period / 2 < binary_step(body, TURN) * WINDOW


@pytest.mark.parametrize("body", **each(CONSTANT_RATE))
def test_constant_rate_is_constant_to_the_bit(body):
    _, omega = sample(body, np.linspace(-1e9, 1e9, 1001))
    np.testing.assert_array_equal(omega, np.broadcast_to(body.omega, omega.shape))
