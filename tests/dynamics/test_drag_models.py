"""Motion under drag whose density is a table's or a model's, against SciPy with the density at each step.

The oracle has its own ellipse, altitudes, table, ellipsoid, bulge and cuts; along a TLE the position is the
library's own, which other tests compare with SGP4.
"""

import math

import erfa
import numpy as np
import pytest
from scipy.optimize import brentq

from attitude import Scene
from attitude.effects import harris_priester
from attitude.orbit.path_states import state
from tests.dynamics.motions import angle
from tests.effects.scenes import quantity
from tests.oracles.plate_motion import ACCURACY, MU, RADIUS, PlateMotion

PLATES = [
    {"area": quantity(0.03, "m2"), "normal": n, "centre": quantity(c, "m"), "coefficient": 2.2}
    for n, c in (
        ([0, 0, 1], [0.002, -0.001, 0.15]),
        ([0, 0, -1], [0.002, -0.001, -0.16]),
        ([1, 0, 0], [0.05, 0.004, -0.005]),
        ([-0.8, 0.6, 0], [-0.05, 0.002, 0.003]),
    )
]
TABLE = {
    "altitudes": quantity([150, 200, 250, 300, 350, 400, 450, 500, 600, 700, 900], "km"),
    "densities": quantity(
        [2e-9, 2.5e-10, 6e-11, 2e-11, 7e-12, 2.8e-12, 1.1e-12, 5.2e-13, 1.1e-13, 3e-14, 5e-15], "kg/m3"
    ),
}
BULGE = {"model": "harris_priester", "exponent": 3.0}
NRL = {"model": "nrlmsise00", "f107": 150, "f107_average": 150, "ap": 15}
CIRCLE = (6778.1e3, 0.0, 51.6, 0.0, 0.0)
ELLIPSE = (6878.1e3, 0.0436, 51.6, 40.0, 250.0)
OUTBOUND = (6878.1e3, 0.0436, 51.6, 40.0, 70.0)
TLE = [
    "1 25544U 98067A   26079.50000000  .00010000  00000-0  18000-3 0  9992",
    "2 25544  51.6400 100.0000 0005000  60.0000 300.0000 15.50000000000015",
]


def perifocal(elements):
    """P, Q of (a, e, inclination, argument of the pericentre, mean anomaly) in m and degrees; node 0."""
    i, w = math.radians(elements[2]), math.radians(elements[3])
    node, across = np.array([1.0, 0, 0]), np.array([0, math.cos(i), math.sin(i)])
    return math.cos(w) * node + math.sin(w) * across, math.cos(w) * across - math.sin(w) * node


def ellipse(elements):
    """t -> position and velocity on it."""
    (a, e, *_, anomaly), (P, Q) = elements, perifocal(elements)
    n, minor = math.sqrt(MU / a**3), math.sqrt(1 - e * e)

    def place(t):
        M = math.radians(anomaly) + n * t
        E = M + e * math.sin(M)
        for _ in range(20):
            E -= (E - e * math.sin(E) - M) / (1 - e * math.cos(E))
        r = a * (math.cos(E) - e) * P + a * minor * math.sin(E) * Q
        speed = a * n / (1 - e * math.cos(E))
        return r, speed * (-math.sin(E) * P + minor * math.cos(E) * Q)

    return place


class AirMotion(PlateMotion):
    """A body on any path in air of any density.

    place : t -> position and velocity; density : (t, r) -> kg/m3; cuts : s, where it is not smooth
    """

    def __init__(self, document, place, density, cuts):
        circle = {"altitude": quantity(400, "km"), "inclination": quantity(0, "deg")}
        super().__init__(document | {"orbit": circle})
        self.place, self.density, self.cuts = place, density, cuts

    def light_cuts(self, end):
        return self.cuts


def table_density(t, r):
    """Exponential between rows, above a sphere."""
    h = 1e-3 * (math.sqrt(r @ r) - RADIUS)
    rows = TABLE["altitudes"]["value"], np.log(TABLE["densities"]["value"])
    return math.exp(np.interp(h, *rows))


class BulgeDensity:
    """Harris-Priester in the true equator of the date: precession and nutation linear over the span."""

    JD, SECONDS = 2461120.0, 69.184  # 2026-03-20T12:00:00 UTC, and TT - UTC

    def __init__(self, end):
        self.end = end
        self.ends = [erfa.pnm06a(self.JD, (self.SECONDS + t) / 86400) for t in (0.0, end)]

    def of_date(self, t):
        first, last = self.ends
        return first + t / self.end * (last - first)

    def altitude(self, t, r):
        """Above the ellipsoid of WGS 84, by iteration, m."""
        x, y, z = self.of_date(t) @ r
        a, e2, p = 6378137.0, (2 - 1 / 298.257223563) / 298.257223563, math.hypot(x, y)
        latitude = math.atan2(z, p * (1 - e2))
        for _ in range(8):
            n = a / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
            latitude = math.atan2(z + e2 * n * math.sin(latitude), p)
        n = a / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
        return p * math.cos(latitude) + z * math.sin(latitude) - a * a / n

    def __call__(self, t, r):
        h, logs = self.altitude(t, r), (np.log(harris_priester.LEAST), np.log(harris_priester.GREATEST))
        least, greatest = (math.exp(np.interp(h, harris_priester.ALTITUDES, rows)) for rows in logs)
        x, y, z = -self.of_date(t) @ erfa.epv00(self.JD, (self.SECONDS + t) / 86400)[0]["p"]
        c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
        apex = np.array([c * x - s * y, s * x + c * y, z])
        cosine = (self.of_date(t) @ r) @ apex / math.sqrt((r @ r) * (apex @ apex))
        return least + (greatest - least) * math.sqrt(0.5 + 0.5 * cosine) ** BULGE["exponent"]


def cuts(altitude, levels, end):
    """Instants at which an altitude, m, passes levels, m."""
    t = np.linspace(0.0, end, 1 + int(abs(end) / 5))
    h = np.array([altitude(each) for each in t])
    return [
        brentq(lambda x, level=level: altitude(x) - level, t[k], t[k + 1], xtol=1e-9)
        for level in levels
        for k in np.flatnonzero((h[1:] > level) != (h[:-1] > level))
    ]


def document(density, orbit, end):
    return {
        "body": {"moments": [0.0333, 0.034, 0.0067], "unit": "kg m2"},
        "epoch": {"time": "2026-03-20T12:00:00", "scale": "utc"},
        "frame": "GCRF",
        "attitude": {"quaternion": [0.5, 0.1, -0.7, 0.5], "order": "wxyz"},
        "angular_velocity": quantity([0.9, 0.5, -0.7], "deg/s"),
        "times": {"elapsed": [0, 0.5 * end, end], "unit": "s"},
        "orbit": orbit,
        "tolerance": "best",
        "effects": [
            {
                "type": "drag",
                "plates": PLATES,
                "density": density,
                "rotation": quantity(7.2921159e-5, "rad/s"),
            }
        ],
    }


def elements(orbit, end=None):
    """The document of an ellipse."""
    a, e, i, w, M = orbit
    names = ("inclination", "argument_of_pericentre", "mean_anomaly")
    angles = {name: quantity(value, "deg") for name, value in zip(names, (i, w, M), strict=True)}
    return {"semi_major_axis": quantity(a, "m"), "eccentricity": e, **angles}


def rows(orbit, end):
    """A table of an ellipse by the minute."""
    t = np.arange(min(end, 0.0) - 300.0, max(end, 0.0) + 301.0, 60.0)
    positions = [ellipse(orbit)(each)[0].tolist() for each in t]
    return {"times": quantity(t.tolist(), "s"), "positions": quantity(positions, "m")}


def path_of(made):
    """t -> position and velocity on the path of a scene."""
    path = made.initial_state().orbit_path
    return lambda t: tuple(state(path, np.array([t]), k)[0] for k in range(2))


def errors(run, motion):
    """(rad, the error at each instant but the first; and how often a plate turned its edge)."""
    states, edges = motion.states(run.elapsed[1:].tolist())
    truth = states[:, :4] / np.linalg.norm(states[:, :4], axis=1)[:, None]
    return angle(run.quaternion("wxyz")[1:].T, truth.T), edges


CASES = {
    "table, ellipse": (TABLE, ELLIPSE, "elements", 1000.0),
    "table, ellipse, backwards": (TABLE, OUTBOUND, "elements", -900.0),
    "table, rows of an ellipse": (TABLE, ELLIPSE, "table", 1000.0),
    "bulge, circle": (BULGE, CIRCLE, "elements", 1200.0),
    "bulge, ellipse": (BULGE, ELLIPSE, "elements", 1000.0),
    "bulge, rows of an ellipse": (BULGE, ELLIPSE, "table", 1000.0),
    "bulge, TLE": (BULGE, None, "tle", 800.0),
}


@pytest.mark.parametrize("name", CASES)
def test_motion_is_that_of_an_integration_with_the_density_at_each_step(name):
    density, orbit, form, end = CASES[name]
    definition = {"elements": elements, "table": rows, "tle": lambda _, __: {"tle": TLE}}[form](orbit, end)
    made = Scene.model_validate(document(density, definition, end))
    place = path_of(made) if form == "tle" else ellipse(orbit)
    if density is TABLE:
        of, levels = table_density, 1e3 * np.array(TABLE["altitudes"]["value"])
        breaks = cuts(lambda t: math.sqrt(place(t)[0] @ place(t)[0]) - RADIUS, levels, end)
    else:
        of, levels = BulgeDensity(end), harris_priester.ALTITUDES
        breaks = cuts(lambda t: of.altitude(t, place(t)[0]), levels, end)
    run = made.run()
    error, edges = errors(run, AirMotion(document(density, definition, end), place, of, breaks))
    assert len(breaks) >= (0 if form == "tle" else 1)
    assert edges >= 12
    assert error < run.plan.error_bound < 1e-8


class NoisyMotion(AirMotion):
    """For densities in single precision, which no steps follow to the last digit."""

    accuracy = ACCURACY | {"rtol": 1e-10, "atol": 1e-13}


def test_motion_in_air_of_single_precision_has_a_bound_that_tells():
    pytest.importorskip("pymsis")
    end = 1500.0
    made = Scene.model_validate(document(NRL, elements(ELLIPSE), end))
    drag, initial_state = made.effects[0], made.initial_state()
    t = np.linspace(0.0, end, 6001)
    direct = drag.density.log_densities(initial_state, t)
    breaks = list(drag.air(initial_state).cuts)
    motion = NoisyMotion(
        document(NRL, elements(ELLIPSE), end),
        ellipse(ELLIPSE),
        lambda x, r: math.exp(np.interp(x, t, direct)),
        breaks,
    )
    run = made.run()
    error, _ = errors(run, motion)
    assert len(breaks) >= 5
    assert 1e-9 < error < run.plan.error_bound < 1e-4
