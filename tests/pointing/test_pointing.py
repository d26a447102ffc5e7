"""Euler angles, directions, angles, spin and points on the ground, against scipy and astropy."""

import astropy.units as u
import numpy as np
import pytest
from astropy.coordinates import EarthLocation, get_body_barycentric, solar_system_ephemeris
from astropy.time import Time
from scipy.spatial.transform import Rotation

from attitude import InputError, RegimeError, RigidBody, Scene, TorqueFreeMotion

EPOCH = Time("2024-03-01T12:00:00", scale="utc")
T = np.linspace(0.0, 5400.0, 91)
ORBIT = {
    "semi_major_axis": {"value": 7000.0, "unit": "km"},
    "eccentricity": 0.01,
    "inclination": {"value": 60.0, "unit": "deg"},
    "raan": {"value": 20.0, "unit": "deg"},
    "argument_of_pericentre": {"value": 30.0, "unit": "deg"},
    "true_anomaly": {"value": 40.0, "unit": "deg"},
}


def motion(moments=(1.0, 1.6, 2.1), rate=(0.003, -0.005, 0.009), frame="GCRF", epoch=EPOCH):
    return TorqueFreeMotion(RigidBody(moments), [0.5, -0.1, 0.5, 0.7], rate, epoch, order="wxyz", frame=frame)


def orbiting():
    document = {
        "body": {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"},
        "attitude": {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"},
        "angular_velocity": {"value": [0.3, -0.2, 0.5], "unit": "deg/s"},
        "frame": "GCRF",
        "epoch": {"time": "2024-03-01T12:00:00", "scale": "utc"},
        "times": {"start": 0, "stop": 5400, "step": 60, "unit": "s"},
        "orbit": ORBIT,
    }
    return Scene.model_validate(document).run()


def test_euler_angles_are_those_of_scipy_in_any_unit():
    data = motion().at(T)
    for sequence in ("ZYX", "ZXZ", "XYZ"):
        assert np.abs(data.euler(sequence) - data.rotation.as_euler(sequence)).max() <= 1e-15
    degrees = data.rotation.as_euler("ZYX", degrees=True)
    assert np.abs(data.euler("ZYX", "deg") - degrees).max() <= 1e-12
    assert np.abs(data.euler("ZYX", u.deg) - degrees).max() <= 1e-12
    back = Rotation.from_euler("ZXZ", data.euler("ZXZ"))
    assert (back * data.rotation.inv()).magnitude().max() <= 1e-14


def test_direction_of_an_axis_is_that_of_its_rotation():
    data = motion().at(T)
    for axis, vector in {"x": [1, 0, 0], "-z": [0, 0, -1], "+y": [0, 1, 0]}.items():
        assert np.abs(data.direction(axis) - data.rotation.apply(np.array(vector, float))).max() <= 1e-15
    assert np.abs(data.direction([0, 3, 4]) - data.rotation.apply([0, 0.6, 0.8])).max() <= 1e-15
    sky = data.in_frame("EME2000").sky_coord("x")
    expected = data.in_frame("ICRF").direction("x")
    assert np.abs(sky.cartesian.xyz.value.T - expected).max() <= 1e-14
    assert sky.frame.name == "icrs"


def test_sun_is_that_of_astropy_seen_from_the_orbit():
    data = orbiting()
    with solar_system_ephemeris.set("builtin"):
        sun, earth = (get_body_barycentric(name, data.time).xyz.to_value(u.m).T for name in ("sun", "earth"))
    to_sun = sun - earth - data.position
    expected = to_sun / np.linalg.norm(to_sun, axis=1)[:, None]
    cosine = (data.direction("z") * expected).sum(axis=1)
    across = np.linalg.norm(np.cross(data.direction("z"), expected), axis=1)
    assert np.abs(data.angle("z", "sun") - np.arctan2(across, cosine)).max() <= 1e-9
    assert np.abs(data.in_frame("ITRF").angle("z", "sun") - data.angle("z", "sun")).max() <= 1e-12


def test_nadir_and_velocity_are_those_of_the_orbit():
    data = orbiting()
    lvlh = data.in_frame("LVLH")
    assert np.abs(data.angle("z", "earth") - lvlh.angle("z", [0.0, 0.0, 1.0])).max() <= 1e-9
    step = (data.position[2:] - data.position[:-2]) / (T[2:] - T[:-2])[:, None]
    assert np.abs(data.velocity[1:-1] - step).max() <= 2e-3 * np.abs(data.velocity).max()
    speed = np.linalg.norm(data.velocity, axis=1)
    energy = 0.5 * speed**2 - 3.986004e14 / np.linalg.norm(data.position, axis=1)
    assert np.abs(energy / energy[0] - 1.0).max() <= 1e-9
    along = data.velocity / speed[:, None]
    assert (
        np.abs(np.cos(data.angle("x", "velocity")) - (along * data.direction("x")).sum(axis=1)).max() <= 1e-14
    )


def test_angles_to_directions_axes_and_positions():
    data = orbiting()
    assert np.abs(data.angle("x", {"body_axis": "y"}) - 0.5 * np.pi).max() <= 1e-15
    assert np.abs(data.angle("z", [0, 0, 2.0]) - data.euler("ZXZ")[:, 1]).max() <= 1e-14
    far = {"position": [0.0, 0.0, 1e20]}
    assert np.abs(data.angle("z", far) - data.angle("z", [0, 0, 1.0])).max() <= 1e-12
    assert np.abs(data.angle("z", far, "deg") - np.rad2deg(data.angle("z", far))).max() <= 1e-13
    assert data.angle("z", "momentum").shape == T.shape
    small = motion(rate=(0.0, 0.0, 0.01)).at(T)
    assert small.angle("z", "momentum").max() <= 1e-15  # of an arccosine: 1e-8


def test_field_is_the_gradient_of_the_dipole_potential():
    """B = -grad V, V = R (R/r)^2 g.u, of IGRF-14's first three coefficients at 2025.0, differenced."""
    data = orbiting()
    place = data.in_frame("ITRF").position
    gauss, radius, step = np.array([-1410.3e-9, 4545.5e-9, -29350.0e-9]), 6371.2e3, 1000.0

    def potential(x):
        r = np.linalg.norm(x, axis=1)
        return radius**3 * (x @ gauss) / r**3

    slopes = [(potential(place + h) - potential(place - h)) / (2.0 * step) for h in step * np.eye(3)]
    field = -np.stack(slopes, axis=1)
    unit = field / np.linalg.norm(field, axis=1)[:, None]
    axis = data.in_frame("ITRF").direction("x")
    expected = np.arctan2(np.linalg.norm(np.cross(axis, unit), axis=1), (axis * unit).sum(axis=1))
    assert np.abs(data.angle("x", "magnetic_field") - expected).max() <= 1e-6


def test_spin_of_a_symmetric_body_is_its_textbook_motion():
    """Nutation constant; precession at L/I1 and phase at (1 - I3/I1) omega3 (Goldstein, section 5.6)."""
    moments, rate = (2.0, 2.0, 1.0), np.array([0.003, -0.001, 0.009])
    data = motion(moments, rate).at(T)
    spin = data.spin()
    momentum = np.array(moments) * rate
    size = np.linalg.norm(momentum)
    assert np.abs(spin.nutation - np.arccos(momentum[2] / size)).max() <= 1e-12
    assert np.abs(np.unwrap(spin.precession) - spin.precession[0] - size / 2.0 * T).max() <= 1e-9
    phase = (1.0 - 1.0 / 2.0) * rate[2] * T
    assert np.abs(np.unwrap(spin.phase) - spin.phase[0] - phase).max() <= 1e-9
    assert np.abs(spin.rate - rate[2]).max() <= 1e-15
    axis = data.rotation[0].apply(momentum) / size
    expected = [
        np.cos(spin.dec[0]) * np.cos(spin.ra[0]),
        np.cos(spin.dec[0]) * np.sin(spin.ra[0]),
        np.sin(spin.dec[0]),
    ]
    assert np.abs(axis - expected).max() <= 1e-14
    assert np.ptp(spin.ra) <= 1e-13


@pytest.mark.parametrize("axis", ["x", "-z", [1.0, 2.0, -2.0]])
def test_angles_of_the_spin_make_the_attitude_again(axis):
    data = motion().at(T)
    spin = data.spin(axis)
    third = np.array({"x": [1.0, 0, 0], "-z": [0, 0, -1.0]}[axis] if isinstance(axis, str) else axis)
    third = third / np.linalg.norm(third)
    momentum = data.angular_momentum / np.linalg.norm(data.angular_momentum, axis=1)[:, None]
    expected = np.arccos((data.direction(axis) * momentum).sum(axis=1))
    assert np.abs(spin.nutation - expected).max() <= 1e-7
    assert np.abs(spin.rate - data.angular_velocity @ third).max() <= 1e-15


@pytest.mark.parametrize("off", [1e-3, 1e-6, 1e-9, 1e-200])
def test_nutation_of_an_axis_beside_minus_z_is_its_angle_from_the_momentum(off):
    data = motion().at(T)
    axis = [off, -2.0 * off, -1.0]
    assert data.spin(axis).nutation == pytest.approx(data.angle(axis, "momentum"), abs=1e-14)


def test_no_instants_have_no_angles():
    data = motion().at([])
    assert (data.euler().shape, data.spin().ra.shape) == ((0, 3), (0,))


def test_ground_points_are_on_the_ellipsoid_and_along_the_axis():
    data = orbiting()
    points = data.ground_points("z")
    assert (~points.longitude.mask == (data.angle("z", "earth") < horizon(data))).mean() >= 0.98
    hit = np.flatnonzero(~points.longitude.mask)
    assert hit.size > 5
    place = EarthLocation.from_geodetic(points.longitude[hit] * u.rad, points.latitude[hit] * u.rad, 0.0)
    fixed = data.in_frame("ITRF")
    reached = fixed.position[hit] + points.distance[hit].data[:, None] * fixed.direction("z")[hit]
    geocentric = np.stack([c.to_value(u.m) for c in place.geocentric], axis=1)
    assert np.abs(geocentric - reached).max() <= 1e-2


def horizon(data):
    return np.arcsin(6371e3 / np.linalg.norm(data.position, axis=1))


def test_sub_point_is_the_target_in_body_axes():
    data = orbiting()
    longitude, latitude = data.sub_point("sun")
    axis = np.stack(
        [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], 1
    )
    for i in (0, 40, 90):
        assert data[i : i + 1].angle(axis[i], "sun").max() <= 1e-15


def test_batches_have_their_shape():
    bodies = TorqueFreeMotion(
        RigidBody([(1.0, 1.6, 2.1)] * 2), [1.0, 0, 0, 0], (0.3, -0.5, 0.9), EPOCH, order="wxyz"
    )
    data = bodies.at(T)
    assert data.euler().shape == (2, 91, 3)
    assert data.angle("z", "sun").shape == (2, 91)
    assert data.spin().nutation.shape == (2, 91)
    assert np.abs(data.angle("z", "sun")[1] - data.angle("z", "sun")[0]).max() == 0.0


WRONG = {
    "axis": (lambda d: d.direction("w"), InputError, 'body_axis: "x", "y", "z"'),
    "zero axis": (lambda d: d.direction([0, 0, 0]), InputError, "body_axis"),
    "target": (lambda d: d.angle("z", "moon"), InputError, "to: one of sun, earth, velocity"),
    "orbit": (lambda d: d.angle("z", "earth"), RegimeError, "of no scene that has an orbit"),
    "position": (lambda d: d.position, RegimeError, "of no scene that has an orbit"),
    "unit": (lambda d: d.euler("ZYX", "m"), InputError, "unit: a unit of angle"),
    "sequence": (lambda d: d.euler("ZZX"), InputError, "sequence: three axes"),
}


@pytest.mark.parametrize(("ask", "error", "text"), WRONG.values(), ids=WRONG)
def test_what_is_not_known_is_refused(ask, error, text):
    with pytest.raises(error, match=text):
        ask(motion().at(T))


RATES = {"rest": (0.0, False), "subnormal square": (1e-200, True)}


@pytest.mark.parametrize(("rate", "has_direction"), RATES.values(), ids=RATES)
@pytest.mark.parametrize("ask", [lambda d: d.spin().dec, lambda d: d.angle("z", "momentum")])
def test_momentum_has_a_direction_unless_it_is_zero(ask, rate, has_direction):
    body = RigidBody([2.0, 2.0, 2.0])
    data = TorqueFreeMotion(body, [1.0, 0, 0, 0], (0.0, rate, rate), EPOCH, order="wxyz").at(T)
    if has_direction:
        assert np.abs(ask(data) - np.pi / 4).max() <= 1e-15
    else:
        with pytest.raises(RegimeError, match="is not defined where its vector is zero"):
            ask(data)


def test_what_needs_a_date_or_axes_is_refused_without_them():
    with pytest.raises(InputError, match="epoch"):
        motion(epoch=None).at(T).angle("z", "sun")
    with pytest.raises(InputError, match="INERTIAL"):
        motion(frame="INERTIAL").at(T).angle("z", "sun")
    with pytest.raises(RegimeError, match="along the axes of LVLH"):
        orbiting().in_frame("LVLH").angle("z", "sun")
