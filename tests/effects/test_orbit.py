"""Orbits: against an integration, against SGP4 and astropy, and the shadow against geometry."""

import math
import sys
from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import GCRS, TEME, CartesianRepresentation, get_body_barycentric
from astropy.time import Time, TimeDelta
from scipy.integrate import solve_ivp

from attitude import AttitudeWarning, InputError, Scene
from attitude.effects.shadow import ShadowHeight, passages
from attitude.effects.sun import from_earth
from attitude.frames.celestial import SUN_RADIUS
from attitude.frames.inertial import from_gcrf
from attitude.kernels.solvers.plate_layout import Light, ShadowModel
from attitude.orbit.orbit import earth
from attitude.orbit.path_states import eccentric_anomaly, position, state, velocity
from attitude.problem.initial_state import PiecewisePolynomial
from attitude.times import turn_rates
from tests.effects.scenes import KEPLER, built, document, effect, quantity, scene
from tests.tables import GONE, assert_refused, refusals, replaced

MU, RADIUS = 3.986004e14, 6378100.0
EPOCH = Time("2026-03-20T12:00:00", scale="utc")


def path(orbit, start=0.0, stop=6000.0, **changes):
    times = {"elapsed": [start, stop], "unit": "s"}
    return built("gravity_gradient", orbit=orbit, times=times, **changes)[1].orbit_path


def kepler(**changes):
    return replaced(KEPLER, changes)


# -- Keplerian elements ---------------------------------------------------------------------------


def integrated(r, v, t, mu=MU):
    """(n, 6) by the equations of two bodies."""

    def right(_, y):
        return [*y[3:], *(-mu / np.linalg.norm(y[:3]) ** 3 * y[:3])]

    run = solve_ivp(right, (t[0], t[-1]), [*r, *v], method="DOP853", rtol=1e-13, atol=1e-6, t_eval=t)
    return run.y.T


@pytest.mark.parametrize("eccentricity", [0.0, 0.01, 0.3, 0.8])
def test_ellipse_is_what_two_bodies_do(eccentricity):
    orbit = kepler(eccentricity=eccentricity, semi_major_axis=quantity(40000, "km"))
    made = path(orbit)
    t = np.linspace(0.0, 2.5 * made.period, 40)
    expected = integrated(position(made, t[:1])[0], velocity(made, t[:1])[0], t)
    # DOP853 at 1e-13 a step leaves some 1e-11 after hundreds of steps
    assert np.abs(position(made, t) - expected[:, :3]).max() < 1e-10 * 4e7
    assert np.abs(velocity(made, t) - expected[:, 3:]).max() < 1e-10 * 1e4


def test_elements_are_those_of_the_state():
    # the other way round: elements from position and velocity, by the vectors of momentum and eccentricity
    made = path(kepler(eccentricity=0.2, semi_major_axis=quantity(10000, "km")))
    r, v = position(made, np.zeros(1))[0], velocity(made, np.zeros(1))[0]
    h = np.cross(r, v)
    e = np.cross(v, h) / MU - r / np.linalg.norm(r)
    node = np.cross([0, 0, 1], h)

    def angle(a, b):
        return math.degrees(math.atan2(np.cross(a, b) @ h / np.linalg.norm(h), a @ b))

    assert 1 / (2 / np.linalg.norm(r) - v @ v / MU) == pytest.approx(1e7, rel=1e-13)
    assert np.linalg.norm(e) == pytest.approx(0.2, rel=1e-13)
    assert math.degrees(math.acos(h[2] / np.linalg.norm(h))) == pytest.approx(60, rel=1e-13)
    assert math.degrees(math.atan2(node[1], node[0])) == pytest.approx(30, rel=1e-12)
    assert angle(node, e) == pytest.approx(100, rel=1e-12)
    assert angle(e, r) == pytest.approx(-20, rel=1e-12)


def test_mean_anomaly_is_the_part_of_the_period_since_the_pericentre():
    made = path(kepler(true_anomaly=GONE, mean_anomaly=quantity(90, "deg"), eccentricity=0.05))
    at_pericentre = position(made, np.array([-0.25, 0.75]) * made.period)
    assert np.linalg.norm(at_pericentre, axis=1) == pytest.approx([0.95 * 7e6] * 2, rel=1e-12)


def test_altitude_is_above_the_equator_of_the_earth():
    made = path({"altitude": quantity(600, "km")})
    assert np.linalg.norm(position(made, np.arange(5.0)), axis=1) == pytest.approx(
        [RADIUS + 6e5] * 5, rel=1e-14
    )
    assert (made.central.mu, made.central.radius, made.central.is_earth) == (MU, RADIUS, True)
    assert made.period == pytest.approx(2 * np.pi * math.sqrt((RADIUS + 6e5) ** 3 / MU), rel=1e-14)


def test_other_body_has_its_own_numbers():
    mars = {"mu": quantity(42828.4, "km3/s2"), "radius": quantity(3396.2, "km")}
    made = path({"altitude": quantity(400, "km"), **mars})
    assert made.numbers[1] == 3796.2e3
    assert made.period == pytest.approx(2 * np.pi * math.sqrt(3796.2**3 / 42828.4), rel=1e-14)
    assert not made.central.is_earth


@pytest.mark.parametrize("e", [0.0, 1e-9, 0.3, 0.9, 0.999999, 1 - 1e-12])
def test_keplers_equation_is_solved_everywhere(e):
    mean = np.concatenate([np.linspace(-np.pi, np.pi, 1001), [1e-12, -1e-9, 1e-5, 1e-3]])
    E = eccentric_anomaly(mean, e)
    # as good as a double E can be: its last place, times how fast the mean anomaly changes with it
    assert np.abs(E - e * np.sin(E) - mean).max() < 1e-15
    assert (E * mean >= 0.0).all()


def test_phase_keeps_its_digits_over_a_million_revolutions():
    high, low, _ = turn_rates.mean_motion(MU, 7e6)
    t = np.array([1e6, 5.8e9, -123456789.25])
    exact = [Decimal(x) * (Decimal(high) + Decimal(low)) for x in t.tolist()]
    actual = turn_rates.fraction_of_turn(t, high, low)
    for value, whole in zip(actual.tolist(), exact, strict=True):
        assert abs(float(whole - round(whole)) - value) < 2e-16


def test_mean_motion_is_good_to_32_digits():
    high, low, rate = turn_rates.mean_motion(MU, 7e6)
    with localcontext(prec=60):
        two_pi = Decimal("6.28318530717958647692528676655900576839433879875")
        turning = two_pi * (Decimal(high) + Decimal(low))
        assert abs(turning * turning * Decimal(7_000_000) ** 3 / Decimal(MU) - 1) < Decimal("1e-31")
    assert rate == float(turning)


# -- a TLE ----------------------------------------------------------------------------------------

# From the verification set of Vallado et al. 2006 (AIAA 2006-6753): near earth, deep space with resonance.
TLES = {
    "low, eccentric": (
        "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
        "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
    ),
    "Molniya": (
        "1 08195U 75081A   06176.33215444  .00000099  00000-0  11873-3 0   813",
        "2 08195  64.1586 279.0717 6877146 264.7651  20.2257  2.00491383225656",
    ),
}


def satellite(lines):
    from sgp4.api import Satrec

    return Satrec.twoline2rv(*(line.strip() for line in lines[-2:]))


def start_of(lines):
    made = satellite(lines)
    return Time(made.jdsatepoch, made.jdsatepochF, format="jd", scale="utc")


def tle_path(lines, after=3600.0, stop=2 * 86400.0, frame="GCRF"):
    epoch = start_of(lines) + TimeDelta(after, format="sec")
    dated = {"time": epoch.isot, "scale": "utc"}
    return path({"tle": list(lines)}, stop=stop, epoch=dated, frame=frame), Time(epoch.isot, scale="utc")


@pytest.mark.parametrize("lines", TLES.values(), ids=TLES)
def test_tle_is_where_sgp4_and_astropy_say(lines, offline):
    made, epoch = tle_path(lines)
    t = np.linspace(0.0, 2 * 86400.0, 60)
    since = (epoch.tai - start_of(lines).tai).sec
    first = satellite(lines)
    errors, teme, own = first.sgp4_array(
        np.full(60, first.jdsatepoch), first.jdsatepochF + (t + since) / 86400
    )
    assert not errors.any()
    actual = position(made, t)
    length = np.linalg.norm(teme, axis=1) * 1e3
    assert (np.abs(np.linalg.norm(actual, axis=1) / length - 1) < 1e-9).all()
    when = (epoch.tai + TimeDelta(t, format="sec")).utc
    gcrs = TEME(CartesianRepresentation(teme.T * u.km), obstime=when).transform_to(GCRS(obstime=when))
    off = np.linalg.norm(actual - gcrs.cartesian.xyz.to_value(u.m).T, axis=1)
    # astropy goes over UT1 and polar motion, which leave 1e-10 between the two ways
    assert (off / length).max() < 1e-9
    # the velocity is that of SGP4, which is not the derivative of its positions, by 1e-4
    speed = np.linalg.norm(own, axis=1) * 1e3
    assert np.abs(np.linalg.norm(velocity(made, t), axis=1) / speed - 1).max() < 3e-7  # TEME precesses
    difference = (position(made, t + 5.0) - position(made, t - 5.0)) / 10.0
    off = np.linalg.norm(state(made, t, 1) - difference, axis=1)
    assert (off / np.linalg.norm(difference, axis=1)).max() < 3e-5
    assert made.period == pytest.approx(86400 / float(lines[1][52:63]), rel=1e-9)


def test_frames_turn_a_tle_by_what_lies_between_them():
    lines = TLES["Molniya"]
    t = np.linspace(0, 6000.0, 7)
    gcrf = position(tle_path(lines, stop=6000.0)[0], t)
    for frame in ("ICRF", "EME2000", "ECLIPJ2000"):  # whose axes are those of tests/test_frames.py
        found = position(tle_path(lines, stop=6000.0, frame=frame)[0], t)
        assert np.allclose(found, gcrf @ from_gcrf(frame, "a test").T, rtol=0, atol=1e-3)


@pytest.mark.parametrize(
    "written",
    [
        lambda lines: [line + "\n" for line in lines],
        lambda lines: [line + "\r\n" for line in lines],
        lambda lines: "\ufeff{}\n{}".format(*lines),
        lambda lines: [f" {line}  " for line in lines],
        lambda lines: ["MOLNIYA 2-14              ", *lines],
        lambda lines: "MOLNIYA 2-14\r\n{}\r\n{}\r\n\r\n".format(*lines),
    ],
    ids=["line ends", "line ends of Windows", "byte-order mark", "blanks", "name", "text of a file"],
)
def test_tle_is_read_with_line_ends_blanks_and_a_name(written):
    lines = TLES["Molniya"]
    t = np.linspace(0, 6000.0, 7)
    dated = {"time": (start_of(lines) + TimeDelta(3600.0, format="sec")).isot, "scale": "utc"}
    found, plain = (
        position(path({"tle": each}, stop=6000.0, epoch=dated, frame="GCRF"), t)
        for each in (written(lines), lines)
    )
    assert np.array_equal(found, plain)


def test_tle_of_68_columns_is_read_with_a_warning():
    lines = TLES["Molniya"]
    with pytest.warns(AttitudeWarning, match=r"tle\[[01]\]: the checksum is missing"):
        made = tle_path([line[:68] for line in lines], stop=6000.0)[0]
    t = np.linspace(0, 6000.0, 7)
    assert np.array_equal(position(made, t), position(tle_path(lines, stop=6000.0)[0], t))


def test_tle_needs_its_extra(monkeypatch):
    made = scene(effect("gravity_gradient"), orbit={"tle": LINES})
    monkeypatch.setitem(sys.modules, "sgp4.api", None)
    assert_refused(made.initial_state, "/orbit/tle", r"pip install 'attitude\[orbit\]'")


# -- a table --------------------------------------------------------------------------------------


def table(made, times, **more):
    points = position(made, np.asarray(times, dtype=float)) / 1e3
    return {"times": quantity(list(times), "s"), "positions": quantity(points.tolist(), "km"), **more}


def test_table_is_followed_between_its_points():
    ellipse = path(kepler())
    times = np.sort(np.concatenate([np.arange(-600.0, 6601.0, 60.0), [11.0, 2222.5]]))
    made = path(table(ellipse, times.tolist()))
    t = np.linspace(0, 6000, 777)
    # degree 7 over steps of 60 s, 0.06 rad: 0.06^8 of r, more or less
    assert np.abs(position(made, t) - position(ellipse, t)).max() < 1e-8 * 7e6
    assert np.abs(velocity(made, t) - velocity(ellipse, t)).max() < 1e-8 * 7.5e3
    assert made.period == pytest.approx(ellipse.period, rel=1e-6)
    points = times[(times >= 0) & (times <= 6000)]
    assert np.abs(position(made, points) - position(ellipse, points)).max() < 1e-9 * 7e6


def test_table_of_one_instant_and_of_four_points():
    ellipse = path(kepler())
    made = path(table(ellipse, [-30, -10, 10, 30]), stop=0.0)
    off = position(made, np.zeros(1)) - position(ellipse, np.zeros(1))
    assert np.abs(off).max() < 0.1  # a cubic over 20 s


TABLE = {
    "times": quantity([-1000, 1000, 3000, 5000, 7000], "s"),
    "positions": quantity([[7000, 0, 0], [7000, 1, 0], [7000, 2, 0], [7000, 3, 0], [7000, 4, 0]], "km"),
}
LINES = list(TLES["Molniya"])


@pytest.mark.parametrize(("orbit", "pointer", "message"), refusals("orbit_refusals"))
def test_fault_of_an_orbit_is_refused(orbit, pointer, message):
    """The orbit of a row is whole, or one of these with its members changed."""
    if isinstance(orbit, list) and orbit[0] in ("kepler", "table"):
        orbit = replaced({"kepler": KEPLER, "table": TABLE}[orbit[0]], orbit[1])
    made = document(effect("gravity_gradient"), orbit=orbit)
    with pytest.raises(InputError, match=message) as caught:
        Scene.model_validate(made).initial_state()
    assert caught.value.pointer.startswith(f"/orbit{pointer}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "pointer", "message"),
    [
        ({"epoch": GONE}, "/epoch", "an epoch; the times of a TLE"),
        ({"frame": "INERTIAL"}, "/frame", "for the positions of a TLE"),
    ],
)
def test_tle_without_an_epoch_or_in_a_frame_of_ones_own_is_refused(changes, pointer, message):
    made = scene(effect("gravity_gradient"), orbit={"tle": LINES}, **changes)
    assert_refused(made.initial_state, pointer, message)


def test_tle_that_has_decayed_says_so():
    lines = TLES["low, eccentric"]
    low = lines[1].replace("1859667", "0000001").replace("10.82419157", "16.90000000")
    digits = sum(int(c) if c.isdigit() else c == "-" for c in low[:-1]) % 10
    lines = [lines[0], low[:-1] + str(digits)]
    message = r"elements that (are valid|sgp4 accepts)"
    assert_refused(lambda: tle_path(lines, stop=40 * 86400.0), "/orbit/tle", message)


@pytest.mark.parametrize("orbit", [kepler(), {"tle": LINES}, TABLE], ids=["kepler", "tle", "table"])
def test_document_of_an_orbit_comes_back(orbit):
    made = scene(effect("gravity_gradient"), orbit=orbit)
    again = type(made).from_json(made.to_json())
    assert again == made
    assert again.document() == document(effect("gravity_gradient"), orbit=orbit)


# -- the Sun, and the shadow ----------------------------------------------------------------------


def test_sun_is_where_astropy_has_it():
    sun = from_earth(EPOCH, "GCRF", 0.0, 40 * 86400.0)
    t = np.linspace(0.0, 40 * 86400.0, 50)
    when = EPOCH + TimeDelta(t, format="sec")
    expected = (get_body_barycentric("sun", when) - get_body_barycentric("earth", when)).xyz.to_value(u.m).T
    assert np.abs(sun(t) - expected).max() < 1e-9 * 1.5e11


def test_sun_of_the_equinox_is_towards_the_equinox():
    # 2026-03-20 14:46 UTC (Astronomical Almanac): declination of date 0, so x of date, 0.5 degrees/day
    sun = from_earth(EPOCH, "ECLIPJ2000", 0.0, 1e4)(np.array([10000.0]))[0]
    longitude = math.degrees(math.atan2(sun[1], sun[0]))
    # the equinox has moved by 50.3 arcseconds a year since 2000; light takes 20 arcseconds' time
    assert longitude == pytest.approx(-50.29 * 26.22 / 3600, abs=0.012)
    assert abs(sun[2] / np.linalg.norm(sun)) < 2e-5


AU = 1.495978707e11


def fixed_sun(*direction):
    direction = np.array(direction) / np.linalg.norm(direction)
    return PiecewisePolynomial(0.0, 1.0, AU * direction[None, :, None])


def sunlit(made, sun, radius, start, stop):
    """Spans outside the cylinder of the shadow."""
    found = passages(made, sun, radius, (start, stop), ShadowModel.CYLINDRICAL)
    ends = np.concatenate([[start], found.edges, [stop]]).tolist()
    return [span for span, kind in zip(pairwise(ends), found.kinds, strict=True) if kind == Light.FULL]


def discs(made, sun, radius, t):
    """Apparent radii of the Sun and of the central body, and the angle between their centres: (3, n) rad."""
    r = position(made, t)
    to_sun = sun(t) - r
    distance, height = np.linalg.norm(to_sun, axis=1), np.linalg.norm(r, axis=1)
    between = np.arctan2(np.linalg.norm(np.cross(to_sun, -r), axis=1), -(to_sun * r).sum(axis=1))
    return np.array([np.arcsin(SUN_RADIUS / distance), np.arcsin(radius / height), between])


@pytest.mark.parametrize("a", [6.8e6, 4.2e7, 2e9])  # the last is behind the tip of the umbra
def test_penumbra_begins_and_ends_where_the_discs_touch(a):
    made = path({"semi_major_axis": quantity(a, "m")})
    sun = fixed_sun(1, 0.2, 0.0)
    found = passages(made, sun, RADIUS, (0.0, made.period), ShadowModel.CONICAL)
    ring = a > RADIUS * AU / SUN_RADIUS
    assert found.kinds.tolist() == [
        Light.FULL,
        Light.PARTIAL,
        Light.PARTIAL if ring else Light.DARK,
        Light.PARTIAL,
        Light.FULL,
    ]
    own, other, between = discs(made, sun, RADIUS, found.edges)
    touching = np.abs(own - other)
    touching[[0, 3]] = (own + other)[[0, 3]]
    assert np.abs(between - touching).max() < 1e-13 * (1.0 + a / 1e7)
    assert set(found.edges) < set(found.cuts)
    assert len(found.cuts) == 4 + (3 if ring else 2) * 11


def test_shadow_of_a_circular_orbit_with_the_sun_in_its_plane():
    # the shadow is as wide as the Earth: half-angle asin(R/a) about the point opposite the Sun
    made = path({"semi_major_axis": quantity(8000, "km")})
    half = math.asin(RADIUS / 8e6) / (2 * np.pi) * made.period
    spans = sunlit(made, fixed_sun(1, 0, 0), RADIUS, 0.0, 2 * made.period)
    middle, P = made.period / 2, made.period
    expected = [(0, middle - half), (middle + half, P + middle - half), (P + middle + half, 2 * P)]
    assert np.abs(np.array(spans) - np.array(expected)).max() < 1e-9


def test_shadow_of_an_orbit_tilted_to_the_sun():
    # Sun at b over the plane: in shadow while the angle from the point opposite, in the plane, has a
    # cosine above sqrt(1 - (R/a)^2) / cos b
    made = path({"semi_major_axis": quantity(8000, "km")})
    for b in (0.1, 0.5, 0.9):
        spans = sunlit(made, fixed_sun(math.cos(b), 0, math.sin(b)), RADIUS, 0.0, made.period)
        half = math.acos(math.sqrt(1 - (RADIUS / 8e6) ** 2) / math.cos(b)) / (2 * np.pi) * made.period
        expected = [(0, made.period / 2 - half), (made.period / 2 + half, made.period)]
        assert np.abs(np.array(spans) - np.array(expected)).max() < 1e-9


def test_shortest_passages_are_found():
    # the Sun so high over the plane that the body but grazes the shadow, for a second and for a millisecond
    made = path({"semi_major_axis": quantity(8000, "km")})
    for length in (1.0, 1e-2, 1e-3):
        half = np.pi * length / made.period
        b = math.acos(math.sqrt(1 - (RADIUS / 8e6) ** 2) / math.cos(half))
        spans = sunlit(made, fixed_sun(math.cos(b), 0, math.sin(b)), RADIUS, 100.0, 3 * made.period + 100)
        dark = np.array([later[0] - earlier[1] for earlier, later in pairwise(spans)])
        # a graze of length s is s^2 deep: the rounding of the position shows in the length over s
        assert dark == pytest.approx([length] * 3, abs=max(1e-8, 1e-8 / length))
    high = math.asin(RADIUS / 8e6) + 1e-9
    assert sunlit(made, fixed_sun(math.cos(high), 0, math.sin(high)), RADIUS, 0.0, 9e4) == [(0.0, 9e4)]


def test_short_daylight_is_found():
    # at half a radius over the ground and a span that begins and ends in the dark
    made = path({"semi_major_axis": quantity(8000, "km")})
    spans = sunlit(made, fixed_sun(1, 0, 0), RADIUS, 0.45 * made.period, 0.55 * made.period)
    assert spans == []
    spans = sunlit(made, fixed_sun(1, 0, 0), RADIUS, 0.45 * made.period, 1.55 * made.period)
    assert len(spans) == 1


def test_crossings_far_from_the_epoch_are_good_to_the_rounding_of_t_and_cost_no_more(monkeypatch):
    made = path({"semi_major_axis": quantity(8000, "km")})
    calls, plain = [], ShadowHeight.__call__
    monkeypatch.setattr(ShadowHeight, "__call__", lambda self, t: (calls.append(1), plain(self, t))[1])
    first = 10_000 * made.period
    spans = sunlit(made, fixed_sun(1, 0, 0), RADIUS, first, first + made.period)
    half = math.asin(RADIUS / 8e6) / (2 * np.pi) * made.period
    middle = first + made.period / 2
    expected = [(first, middle - half), (middle + half, first + made.period)]
    assert np.abs(np.array(spans) - np.array(expected)).max() < 3 * np.spacing(7e7)
    assert len(calls) < 60


@pytest.mark.parametrize("seed", range(8))
def test_spans_of_any_orbit_are_those_of_close_sampling(seed):
    rng = np.random.default_rng(seed)
    e = rng.uniform(0, 0.8)
    angles = {
        name: quantity(rng.uniform(0, 180), "deg")
        for name in ("inclination", "raan", "argument_of_pericentre", "true_anomaly")
    }
    made = path(kepler(semi_major_axis=quantity(6700 / (1 - e), "km"), eccentricity=e, **angles))
    sun = from_earth(EPOCH, "GCRF", -2e4, 8e4)
    spans = sunlit(made, sun, RADIUS, -1e4, 6e4)
    t = np.linspace(-1e4, 6e4, 20_001)
    lit = np.zeros(len(t), dtype=bool)
    for begin, end in spans:
        lit |= (begin < t) & (t < end)
    height = ShadowHeight(made, sun, RADIUS)(t)
    assert np.array_equal(lit[1:-1], (height > 0)[1:-1])
    assert all(a < b for a, b in spans)
    ends = np.array(spans).reshape(-1)
    inner = ends[(ends > -1e4) & (ends < 6e4)]
    assert np.abs(ShadowHeight(made, sun, RADIUS)(inner)).max(initial=0.0) < 1e-5  # m: 1e-9 s at 8 km/s


def test_shadow_of_a_scene_is_conical_or_as_it_says():
    made, initial_state = built("solar_pressure", times={"start": 0, "stop": 1, "count": 2, "unit": "d"})
    found = made.passages(initial_state)
    assert found.shadow == ShadowModel.CONICAL
    assert 0.0 < found.edges[0] < found.edges[-1] < 86400.0
    assert len(found.edges) > 40
    for shadow, expected in (
        ("cylindrical", ShadowModel.CYLINDRICAL),
        (True, ShadowModel.CYLINDRICAL),
        ("conical", ShadowModel.CONICAL),
    ):
        made, initial_state = built("solar_pressure", {"shadow": shadow})
        assert made.passages(initial_state).shadow == expected
    unshaded, initial_state = built("solar_pressure", {"shadow": False}, orbit=GONE)
    assert unshaded.passages(initial_state) is None


def test_earth_is_that_of_astropy():
    assert earth()[:2] == (MU, RADIUS)
