"""Hyperbolas, secular rates of J2, the gravitational parameter, and the orbital frame along a TLE."""

import math

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import GCRS, TEME, CartesianDifferential, CartesianRepresentation
from astropy.time import Time, TimeDelta
from mpmath import mp
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from sgp4.api import WGS72, Satrec

from attitude import Scene
from attitude.frames.rotations import angle_between
from attitude.orbit import parse_orbit
from attitude.orbit.path_states import hyperbolic_anomaly, position, velocity
from tests.effects.scenes import KEPLER, effect, quantity, scene
from tests.effects.test_orbit import EPOCH, MU, TLES, satellite, start_of
from tests.tables import GONE, replaced

ANGLES = {
    "inclination": quantity(50, "deg"),
    "raan": quantity(20, "deg"),
    "argument_of_pericentre": quantity(80, "deg"),
}
HYPERBOLA = {"semi_major_axis": quantity(-20000, "km"), "eccentricity": 1.4, **ANGLES}


def made_path(orbit, start, stop):
    return parse_orbit(orbit).path(start, stop, EPOCH, "GCRF")


# -- hyperbolas -----------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [1.0 + 1e-9, 1.001, 1.4, 30.0])
def test_keplers_equation_of_hyperbolas_is_solved_everywhere(e):
    mean = np.array([-1e6, -3.0, -1e-6, -1e-12, 0.0, 1e-9, 1e-3, 0.5, 40.0, 1e9])
    H = hyperbolic_anomaly(mean, e)
    with mp.workdps(40):
        for one, M in zip(H.tolist(), mean.tolist(), strict=True):
            term = mp.mpf(e) * mp.sinh(one)
            # as good as a double H can be: its last place, times how fast the mean anomaly changes with it
            assert abs(term - one - M) <= 4e-16 * (abs(term) + abs(one)) * (1.0 + abs(one))


@pytest.mark.parametrize("anomaly", ["true_anomaly", "mean_anomaly"])
def test_hyperbola_is_what_two_bodies_do(anomaly):
    orbit = {**HYPERBOLA, anomaly: quantity(-100, "deg")}
    made = made_path(orbit, 0.0, 20000.0)
    t = np.linspace(0.0, 20000.0, 41)
    r, v = position(made, t), velocity(made, t)
    energy = 0.5 * (v**2).sum(axis=1) - MU / np.linalg.norm(r, axis=1)
    assert np.abs(energy / (MU / 4e7) - 1.0).max() < 1e-9

    def right(_, y):
        return [*y[3:], *(-MU / np.linalg.norm(y[:3]) ** 3 * y[:3])]

    run = solve_ivp(right, (0.0, 20000.0), [*r[0], *v[0]], method="DOP853", rtol=1e-13, atol=1e-6, t_eval=t)
    assert np.abs(r - run.y[:3].T).max() < 1e-9 * np.linalg.norm(r, axis=1).max()
    # where it begins: the angle from the pericentre, and the mean anomaly by its definition
    h, n = np.cross(r[0], v[0]), math.sqrt(MU / 2e7**3)
    eccentricity = np.cross(v[0], h) / MU - r[0] / np.linalg.norm(r[0])
    assert np.linalg.norm(eccentricity) == pytest.approx(1.4, rel=1e-10)
    if anomaly == "true_anomaly":
        side = np.cross(eccentricity, r[0]) @ h / np.linalg.norm(h)
        assert math.degrees(math.atan2(side, eccentricity @ r[0])) == pytest.approx(-100.0, abs=1e-8)
    else:
        pericentre = made_path({**HYPERBOLA}, -10.0, 10.0)
        since = math.radians(100.0) / n
        assert np.abs(position(made, np.array([since])) - position(pericentre, np.zeros(1))).max() < 1e-3


def test_attitudes_along_a_hyperbola_agree_with_an_integration():
    orbit = {**HYPERBOLA, "true_anomaly": quantity(-60, "deg")}
    made = scene(effect("gravity_gradient"), orbit=orbit)
    ephemeris = made.run()
    inertia, q0, w0 = np.diag([2.0, 3.0, 4.0]), [0.5, 0.1, -0.7, 0.5], [0.03, -0.02, 0.01]
    path = made_path(orbit, 0.0, 6000.0)
    r0, v0 = position(path, np.zeros(1))[0], velocity(path, np.zeros(1))[0]

    def right(_, y):
        r, q, w = y[:3], y[6:10], y[10:]
        down = Rotation.from_quat(q, scalar_first=True).inv().apply(r) / np.linalg.norm(r)
        torque = 3.0 * MU / np.linalg.norm(r) ** 3 * np.cross(down, inertia @ down)
        s, x, y_, z = q
        slope = 0.5 * np.array([[-x, -y_, -z], [s, -z, y_], [z, s, -x], [-y_, x, s]]) @ w
        gravity = -MU / np.linalg.norm(r) ** 3 * r
        return [*y[3:6], *gravity, *slope, *np.linalg.solve(inertia, torque - np.cross(w, inertia @ w))]

    q0 = np.array(q0) / np.linalg.norm(q0)
    t = ephemeris.elapsed
    run = solve_ivp(right, (0, 6000), [*r0, *v0, *q0, *w0], method="DOP853", rtol=1e-13, atol=1e-12, t_eval=t)
    q = run.y[6:10].T / np.linalg.norm(run.y[6:10].T, axis=1)[:, None]
    assert angle_between(ephemeris.quaternion("wxyz"), q).max() < 1e-8
    assert ephemeris.plan.error_bound < 1e-9


# -- J2 -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("e", "i", "revolutions"), [(0.1, 0.5, 14.0), (0.01, 1.7, 15.0), (0.4, 1.1, 7.0)])
def test_secular_rates_are_those_of_sgp4(e, i, revolutions):
    sgp4 = Satrec()
    motion = revolutions * 2 * math.pi / 1440.0
    sgp4.sgp4init(WGS72, "i", 5, 20000.0, 0.0, 0.0, 0.0, e, 1.0, i, 0.5, motion, 2.0)
    a = sgp4.a * sgp4.radiusearthkm * 1e3
    document = {
        "semi_major_axis": quantity(a, "m"),
        "eccentricity": e,
        "inclination": quantity(i, "rad"),
        "j2": sgp4.j2,
        "mu": quantity(sgp4.mu, "km3/s2"),
        "radius": quantity(sgp4.radiusearthkm, "km"),
    }
    kepler = parse_orbit(document)
    n = math.sqrt(sgp4.mu * 1e9 / a**3)
    found = np.array(kepler.secular_rates(a, n, kepler.central()))
    expected = np.array([sgp4.mdot / 60.0 - n, sgp4.nodedot / 60.0, sgp4.argpdot / 60.0])
    # SGP4 has terms of the second order and of J4 too, a few J2 times the first
    assert np.abs(found - expected).max() < 5e-3 * np.abs(expected).max()


def test_secular_rates_turn_the_orbit():
    # a sun-synchronous orbit: the node goes round in a year (Vallado, 4th ed., section 11.4.1)
    document = {"altitude": quantity(800, "km"), "inclination": quantity(98.6, "deg"), "j2": True}
    made = made_path(document, 0.0, 86400.0)
    t = np.array([0.0, 86400.0])
    normal = np.cross(position(made, t), velocity(made, t))
    node = np.degrees(np.arctan2(normal[:, 0], -normal[:, 1]))
    assert node[1] - node[0] == pytest.approx(0.9856, rel=3e-3)


@pytest.mark.parametrize(("a", "e"), [(7e6, 0.001), (26.6e6, 0.7)])
def test_orbit_under_j2_is_followed_for_most_of_a_year(a, e):
    orbit = {"semi_major_axis": quantity(a, "m"), "eccentricity": e, "j2": True, **ANGLES}
    kepler, instants = parse_orbit(orbit), [-86400.0, 0.0, 1e5, 2.2e7, 300 * 86400.0]
    found = position(made_path(orbit, instants[0], instants[-1]), np.array(instants))
    with mp.workdps(30):
        n = mp.sqrt(mp.mpf(kepler.central().mu) / mp.mpf(a) ** 3)
        along, node_rate, argument_rate = kepler.secular_rates(a, float(n), kepler.central())
        for r, t in zip(found, instants, strict=True):
            mean = (n + along) * t
            E = mp.findroot(lambda x, mean=mean: x - e * mp.sin(x) - mean, mean, verify=False)
            x, y = a * (mp.cos(E) - e), a * mp.sqrt(1 - mp.mpf(e) ** 2) * mp.sin(E)
            node, i, argument = (math.radians(angle) for angle in (20.0, 50.0, 80.0))
            turn = Rotation.from_euler("ZXZ", [node + node_rate * t, i, argument + argument_rate * t])
            expected = turn.apply([float(x), float(y), 0.0])
            assert np.linalg.norm(r - expected) < 3e-10 * np.linalg.norm(expected)


def test_scene_with_j2_runs_and_says_so():
    plain, turning = (scene(effect("gravity_gradient"), orbit={**KEPLER, "j2": j2}) for j2 in (False, True))
    one, other = plain.run(), turning.run()
    assert 1e-6 < angle_between(one.quaternion("wxyz"), other.quaternion("wxyz")).max() < 0.1
    assert "secular rates of J2 = 0.001082626174" in other.plan.orbit
    assert "J2" not in one.plan.orbit


# -- the gravitational parameter ------------------------------------------------------------------


def test_gravitational_parameter_stands_in_plan_and_answer():
    made = scene(effect("gravity_gradient"))
    text = "Keplerian elements, about the Earth, GM 3.986004e+14 m3/s2 (nominal, IAU 2015 resolution B3"
    assert text in " ".join(made.plan().text().split())
    assert made.plan().to_dict()["orbit"].startswith(text)
    assert made.run().plan.orbit.startswith(text)


@pytest.mark.parametrize("form", ["kepler", "tle"])
def test_gravitational_parameter_of_the_document_keeps_the_earth(form):
    mu = quantity(398600.4418, "km3/s2")
    given = {**KEPLER, "central_body": "earth"} if form == "kepler" else {"tle": list(TLES["Molniya"])}
    epoch = {"time": start_of(TLES["Molniya"]).isot, "scale": "utc"}
    made = scene(
        effect("magnetic_dipole"), effect("gravity_gradient"), orbit={**given, "mu": mu}, epoch=epoch
    )
    central = made.initial_state().orbit_path.central
    assert (central.mu, central.radius, central.is_earth) == (398600.4418e9, 6378100.0, True)
    assert "3.986004418e+14 m3/s2" in made.plan().orbit
    assert "none is in the document" not in made.plan().orbit


# -- the orbital frame along a TLE ----------------------------------------------------------------


@pytest.mark.parametrize("name", TLES)
def test_orbital_frame_along_a_tle_is_that_of_its_own_velocity(name):
    lines = TLES[name]
    epoch = Time((start_of(lines) + TimeDelta(3600.0, format="sec")).isot, scale="utc")
    document = {"time": epoch.isot, "scale": "utc"}
    times = {"start": 0, "stop": 1, "count": 30, "unit": "d"}
    made = scene(epoch=document, orbit={"tle": list(lines)}, times=times, effects=GONE)
    turned = made.run().in_frame("QSW")
    t = turned.elapsed
    model, since = satellite(lines), (epoch.tai - start_of(lines).tai).sec
    _, r, v = model.sgp4_array(np.full(30, model.jdsatepoch), model.jdsatepochF + (t + since) / 86400)
    when = (epoch.tai + TimeDelta(t, format="sec")).utc
    teme = CartesianRepresentation(r.T * u.km, differentials=CartesianDifferential(v.T * u.km / u.s))
    gcrs = TEME(teme, obstime=when).transform_to(GCRS(obstime=when)).cartesian
    r, v = gcrs.xyz.to_value(u.m).T, gcrs.differentials["s"].d_xyz.to_value(u.m / u.s).T
    x = r / np.linalg.norm(r, axis=1)[:, None]
    z = np.cross(r, v)
    z /= np.linalg.norm(z, axis=1)[:, None]
    axes = np.stack([x, np.cross(z, x), z], axis=1)  # rows: components along them from those in GCRF
    own = Rotation.from_quat(made.run().quaternion("wxyz"), scalar_first=True)
    expected = (Rotation.from_matrix(axes) * own).as_quat(scalar_first=True)
    # astropy goes over UT1 and polar motion, which leave 1e-10; SGP4 jumps by 1e-10 of r
    assert angle_between(turned.quaternion("wxyz"), expected).max() < 1e-8


def test_document_of_each_form_comes_back():
    for orbit in (HYPERBOLA, {**KEPLER, "j2": True}, {**KEPLER, "j2": 0.001}):
        made = scene(effect("gravity_gradient"), orbit=replaced(orbit, {}))
        assert Scene.from_json(made.to_json()) == made
