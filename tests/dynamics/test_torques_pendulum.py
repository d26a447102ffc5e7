"""Gravity gradient on a circular orbit: the pendulum, small motions, stability, and the Jacobi integral."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

from attitude.frames import rotations
from attitude.kernels.layout import EffectCode
from tests.dynamics.motions import Rows, initial_state, integrate_arc, kepler, matrix

MU, RADIUS = 3.986004418e14, 6978136.3
COURSE = kepler(MU, RADIUS)
N = 2.0 * np.pi / COURSE.period
TORQUES = (Rows(EffectCode.GRAVITY_GRADIENT, MU),)
# The orbit's frame at t = 0, where the body is at x and moves along y: columns x along the track, y against
# the orbit's normal, z down.
LEVEL = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def product(p, q):
    return rotations.product(np.asarray(p), np.asarray(q))


def level(t):
    """Attitude of the orbit's frame, wxyz."""
    half = 0.5 * N * t
    return product((np.cos(half), 0.0, 0.0, np.sin(half)), rotations.from_matrix(LEVEL))


def turned(vector):
    """Quaternion of a rotation vector, rad."""
    angle = np.linalg.norm(vector)
    return np.concatenate([[np.cos(0.5 * angle)], np.sinc(0.5 * angle / np.pi) * 0.5 * np.asarray(vector)])


def released(moments, offset, relative_rate=(0.0, 0.0, 0.0), stop=0.0):
    """A body turned from the orbit's frame by a rotation vector, at a rate relative to that frame (body)."""
    q = product(level(0.0), turned(offset))
    rate = matrix(q).T @ np.array([0.0, 0.0, N]) + relative_rate
    return initial_state(moments, rate, q, stop=stop, orbit_path=COURSE)


def relative(rows, t):
    """(n, 4): attitude relative to the orbit's frame."""
    return np.array([product(rotations.conjugate(level(s)), q) for s, q in zip(t, rows[:4].T, strict=True)])


def pitch(rows, t):
    q = relative(rows, t)
    return 2.0 * np.arctan2(q[:, 2], q[:, 0])


# The pendulum


@pytest.mark.parametrize(
    ("moments", "degrees", "nT"),
    [
        ((12250.0, 12250.0, 500.0), 5, 3.71104178597),
        ((12250.0, 12250.0, 500.0), 30, 3.97504211928),
        ((12250.0, 12250.0, 500.0), 60, 5.08511862699),
        ((12250.0, 12250.0, 500.0), 85, 9.03534488122),
        *(((300.0, 410.0, 190.0), degrees, None) for degrees in (5, 30, 60, 85)),
    ],
)
def test_libration_in_pitch_has_the_period_of_a_pendulum(moments, degrees, nT):
    """Zeros of the pitch angle five periods apart, found in dense output."""
    amplitude, k_P = np.radians(degrees), (moments[0] - moments[2]) / moments[1]
    period = 4.0 * ellipk(np.sin(amplitude) ** 2) / (N * np.sqrt(3.0 * k_P))
    if nT is not None:
        assert N * period == pytest.approx(nT, abs=1e-11)
    body = released(moments, (0.0, amplitude, 0.0))
    stop, step = 6.0 * period, period / 60.0

    def angle(t):
        rows, work = integrate_arc(body, TORQUES, step, t, stop=stop)
        assert work.failed == 0
        return pitch(rows, [t])[0]

    first, last = (
        brentq(angle, (k + 0.2) * period, (k + 0.3) * period, xtol=1e-10 * period, rtol=1e-14) for k in (0, 5)
    )
    assert (last - first) / 5.0 == pytest.approx(period, rel=1e-10)
    # the first zero is a quarter of a period after the release
    assert first == pytest.approx(0.25 * period, rel=1e-10)


def test_pitch_returns_to_rest_at_the_amplitude_at_every_period():
    amplitude = np.radians(60.0)
    period = 4.0 * ellipk(np.sin(amplitude) ** 2) / (N * np.sqrt(3.0 * 11750.0 / 12250.0))
    t = period * np.arange(1, 21)
    rows, _ = integrate_arc(released((12250.0, 12250.0, 500.0), (0.0, amplitude, 0.0)), TORQUES, 60.0, t)
    assert np.abs(pitch(rows, t) - amplitude).max() < 1e-12
    # the rate in the plane; what rounding puts across it grows, as this pendulum is not stable sideways
    assert np.abs(rows[5] + N).max() < 1e-12 * N
    assert np.abs(rows[[4, 6]]).max() < 1e-9 * N


# Small roll and yaw, and stability

DELTA = 1e-4


def map_of(moments, seconds):
    """(6, 6): the linear map of a small (turn, rate / n) in the orbit's frame over a time, by central
    differences of the solver's motion; what is left is of second order in DELTA, 1e-8."""
    columns = []
    for i in range(6):
        ends = []
        for sign in (1.0, -1.0):
            small = np.zeros(6)
            small[i] = sign * DELTA
            body = released(moments, small[:3], small[3:] * N)
            rows, _ = integrate_arc(body, TORQUES, 0.5 / N, [seconds])
            q = relative(rows, [seconds])[0]
            down = matrix(rows[:4, 0]).T @ np.array([0.0, 0.0, N])
            ends.append(np.concatenate([2.0 * q[1:] * np.sign(q[0]), (rows[4:7, 0] - down) / N]))
        columns.append((ends[0] - ends[1]) / (2.0 * DELTA))
    return np.array(columns).T


def ratios(moments):
    """k_P, k_R, k_Y."""
    x, y, z = moments
    return (x - z) / y, (y - z) / x, (y - x) / z


@pytest.mark.parametrize("moments", [(300.0, 410.0, 190.0), (900.0, 1000.0, 200.0), (6.0, 6.6, 3.1)])
def test_small_roll_and_yaw_have_their_two_frequencies(moments):
    """s^4 + (1 + 3 k_R + k_R k_Y) n^2 s^2 + 4 k_R k_Y n^4 = 0, s^2 = -3 k_P n^2 in pitch.

    Eigenvalues of the map over a quarter of a radian of the orbit are exp(s t).
    """
    seconds = 0.25 / N
    k_P, k_R, k_Y = ratios(moments)
    squares = np.roots([1.0, 1.0 + 3.0 * k_R + k_R * k_Y, 4.0 * k_R * k_Y])
    expected = np.sqrt(np.sort([*(-squares), 3.0 * k_P]))
    eigenvalues = np.linalg.eigvals(map_of(moments, seconds))
    frequencies = np.sort(np.abs(np.angle(eigenvalues)))[::2] / 0.25
    assert np.abs(np.abs(eigenvalues) - 1.0).max() < 1e-7
    assert frequencies == pytest.approx(expected, rel=1e-6)


def is_stable(moments):
    """DeBra and Delp, J. Astronaut. Sci. 8 (1961) 14."""
    k_P, k_R, k_Y = ratios(moments)
    return bool(k_P > 0.0 and k_R * k_Y > 0.0 and 1.0 + 3.0 * k_R + k_R * k_Y > 4.0 * np.sqrt(k_R * k_Y))


def margin(moments):
    """How far from the boundaries: the least of the numbers that change sign there."""
    k_P, k_R, k_Y = ratios(moments)
    last = 1.0 + 3.0 * k_R + k_R * k_Y - 4.0 * np.sqrt(max(k_R * k_Y, 0.0))
    return min(abs(k_P), abs(k_R), abs(k_Y), abs(last), abs(k_R - k_Y))


def random_bodies(count):
    """Moments that a body can have, no nearer than 0.03 to a boundary of stability; half of them stable."""
    rng = np.random.default_rng(20)
    found = {True: [], False: []}
    while min(map(len, found.values())) < count // 2:
        a, b, c = rng.uniform(0.02, 1.0, 3)
        moments = (b + c, c + a, a + b)
        if margin(moments) > 0.03:
            found[is_stable(moments)].append(moments)
    return found[True][: count // 2] + found[False][: count // 2]


def test_two_hundred_bodies_are_stable_where_debra_and_delp_say_so():
    """Spectral radius of the map over a radian of the orbit: one, or by the margin at least 1.1."""
    for moments in random_bodies(200):
        radius = np.abs(np.linalg.eigvals(map_of(moments, 1.0 / N))).max()
        assert radius < 1.0 + 1e-7 if is_stable(moments) else radius > 1.1, moments


# Jacobi's integral


def jacobi(rows, t, moments):
    """w.I.w / 2 - N.I w + (3 n^2 / 2) e.I e over n^2 I, N the orbit's rate, e the direction of the centre:
    constant on a circular orbit (Hughes 2004, section 9.2)."""
    moments = np.array(moments)
    q, w = rows[:4], rows[4:7]
    # turns/s in two parts: the time in doubles is exact, a product with it in doubles is not
    high, low = (np.longdouble(number) for number in COURSE.numbers[4:6])
    phase = 2.0 * np.pi * ((np.longdouble(t) * (high + low)) % 1.0).astype(float)
    R = np.array([matrix(column).T for column in q.T])
    normal = R[:, :, 2]
    e = np.einsum("nij,jn->ni", R, np.array([np.cos(phase), np.sin(phase), 0.0 * phase]))
    kinetic = 0.5 * (moments * w.T**2).sum(axis=1) - N * (normal * moments * w.T).sum(axis=1)
    return (kinetic + 1.5 * N * N * (moments * e * e).sum(axis=1)) / (N * N * moments.max())


@pytest.mark.parametrize("moments", [(12250.0, 12250.0, 500.0), (300.0, 410.0, 190.0)])
def test_jacobi_integral_stays_over_a_thousand_orbits(moments):
    """And without trend: by the line fitted to it, it changes by a tenth of that (1e5 orbits: benchmarks)."""
    body = released(moments, (0.3, 0.6, -0.4), (0.1 * N, 0.0, 0.2 * N))
    t = np.linspace(0.0, 1000.0, 2001) * COURSE.period
    rows, work = integrate_arc(body, TORQUES, 0.5 / N, t)
    J = jacobi(rows, t, moments)
    assert work.failed == 0
    assert np.abs(J - J[0]).max() < 1e-11
    assert abs(np.polyfit(t, J, 1)[0] * t[-1]) < 2e-12
    assert np.ptp(matrix(rows[:4, -1])) > 0.1
