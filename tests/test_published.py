"""Published motions, each by the source beside it, and the route of the paper this project grew from."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import RigidBody, TorqueFreeMotion
from attitude.oracle import truth
from tests.bodies import (
    ATTITUDE_TOLERANCE,
    GENERIC,
    RATE_TOLERANCE,
    Body,
    each,
    motion,
    product,
    sample,
    times,
)
from tests.oracles import published_mpmath

IDENTITY = (1.0, 0.0, 0.0, 0.0)
DEGREE = math.pi / 180


# The published route


def assert_as_published(body, t, attitude):
    for instant, q, omega in zip(t, *sample(body, t, attitude), strict=True):
        expected = published_mpmath.attitude_and_rate(*body, attitude, instant, digits=50)
        assert truth.attitude_error(q.tolist(), expected[0]) <= ATTITUDE_TOLERANCE
        assert truth.rate_error(omega.tolist(), expected[1]) <= RATE_TOLERANCE


@pytest.mark.parametrize("body", **each(GENERIC))
def test_named_bodies_move_as_van_zon_and_schofield_published(body):
    """J. Comput. Phys. 225 (2007) 145, mended and carried to 50 digits."""
    assert_as_published(body, times(body, (0.0, 2.0, -37.0, 1e6, 1e9)), (0.1, -0.7, 0.5, 0.5))


# Published motions

BRICK = Body((0.001894220, 0.006211019, 0.007194665), (10 * DEGREE, 20 * DEGREE, 30 * DEGREE))
# Sixteen digits are printed; the last of them and the rounding of the rates to radians, over 20 rad.
BRICK_TOLERANCE = 4e-15


def test_nasa_tumbling_brick_after_30_s():
    """Murri, Jackson & Shelton, NASA/TM-2015-218675 (2015), check case 2: the state of a free brick."""
    q, omega = sample(BRICK, 30.0, IDENTITY)
    printed = (-0.8811471853104235, 0.4701825277666925, 0.01172825232487118, 0.04868753947208377)
    printed_omega = (12.61839077591422, -17.39747476161139, 31.11958888694434)
    np.testing.assert_allclose(q, printed, rtol=0, atol=BRICK_TOLERANCE)
    np.testing.assert_allclose(omega / DEGREE, printed_omega, rtol=0, atol=40 * BRICK_TOLERANCE)


def test_nasa_tumbling_brick_has_the_periods_of_its_elliptic_integrals():
    """The same brick: 4K/u', and the turn of its long axis about the momentum."""
    brick = motion(BRICK)
    assert brick.polhode_period == pytest.approx(17.384489271939, abs=5e-13)
    assert 2 * math.pi / brick.mean_precession_rate == pytest.approx(10.076492250293, abs=5e-13)


def test_basilisk_spacecraft_after_10_s():
    """Basilisk, test_spacecraft.py, torque-free case: modified Rodrigues parameters vec(q) / (1 + q0).

    Its own fourth-order integration is printed to 1e-11 or so.
    """
    q, _ = sample(Body((500.0, 200.0, 300.0), (0.5, -0.4, 0.7)), 10.0, IDENTITY)
    q = q if q[0] > 0 else -q
    expected = (0.37303428489, -0.00239564413135, 0.208570797155)
    np.testing.assert_allclose(q[1:] / (1 + q[0]), expected, rtol=0, atol=2e-12)


@pytest.fixture(scope="module")
def toutatis():
    """State of 1992: Takahashi, Busch & Scheeres, Astron. J. 146 (2013) 95; seconds stand for days."""
    attitude = Rotation.from_euler("ZXZ", [145.498, 65.865, 241.524], degrees=True)
    omega = np.array([14.51, 33.529, -98.709]) * DEGREE
    return TorqueFreeMotion(RigidBody([3.0836, 3.235, 1.0]), attitude, omega, frame="ECLIPJ2000")


def test_toutatis_has_its_two_published_periods(toutatis):
    """Zhao et al., MNRAS 450 (2015) 3620: 5.38 +- 0.03 d about the long axis, 7.40 +- 0.03 d of that axis."""
    assert toutatis.regime == "long_axis"
    precession = 2 * math.pi / toutatis.mean_precession_rate
    assert toutatis.polhode_period == pytest.approx(5.38, abs=0.03)
    assert precession == pytest.approx(7.40, abs=0.03)
    assert toutatis.polhode_period == pytest.approx(5.3685303135, abs=5e-11)
    assert precession == pytest.approx(7.4116522679, abs=5e-11)


def test_toutatis_turns_about_its_published_momentum(toutatis):
    """Takahashi et al. print ecliptic longitude 180.2, latitude -54.75 deg.

    The state they print gives it to within 1.2 deg, which shows that its angles are relative to the ecliptic.
    """
    momentum = toutatis.at([0.0, 3.3, 1e4]).angular_momentum
    longitude = np.degrees(np.arctan2(momentum[:, 1], momentum[:, 0])) % 360
    latitude = np.degrees(np.arctan2(momentum[:, 2], np.hypot(momentum[:, 0], momentum[:, 1])))
    np.testing.assert_allclose(longitude, 181.0295740, rtol=0, atol=5e-8)
    np.testing.assert_allclose(latitude, -53.6205932, rtol=0, atol=5e-8)
    assert abs(longitude[0] - 180.2) * math.cos(54.75 * DEGREE) < 1.0
    assert abs(latitude[0] + 54.75) < 1.2


def halley():
    """1P/Halley, Belton et al., Icarus 93 (1991) 183, as a prolate body with the momentum along z.

    Long axis 66.0 deg from the momentum, 3.69 d about it, 7.1 d about itself; days as seconds.
    """
    about_momentum, about_itself = 2 * math.pi / 3.69, 2 * math.pi / 7.1
    along = about_momentum * math.cos(66 * DEGREE) + about_itself
    moment = along / (about_momentum * math.cos(66 * DEGREE))
    attitude = Rotation.from_euler("ZXZ", [0, 66, 0], degrees=True)
    omega = [0.0, about_momentum * math.sin(66 * DEGREE), along]
    return TorqueFreeMotion(RigidBody([moment, moment, 1.0]), attitude, omega)


def test_halley_turns_once_in_2_84_days_about_an_axis_21_4_deg_from_its_momentum():
    comet = halley()
    ephemeris = comet.at(np.linspace(0, 100, 37))
    assert 2 * math.pi / comet.mean_precession_rate == pytest.approx(3.69, rel=1e-14)
    assert comet.polhode_period == pytest.approx(7.1, rel=1e-14)
    np.testing.assert_allclose(comet.nutation_range, 66 * DEGREE, rtol=1e-14)
    omega = ephemeris.angular_velocity.copy()  # scipy rotates no read-only vectors
    np.testing.assert_allclose(2 * math.pi / np.linalg.norm(omega, axis=1), 2.836, rtol=0, atol=5e-4)
    inertial = ephemeris.rotation.apply(omega)
    off = np.degrees(np.arctan2(np.hypot(inertial[:, 0], inertial[:, 1]), inertial[:, 2]))
    np.testing.assert_allclose(off, 21.40, rtol=0, atol=5e-3)


def dzhanibekov():
    """I = (3, 5, 9), L = (0, 2, 0.01), with 1/9 added to each inverse moment.

    Those moments break the triangle inequality; the sum leaves the path of L as it is, since L x L = 0.
    """
    inverse = np.array([1 / 3, 1 / 5, 1 / 9]) + 1 / 9
    return Body(tuple(1 / inverse), tuple(np.array([0.0, 2.0, 0.01]) * inverse))


def test_dzhanibekov_flips_twice_in_118_s():
    """A wing nut's flip: 4K/u' by the elliptic integral of these numbers."""
    flipping = motion(dzhanibekov())
    period = flipping.polhode_period
    # an ulp of a moment moves D, 1e-5 of L^2, by 2e-11 of itself, and the period by some 1e-10 s
    assert period == pytest.approx(118.11088704639, abs=1e-10)
    facing = flipping.at(period * np.array([0.0, 0.25, 0.5, 0.75, 1.0])).angular_velocity[:, 1]
    np.testing.assert_allclose(facing / facing[0], [1, 0, -1, 0, 1], rtol=0, atol=1e-11)


# Kane, Likins & Levinson, Spacecraft Dynamics (McGraw-Hill, 1983), the symmetric top: I across, J along z.
TOPS = {
    "rod": (0.04, 0.02, (0.3, -0.2, 1.0)),
    "disc": (0.04, 0.07, (0.3, -0.2, 1.0)),
    "nearly a sphere": (0.04, 0.04 * (1 + 2**-40), (-0.3, 0.2, 0.7)),
}
# Angles of 40 rad in double: an ulp of 7e-15, in each of two turns.
TOP_TOLERANCE = 3e-14


@pytest.mark.parametrize(("across", "along", "omega"), **each(TOPS))
def test_a_symmetric_top_turns_as_kane_likins_and_levinson_have_it(across, along, omega):
    """Body rates turn at s = wz (I - J)/I; the axis precesses at sqrt(wx^2 + wy^2 + (wz J/I)^2)."""
    t = np.linspace(-30, 40, 50)
    wx, wy, wz = omega
    s = wz * (across - along) / across
    momentum = np.array([wx, wy, wz * along / across])
    precession = np.linalg.norm(momentum)
    top = TorqueFreeMotion(RigidBody([across, across, along]), IDENTITY, omega, order="wxyz")
    c, si = np.cos(s * t), np.sin(s * t)
    expected = np.stack([wx * c + wy * si, wy * c - wx * si, np.full_like(t, wz)], axis=-1)
    ephemeris = top.at(t)
    np.testing.assert_allclose(ephemeris.angular_velocity, expected, rtol=0, atol=TOP_TOLERANCE)
    about_momentum = np.sin(precession * t / 2)[:, None] * momentum / precession
    about_momentum = np.concatenate([np.cos(precession * t / 2)[:, None], about_momentum], axis=1)
    nothing = np.zeros_like(t)
    about_axis = np.stack([np.cos(s * t / 2), nothing, nothing, np.sin(s * t / 2)], axis=-1)
    expected_q = product(about_momentum, about_axis)
    np.testing.assert_allclose(ephemeris.quaternion("wxyz"), expected_q, rtol=0, atol=TOP_TOLERANCE)
    assert top.polhode_period == pytest.approx(2 * math.pi / abs(s), rel=1e-14)
