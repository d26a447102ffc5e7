"""Ephemerides in other frames, against astropy, SPICE and Orekit; rates, against derivatives of attitudes."""

import math
import pickle

import astropy.units as u
import erfa
import numpy as np
import pytest
from astropy.coordinates import GCRS, ITRS, TEME, CartesianRepresentation
from astropy.coordinates.builtin_frames import intermediate_rotation_transforms as matrices
from astropy.time import Time, TimeDelta
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, InputError, RegimeError, RigidBody, Scene, TorqueFreeMotion
from attitude.frames import earth_orientation, rotations
from attitude.frames.earth_fixed import itrf, teme
from attitude.frames.inertial import from_gcrf
from attitude.frames.rotations import conjugate
from attitude.orbit.local_frames import qsw
from attitude.orbit.path_states import position, velocity
from attitude.samples.event import Event
from attitude.samples.transform import rotation_between
from attitude.samples.translation import Translation
from attitude.times.instants import as_instants
from tests.effects.scenes import DOCUMENT, KEPLER, effect, quantity, scene
from tests.effects.test_orbit import TLES, path, start_of, tle_path

EPOCH = Time("2026-03-20T12:00:00", scale="utc")
INERTIAL = ("ICRF", "GCRF", "EME2000", "ECLIPJ2000")
OF_DATE = ("TEME", "ITRF")
LOCAL = ("QSW", "LVLH")
DAY = 86400.0
# Eighth-order weights of a derivative by central differences, for steps of 1 to 4 (Fornberg 1988).
WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])


pytestmark = pytest.mark.usefixtures("offline")


def motion(epoch=EPOCH, frame="GCRF", rate=(2e-3, -1e-3, 3e-3)):
    return TorqueFreeMotion(
        RigidBody([1.0, 2.0, 2.5]), (0.5, 0.1, -0.7, 0.5), rate, epoch, order="wxyz", frame=frame
    )


def orbiting(orbit=KEPLER, frame="GCRF", stop=6000.0, count=31, **changes):
    """A free body whose scene has an orbit."""
    times = {"start": 0, "stop": stop, "count": count, "unit": "s"}
    return Scene.model_validate({**DOCUMENT, "orbit": orbit, "frame": frame, "times": times, **changes})


def flown(name="Molniya", **changes):
    """A free body on the orbit of a TLE, an hour after its epoch."""
    dated = {"time": (start_of(TLES[name]) + TimeDelta(3600.0, format="sec")).isot, "scale": "utc"}
    return orbiting({"tle": list(TLES[name])}, epoch=dated, **changes)


def axes(frame):
    """(3, 3) from components in GCRF."""
    return from_gcrf(frame, "a test")


def matrix(turn):
    return Rotation.from_quat(turn.quaternion, scalar_first=True).as_matrix()


def bits(ephemeris):
    return ephemeris.quaternion("wxyz").tobytes(), ephemeris.angular_velocity.tobytes()


def derivative(attitude, t, step):
    """2 conj(q) dq/dt from attitudes, (n,) s -> (n, 4) wxyz, at instants around each of t."""
    dq = sum(w * (attitude(t + k * step) - attitude(t - k * step)) for k, w in enumerate(WEIGHTS, 1)) / step
    w, x, y, z = attitude(t).T
    rows = np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
    return 2.0 * np.einsum("ijn,nj->ni", rows, dq)


def numerical_rate(ephemeris, step):
    return derivative(lambda t: ephemeris.resampled(t).quaternion("wxyz"), ephemeris.elapsed, step)


def no_flip(ephemeris):
    q = ephemeris.quaternion("wxyz")
    return ((q[1:] * q[:-1]).sum(axis=-1) > 0.0).all()


# -- inertial frames ------------------------------------------------------------------------------


def test_axes_of_the_ecliptic_are_those_of_spice():
    spice = pytest.importorskip("spiceypy")
    expected = spice.pxform("J2000", "ECLIPJ2000", 0.0)
    assert np.abs(axes("ECLIPJ2000") - expected).max() < 2e-16


def test_mean_equator_of_j2000_is_off_by_the_frame_bias():
    bias = axes("EME2000")
    # 16.6 and 6.8 mas of the pole, 14.6 mas of the equinox (IERS Conventions 2010, section 5.3.1)
    angle = Rotation.from_matrix(bias).magnitude() / (math.pi / 648e6)
    assert angle == pytest.approx(math.hypot(16.617, 6.819, 14.6), abs=0.01)
    assert np.abs(bias - erfa.bp00(2451545.0, 0.0)[0]).max() < 1e-12  # IAU 2000's has other digits


@pytest.mark.parametrize("frame", INERTIAL)
@pytest.mark.parametrize("source", INERTIAL)
def test_vectors_are_the_same_in_every_inertial_frame(source, frame):
    original = motion(frame=source, epoch=None).at(np.linspace(-1e3, 1e3, 7))
    transformed = original.in_frame(frame)
    v = np.array([0.3, -0.2, 0.9])
    turn = axes(frame) @ axes(source).T
    assert np.abs(transformed.rotation.apply(v) - original.rotation.apply(v) @ turn.T).max() < 5e-16
    assert transformed.frame == frame
    assert transformed.angular_velocity.tobytes() == original.angular_velocity.tobytes()
    assert np.abs(transformed.angular_momentum - original.angular_momentum @ turn.T).max() < 1e-17
    assert np.array_equal(transformed.kinetic_energy, original.kinetic_energy)
    back = transformed.in_frame(source)
    assert np.abs(back.quaternion("wxyz") - original.quaternion("wxyz")).max() < 5e-16


@pytest.mark.parametrize("frame", ["ICRF", "GCRF"])
def test_another_name_for_the_same_axes_changes_no_bit(frame):
    original = motion(frame="GCRF").at([1.0, 2.0])
    assert bits(original.in_frame(frame)) == bits(original)
    assert original.in_frame("GCRF") is original


def test_ecliptic_of_a_body_in_the_equator():
    """The x axes are the same, the ecliptic's y is up from the equator's by the obliquity."""
    upright = TorqueFreeMotion(RigidBody([1, 2, 2.5]), (1, 0, 0, 0), (0, 0, 0), order="wxyz", frame="ICRF")
    half = math.radians(84381.448 / 3600) / 2
    q = upright.at(0.0).in_frame("ECLIPJ2000").quaternion("wxyz")
    assert q == pytest.approx([math.cos(half), -math.sin(half), 0, 0], abs=1e-16)


# -- frames of date -------------------------------------------------------------------------------


def spread():
    """Since 1976; and the predictions of the tables, as far as they go."""
    until = Time(earth_orientation.longest().mjd[-1] - 1.0, format="mjd", scale="utc")
    predicted = (until - TimeDelta(np.linspace(0, 300 * DAY, 20), format="sec") - EPOCH.tai).to_value(u.s)
    return np.concatenate([np.linspace(-50 * 365.25 * DAY, 0, 60), np.linspace(0, DAY, 40), predicted])


def test_earth_fixed_axes_are_those_of_astropy():
    instants = as_instants(spread(), EPOCH)
    expected = matrices.cirs_to_itrs_mat(instants.time) @ matrices.gcrs_to_cirs_mat(instants.time)
    # the Earth rotation angle of erfa, of 1e4 days, is good to 3e-14
    assert np.abs(matrix(itrf(instants)) - expected).max() < 1e-13


def test_axes_of_sgp4_are_those_of_astropy():
    instants = as_instants(spread(), EPOCH)
    time = instants.time
    actual = matrix(itrf(instants)) @ np.swapaxes(matrix(teme(instants)), -1, -2)
    # astropy leaves out the locator of the crust's pole there, 47 microarcseconds a century
    locator = erfa.sp00(time.tt.jd1, time.tt.jd2)
    without = actual @ np.stack([Rotation.from_euler("z", angle).as_matrix() for angle in locator])
    # UTC for UT1: 0.9 s at 7e-12 rad/s
    assert np.abs(without - matrices.teme_to_itrs_mat(time)).max() < 1e-11


def test_vectors_go_where_astropy_takes_them():
    when = EPOCH + TimeDelta(np.linspace(0, 3 * DAY, 20), format="sec")
    original = motion().at(when)
    v = np.array([0.3, -0.2, 0.9])
    along = original.rotation.apply(v)
    gcrs = GCRS(CartesianRepresentation(along.T * u.km), obstime=when)
    for name, frame in (("ITRF", ITRS), ("TEME", TEME)):
        expected = gcrs.transform_to(frame(obstime=when)).cartesian.xyz.to_value(u.km).T
        assert np.abs(original.in_frame(name).rotation.apply(v) - expected).max() < 1e-10


def test_turn_between_computed_poles_is_that_at_the_instant():
    """The polynomial against the series themselves, at instants it does not go through."""
    instants = as_instants(np.linspace(-2e7, 2e7, 500) + 3333.0, EPOCH)
    time = instants.time
    expected = erfa.pnm06a(time.tt.jd1, time.tt.jd2)
    actual = matrix(teme(instants))
    utc = time.utc
    equinoxes = erfa.gst06a(utc.jd1, utc.jd2, time.tt.jd1, time.tt.jd2) - erfa.gmst82(utc.jd1, utc.jd2)
    turned = np.array([Rotation.from_euler("z", -angle).as_matrix() for angle in equinoxes]) @ expected
    assert np.abs(actual - turned).max() < 1e-13  # what the angles of erfa leave
    assert np.abs(actual[:, 2] - expected[:, 2]).max() < 2e-15


@pytest.mark.parametrize("frame", OF_DATE)
@pytest.mark.parametrize("source", ["GCRF", "ECLIPJ2000"])
def test_rates_are_the_derivative_of_the_attitude(frame, source):
    t = np.linspace(0.2, 0.8, 9) * DAY - 0.5 * DAY  # within one day of the tables
    transformed = motion(frame=source).at(t).in_frame(frame)
    actual = numerical_rate(transformed, 5.0)
    assert np.abs(actual - transformed.angular_velocity).max() < 1e-15
    if frame == "ITRF":  # and the Earth's rotation is in it
        assert np.abs(transformed.angular_velocity - motion().at(t).angular_velocity).max() > 5e-5


@pytest.mark.parametrize("frame", OF_DATE)
def test_frames_of_date_lead_back_and_from_one_to_the_other(frame):
    original = motion(frame="EME2000").at(np.linspace(-1e6, 1e6, 40))
    back = original.in_frame(frame).in_frame("EME2000")
    assert np.abs(back.quaternion("wxyz") - original.quaternion("wxyz")).max() < 1e-15
    assert np.abs(back.angular_velocity - original.angular_velocity).max() < 1e-18
    between = original.in_frame("TEME").in_frame("ITRF")
    straight = original.in_frame("ITRF")
    assert np.abs(between.quaternion("wxyz") - straight.quaternion("wxyz")).max() < 1e-15
    assert np.abs(between.angular_velocity - straight.angular_velocity).max() < 1e-18


def test_signs_are_continuous_over_many_days_whatever_is_asked_for_together():
    free = motion(rate=(1e-6, 2e-6, 1e-6))
    dense = free.at(np.linspace(-30 * DAY, 30 * DAY, 2001)).in_frame("ITRF")
    assert no_flip(dense)
    alone = [free.at(t).in_frame("ITRF").quaternion("wxyz") for t in dense.elapsed[::97]]
    assert np.array_equal(alone, dense.quaternion("wxyz")[::97])


@pytest.mark.parametrize("shape", [(), (3,), (2, 3), (0,)])
@pytest.mark.parametrize("frame", ["TEME", "ITRF", "EME2000"])
def test_batches_and_instants_of_any_shape(frame, shape):
    bodies = RigidBody.from_moments(np.array([[1, 2, 2.5], [1, 1.5, 2], [2, 2, 3.0], [1, 1, 1]]))
    t = np.arange(math.prod(shape), dtype=float).reshape(shape)
    rates = np.array([1e-3, 2e-3, 3e-3])
    batch = TorqueFreeMotion(bodies, (1, 0, 0, 0), rates, EPOCH, order="wxyz", frame="GCRF")
    transformed = batch.at(t).in_frame(frame)
    assert transformed.shape == (4, *shape)
    for i in range(4):
        alone = batch[i].at(t).in_frame(frame)
        assert np.array_equal(alone.quaternion("wxyz"), transformed.quaternion("wxyz")[i])
        assert np.array_equal(alone.angular_velocity, transformed.angular_velocity[i])


def test_instants_in_two_parts_keep_their_digits():
    """A second after thirty years, given as a Time: the Earth turns on by 15 arcseconds."""
    late = Time(EPOCH.jd1 - 10950, [0.25, 0.25 + 1 / 86400], format="jd", scale="tai")
    rate = (0.0, 0.0, 0.0)
    transformed = motion(rate=rate).at(late).in_frame("ITRF")
    turned = 2.0 * np.arcsin(
        np.linalg.norm((transformed.rotation[0].inv() * transformed.rotation[1]).as_quat()[:3])
    )
    assert turned == pytest.approx(np.linalg.norm(transformed.angular_velocity[0]), rel=2e-10)


def test_resampled_in_a_frame_is_the_frame_of_the_resampled():
    original = motion().at([0.0, 1.0])
    t = [5.0, 70.0, -3000.0]
    assert bits(original.in_frame("ITRF").resampled(t)) == bits(original.resampled(t).in_frame("ITRF"))
    assert original.in_frame("ITRF").in_frame("TEME").resampled(t).frame == "TEME"
    again = pickle.loads(pickle.dumps(original.in_frame("ITRF")))
    assert bits(again.resampled(t)) == bits(original.resampled(t).in_frame("ITRF"))


def test_attitudes_without_rates_have_none_elsewhere():
    original = motion().at([0.0, 1.0])
    only = Ephemeris(original.quaternion("wxyz").copy(), original.instants, "GCRF")
    transformed = only.in_frame("ITRF")
    assert not transformed.has_rate
    assert transformed.quaternion("wxyz").tobytes() == original.in_frame("ITRF").quaternion("wxyz").tobytes()
    assert not transformed.can_be_resampled


def test_momentum_is_asked_of_inertial_frames():
    transformed = motion().at([0.0]).in_frame("ITRF")
    for name in ("angular_momentum", "kinetic_energy"):
        with pytest.raises(RegimeError, match=f"{name}: ITRF is a rotating frame"):
            getattr(transformed, name)


def test_momentum_of_rotors_comes_back():
    made = scene(effect("wheels"), effect("constant_torque")).run()
    transformed = made.in_frame("ITRF")
    assert np.abs(transformed.in_frame("GCRF").angular_momentum - made.angular_momentum).max() < 1e-14
    turned = made.in_frame("ECLIPJ2000").angular_momentum
    assert np.abs(turned @ axes("ECLIPJ2000") - made.angular_momentum).max() < 1e-14


# -- what is refused ------------------------------------------------------------------------------


REFUSED = [
    *((frame, {}, "frame: a frame, one of ICRF, .*, LVLH; ") for frame in ("itrf", "", None, 3, ["ITRF"])),
    *((frame, {"frame": "INERTIAL"}, f"frame: .*got 'INERTIAL to {frame}'") for frame in ("ICRF", "ITRF")),
    ("INERTIAL", {}, r"frame: .*got '\w+ to INERTIAL'"),
    *((frame, {"epoch": None}, "epoch: a Time") for frame in OF_DATE),
    *((frame, {}, f"{frame} lies along an orbit, and this ephemeris") for frame in LOCAL),
]


@pytest.mark.parametrize(("frame", "changes", "message"), REFUSED)
def test_frame_that_is_unknown_undated_ones_own_or_without_an_orbit_is_refused(frame, changes, message):
    with pytest.raises(RegimeError if frame in LOCAL else InputError, match=message):
        motion(**changes).at([0.0]).in_frame(frame)


@pytest.mark.parametrize("when", ["1961-12-30T00:00:00", "2060-01-01T00:00:00"])
def test_earth_fixed_frame_beyond_the_tables_is_refused_saying_until_when(when):
    far = motion(epoch=Time(when, scale="tai"))
    with pytest.raises(InputError, match=rf"t: instants from 1962-01-01 to 20\d\d-.*, .*; got '{when}"):
        far.at([0.0, 1.0]).in_frame("ITRF")
    assert np.isfinite(far.at([0.0, 1.0]).in_frame("TEME").quaternion("wxyz")).all()


def test_nutation_is_not_extended_to_any_age():
    with pytest.raises(InputError, match=r"t: instants within 1000 years of J2000.0.*got '1\d\d\d.* years"):
        motion().at([0.0, 4e10]).in_frame("TEME")


@pytest.mark.parametrize("frame", ["GCRF", "ITRF", "QSW"])
def test_nothing_leads_back_from_axes_along_an_orbit(frame):
    with pytest.raises(RegimeError, match="no rotation from LVLH"):
        orbiting().run().in_frame("LVLH").in_frame(frame)


# -- along an orbit -------------------------------------------------------------------------------


def test_body_that_points_to_the_nadir_stands_still():
    """A circular orbit in the equator from x to y: forward is y, down is -x, and right of the way is -z."""
    a = 7e6
    n = math.sqrt(3.986004e14 / a**3)
    orbit = {"semi_major_axis": quantity(7000, "km")}
    standing = orbiting(
        orbit,
        stop=60000.0,
        count=8,
        attitude={"quaternion": [0.5, -0.5, -0.5, 0.5], "order": "wxyz"},
        angular_velocity={"value": [0, -n, 0], "unit": "rad/s"},
        body={"moments": [2, 3, 2.5], "unit": "kg m2"},
    ).run()
    body_axes = standing.rotation[0].apply(np.eye(3))
    assert body_axes == pytest.approx(np.array([[0, 1, 0], [0, 0, -1], [-1, 0, 0]]), abs=1e-15)
    transformed = standing.in_frame("LVLH")
    # the sign is that of a body which has gone round; ten revolutions at the rounding of n
    assert np.abs(np.abs(transformed.quaternion("wxyz")) - [1, 0, 0, 0]).max() < 1e-12
    assert np.ptp(transformed.quaternion("wxyz")[:, 0]) < 1e-12
    assert np.abs(transformed.angular_velocity).max() < 1e-15
    assert transformed.translation is None
    radial = standing.in_frame("QSW")
    expected = np.array([[0, 0, -1], [1, 0, 0], [0, -1, 0]])
    assert np.abs(radial.rotation.as_matrix() - expected).max() < 1e-12


@pytest.mark.parametrize("eccentricity", [0.0, 0.01, 0.7])
def test_axes_along_an_ellipse_are_those_of_position_and_velocity(eccentricity):
    orbit = {**KEPLER, "semi_major_axis": quantity(30000, "km"), "eccentricity": eccentricity}
    made = path(orbit, stop=1e6)
    t = np.linspace(-1e6, 1e6, 200)
    r, v = position(made, t), velocity(made, t)
    x = r / np.linalg.norm(r, axis=1)[:, None]
    z = np.cross(r, v)
    z /= np.linalg.norm(z, axis=1)[:, None]
    expected = np.stack([x, np.cross(z, x), z], axis=1)
    assert np.abs(matrix(qsw(made, t)) - expected).max() < 3e-15 / (1 - eccentricity)


@pytest.mark.parametrize("frame", LOCAL)
@pytest.mark.parametrize(
    "orbit", [KEPLER, KEPLER | {"eccentricity": 0.6, "semi_major_axis": quantity(2e4, "km")}]
)
def test_rates_along_an_ellipse_are_the_derivative_of_the_attitude(orbit, frame):
    transformed = orbiting(orbit, frame="ECLIPJ2000").run().in_frame(frame)
    assert np.abs(numerical_rate(transformed, 2.0) - transformed.angular_velocity).max() < 1e-13


def test_rates_along_a_perturbed_orbit_are_the_derivative_of_the_attitude():
    """Within the polynomials of the orbit: where they meet, SGP4 is followed to 1e-9 and no better."""
    made, _ = tle_path(TLES["Molniya"], stop=86400.0)
    pieces = made.polynomial
    middles = pieces.start + pieces.length * (np.arange(len(pieces.coefficients)) + 0.5)
    step = min(pieces.length / 20, 2.0)
    actual = derivative(lambda t: conjugate(qsw(made, t).quaternion), middles, step)
    assert np.abs(actual - qsw(made, middles).rate).max() < 1e-14


@pytest.mark.parametrize("name", TLES)
def test_signs_along_an_orbit_are_continuous_over_many_revolutions(name):
    slow = {"value": [1e-5, 0, 2e-5], "unit": "rad/s"}
    transformed = flown(name, stop=2e5, count=4001, angular_velocity=slow).run()
    for frame in LOCAL:
        assert no_flip(transformed.in_frame(frame))
    few = transformed[::1000].in_frame("LVLH")
    assert np.array_equal(few.quaternion("wxyz"), transformed.in_frame("LVLH").quaternion("wxyz")[::1000])


def test_signs_along_an_ellipse_are_continuous_over_many_revolutions():
    slow = {"value": [1e-5, 0, 2e-5], "unit": "rad/s"}
    orbit = {**KEPLER, "semi_major_axis": quantity(30000, "km"), "eccentricity": 0.7}
    transformed = orbiting(orbit, stop=2e6, count=20001, angular_velocity=slow).run().in_frame("LVLH")
    assert no_flip(transformed)


def test_orbit_goes_along_with_frames_slices_and_new_instants():
    original = orbiting(frame="ECLIPJ2000").run()
    straight = original.in_frame("LVLH")
    for transformed in (
        original.in_frame("EME2000").in_frame("LVLH"),
        original.in_frame("ITRF").in_frame("LVLH"),
        original.resampled(original.elapsed).in_frame("LVLH"),
        original.in_frame("TEME").resampled(original.elapsed).in_frame("LVLH"),
    ):
        assert np.abs(transformed.quaternion("wxyz") - straight.quaternion("wxyz")).max() < 2e-15
        assert np.abs(transformed.angular_velocity - straight.angular_velocity).max() < 1e-17
    assert bits(original[4:9].in_frame("LVLH")) == bits(straight[4:9])
    assert bits(pickle.loads(pickle.dumps(original)).in_frame("LVLH")) == bits(straight)


def test_scene_with_effects_has_its_orbit_too():
    original = scene(effect("gravity_gradient")).run()
    transformed = original.in_frame("LVLH")
    assert transformed.frame == "LVLH"
    t = [10.0, 5000.0]
    assert bits(transformed.resampled(t)) == bits(original.resampled(t).in_frame("LVLH"))
    chunks = list(scene(effect("gravity_gradient")).chunks(4))
    assert bits(chunks[1].in_frame("LVLH"))[0] == transformed.quaternion("wxyz")[4:8].copy().tobytes()


def test_chunks_of_a_free_body_have_the_orbit():
    whole = orbiting().run().in_frame("LVLH")
    chunks = [chunk.in_frame("LVLH").quaternion("wxyz") for chunk in orbiting().chunks(7)]
    assert np.array_equal(np.concatenate(chunks), whole.quaternion("wxyz"))


def test_path_of_an_orbit_is_computed_only_for_frames_along_it(monkeypatch):
    from attitude.orbit.kepler import Kepler

    monkeypatch.setattr(Kepler, "path", None)  # a call would fail
    assert bits(orbiting().run()) == bits(orbiting(orbit=None).run())


def test_instants_beyond_the_scene_have_their_course():
    original = flown().run()
    far = original.resampled([-20000.0, 40000.0]).in_frame("LVLH")
    wide = flown(stop=40000.0, count=2).run()
    actual = (far.rotation[1] * wide.in_frame("LVLH").rotation[1].inv()).magnitude()
    assert actual < 1e-8  # other polynomials, each within 1e-9


def test_table_that_does_not_reach_is_refused():
    t = np.arange(-600.0, 6601.0, 60.0)
    points = position(path(KEPLER), t) / 1e3
    table = {"times": quantity(t.tolist(), "s"), "positions": quantity(points.tolist(), "km")}
    original = orbiting(table).run()
    expected = orbiting().run().in_frame("LVLH")
    assert (original.in_frame("LVLH").rotation * expected.rotation.inv()).magnitude().max() < 1e-6
    with pytest.raises(
        InputError, match=r"orbit.times.value: a table over the whole span, 0.0 s to 9000.0 s"
    ):
        original.resampled([9000.0]).in_frame("LVLH")


def test_axes_along_a_fall_to_the_centre_are_refused():
    t = np.arange(0.0, 1000.0, 60.0)
    points = np.outer(9e3 - 1e-3 * t**2, [1.0, 0.0, 0.0])
    table = {"times": quantity(t.tolist(), "s"), "positions": quantity(points.tolist(), "km")}
    with pytest.raises(RegimeError, match="along the radius its orbit has no plane"):
        orbiting(table, stop=900.0).run().in_frame("QSW")


def test_users_own_frame_has_axes_along_its_orbit():
    transformed = orbiting(frame="INERTIAL", epoch=None).run().in_frame("LVLH")
    assert bits(transformed) == bits(orbiting(frame="GCRF").run().in_frame("LVLH"))


# -- the centre of mass, and what happened -----------------------------------------------------------


def test_centre_of_mass_moves_relative_to_the_frame():
    """Against differences of the positions there."""
    t, h = np.array([0.0, 40000.0]), 8.0
    instants = as_instants(np.concatenate([t, *(t + k * h for k in (-2, -1, 1, 2))]), EPOCH)
    r0, v0 = np.array([7e6, 1e6, -2e6]), np.array([100.0, 7e3, 1e3])
    moved = Translation(r0 + v0 * instants.seconds[:, None], np.broadcast_to(v0, (10, 3)))
    original = motion().at(instants.seconds)
    whole = Ephemeris(original.quaternion("wxyz").copy(), instants, "GCRF", centre_of_mass=moved)
    transformed = whole.in_frame("ITRF").translation
    r = transformed.position.reshape(5, 2, 3)
    actual = (8 * (r[3] - r[2]) - (r[4] - r[1])) / (12 * h)
    assert np.abs(transformed.velocity[:2] - actual).max() < 1e-5
    assert np.abs(transformed.velocity[:2] - v0).max() > 100
    gcrs = GCRS(CartesianRepresentation(moved.position.T * u.m), obstime=instants.time)
    itrs = gcrs.transform_to(ITRS(obstime=instants.time)).cartesian.xyz.to_value(u.m).T
    assert np.abs(transformed.position - itrs).max() < 1e-3  # of 3e8 m
    back = whole.in_frame("ITRF").in_frame("GCRF").translation
    assert np.abs(back.position - moved.position).max() < 1e-6
    assert np.abs(back.velocity - v0).max() < 1e-9
    ecliptic = whole.in_frame("ECLIPJ2000").translation
    assert np.abs(ecliptic.velocity - axes("ECLIPJ2000") @ v0).max() < 1e-11


def test_events_turn_with_the_axes_or_lose_what_depends_on_them():
    vector = np.array([1.0, 2.0, 3.0])
    events = (
        Event(1.0, "impulse", "a push", {"angular_impulse": vector, "inertial": True}),
        Event(2.0, "impulse", "a push", {"angular_impulse": vector, "inertial": False}),
        Event(
            3.0,
            "contact",
            "a bump",
            {"points": 2, "normal_speed": 0.5, "point": vector, "rate_before": vector},
        ),
        Event(4.0, "something", "else", {"whatever": vector}),
    )
    original = motion().at([0.0])
    whole = Ephemeris(original.quaternion("wxyz").copy(), original.instants, "GCRF", events=events)
    turned = axes("EME2000") @ vector
    first, second, third, fourth = whole.in_frame("EME2000").events
    assert first.details["angular_impulse"] == pytest.approx(turned, abs=1e-15)
    assert first.details["inertial"] is True
    assert second.details["angular_impulse"].tolist() == vector.tolist()
    assert third.details["point"] == pytest.approx(turned, abs=1e-15)
    assert third.details["rate_before"].tolist() == vector.tolist()
    assert fourth.details == {}
    first, second, third, fourth = whole.in_frame("ITRF").events
    assert first.details == {}
    assert second.details["angular_impulse"].tolist() == vector.tolist()
    assert third.details == {"points": 2, "normal_speed": 0.5}
    assert [event.text for event in whole.in_frame("ITRF").events] == ["a push", "a push", "a bump", "else"]
    assert whole.in_frame("ICRF").events == events


# -- files ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["csv", "ecsv", "json", "ndjson"])
@pytest.mark.parametrize("frame", ["TEME", "ITRF", "LVLH", "QSW"])
def test_files_say_what_turns_and_come_back(frame, ending, tmp_path):
    transformed = orbiting().run().in_frame(frame)
    path = tmp_path / f"a.{ending}"
    transformed.write(path)
    text = path.read_text()
    assert f"q rotates body to {frame}, a frame that turns" in text.replace("\n#", "").replace("  ", "")
    assert "inertial frame" not in text
    again = Ephemeris.read(path)
    assert again.frame == frame
    assert bits(again) == bits(transformed)
    if frame in OF_DATE:
        assert bits(again.in_frame("GCRF")) == bits(transformed.in_frame("GCRF"))


def test_momentum_of_rotors_survives_a_file_in_a_frame_that_turns(tmp_path):
    made = scene(effect("wheels"), effect("constant_torque")).run()
    made.in_frame("ITRF").write(tmp_path / "a.json")
    again = Ephemeris.read(tmp_path / "a.json").in_frame("GCRF")
    assert np.abs(again.angular_momentum - made.angular_momentum).max() < 1e-14


@pytest.mark.parametrize("frame", [*OF_DATE, *LOCAL])
def test_no_motion_is_computed_in_a_frame_that_turns(frame):
    with pytest.raises(InputError, match="frame: an inertial frame, one of ICRF"):
        motion(frame=frame)
    if frame != "TEME":  # whose axes at the epoch are inertial (tests/test_teme_scenes.py)
        with pytest.raises(InputError, match="frame: an inertial frame, one of ICRF"):
            Scene.model_validate({**DOCUMENT, "frame": frame})


# -- Orekit ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "theirs"), [("QSW", "QSW"), ("LVLH", "LVLH_CCSDS")])
def test_axes_along_an_ellipse_are_those_of_orekit(java, name, theirs):
    date = java("org.orekit.time.AbsoluteDate").ARBITRARY_EPOCH
    lof = java("org.orekit.frames.LOFType").valueOf(theirs)
    made = path(KEPLER)
    orbit = java("org.orekit.orbits.CartesianOrbit")
    vector = java("org.hipparchus.geometry.euclidean.threed.Vector3D")
    pv = java("org.orekit.utils.PVCoordinates")
    gcrf = java("org.orekit.frames.FramesFactory").getGCRF()
    transformed = orbiting(count=7).run()
    turned = transformed.in_frame(name)
    for i, t in enumerate(transformed.elapsed):
        r, v = position(made, np.array([t]))[0], velocity(made, np.array([t]))[0]
        at = orbit(pv(vector(*r.tolist()), vector(*v.tolist())), gcrf, date, float(made.central.mu))
        transform = lof.transformFromInertial(date, at.getPVCoordinates())
        axes = np.array([list(row) for row in transform.getRotation().getMatrix()])
        rate = np.array(list(transform.getRotationRate().toArray()))
        assert (
            np.abs(turned.rotation[i].as_matrix() - axes @ transformed.rotation[i].as_matrix()).max() < 1e-14
        )
        expected = transformed.angular_velocity[i] - turned.rotation[i].as_matrix().T @ rate
        assert np.abs(turned.angular_velocity[i] - expected).max() < 1e-17


def test_gtod_is_the_itrf_without_polar_motion():
    """By erfa; the pole is some tenths of arcseconds off."""
    times = Time("2020-01-01", scale="utc") + np.linspace(0.0, 1000.0, 7) * u.d
    instants = as_instants(times, times[0])
    rotation = rotation_between("GCRF", "GTOD", instants)
    to_intermediate = erfa.c2i06a(times.tt.jd1, times.tt.jd2)
    angle = erfa.era00(times.ut1.jd1, times.ut1.jd2)
    expected = erfa.rz(angle, to_intermediate)
    vectors = np.eye(3)
    for k in range(7):
        turned = rotations.rotate(rotation.quaternion[k], vectors)
        assert np.abs(turned - expected[k].T).max() <= 1e-9
    itrf = rotation_between("GCRF", "ITRF", instants)
    apart = rotations.angle_between(rotation.quaternion, itrf.quaternion)
    assert 1e-7 < apart.min() <= apart.max() < 5e-6
