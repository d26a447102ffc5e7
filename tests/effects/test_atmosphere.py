"""Densities of the air by tables and models: their values, what documents may say, and what is refused."""

import json
import math
import sys
from dataclasses import replace

import numpy as np
import pytest

from attitude import InputError, Scene
from attitude.documents.files import files_in
from attitude.effects import density_profile, harris_priester
from tests.effects.scenes import PLATE, document, quantity
from tests.tables import assert_refused, refusals

ALTITUDES, DENSITIES = [150, 200, 300, 400, 600, 900], [2e-9, 2.5e-10, 2e-11, 2.8e-12, 1.1e-13, 5e-15]
TABLE = {"altitudes": quantity(ALTITUDES, "km"), "densities": quantity(DENSITIES, "kg/m3")}
BULGE = {"model": "harris_priester"}
NRL = {"model": "nrlmsise00", "f107": 150, "f107_average": 150, "ap": 15}
ECCENTRIC = {
    "semi_major_axis": quantity(6878.1, "km"),
    "eccentricity": 300 / 6878.1,
    "inclination": quantity(51.6, "deg"),
    "raan": quantity(30, "deg"),
    "argument_of_pericentre": quantity(40, "deg"),
    "true_anomaly": quantity(200, "deg"),
}


def air(density, orbit=ECCENTRIC, drag=None, **changes):
    """(the atmosphere, its profile, the initial state) of a scene with drag."""
    effect = {"type": "drag", "plates": [PLATE], "density": density} | (drag or {})
    scene = Scene.model_validate(document(effect, orbit=orbit, **changes))
    made, state = scene.effects[0], scene.initial_state()
    return made.density, made.air(state), state


# -- values ----------------------------------------------------------------------------------------------


def test_table_is_exponential_between_its_rows():
    _, profile, _ = air(TABLE, {"altitude": quantity(450, "km")})
    expected = 2.8e-12 * (1.1e-13 / 2.8e-12) ** 0.25
    assert density_profile.evaluate(profile, np.array([0.0, 777.0]))[1] == pytest.approx(expected, rel=1e-11)


# (exponent, position in m, direction of the Sun, kg/m3), along axes whose third is the pole, by Orekit 13's
# HarrisPriester over the ellipsoid of WGS 84.  Its height is along the radius and not along the normal:
# 5 m at the most, and 5.6e-5 of the density.
OREKIT = [
    (2.0, [4331635, -5424128, 887370], [-0.217, -0.104, -0.971], 2.7358532437843973e-13),
    (2.0, [-460660, -1718473, 6600089], [-0.437, -0.349, -0.829], 9.371039849730337e-13),
    (4.0, [1555614, -6894469, 650363], [0.723, 0.227, -0.653], 2.670914940893298e-14),
    (4.0, [180126, -6817947, 962409], [-0.892, 0.45, -0.037], 7.183694706850255e-13),
    (6.0, [5396302, -3819463, -377226], [0.362, -0.777, 0.515], 9.697253507243571e-11),
    (6.0, [1808862, 6446768, 1355881], [-0.736, -0.134, 0.664], 8.996462407210891e-13),
]


@pytest.mark.parametrize(("exponent", "r", "sun", "expected"), OREKIT)
def test_harris_priester_is_that_of_orekit(exponent, r, sun, expected, monkeypatch):
    def ours():
        log = harris_priester.log_density(np.array([r], dtype=float), np.array([sun]), exponent)
        return float(np.exp(log[0]))

    assert ours() == pytest.approx(expected, rel=6e-5)

    def along_radius(r):
        f, distance = 1.0 / 298.257223563, np.sqrt((r**2).sum(axis=1))
        e2, cos2 = f * (2.0 - f), 1.0 - (r[:, 2] / distance) ** 2
        return None, None, distance - 6378137.0 * np.sqrt((1.0 - e2) / (1.0 - e2 * cos2))

    monkeypatch.setattr(harris_priester, "geodetic", along_radius)
    assert ours() == pytest.approx(expected, rel=1e-13)


# (s since the epoch, kg/m3) by the C version of the model (D. Brodowski, gtd7d, in double precision) on the
# eccentric orbit, at longitude, latitude and altitude by astropy's GCRS and ITRS
NRL_IN_C = [
    (0.0, 1.2249955711271458e-14),
    (123.4, 1.506312490532379e-14),
    (1777.7, 4.1859596254808416e-11),
    (3000.0, 6.417832830296867e-11),
    (5000.5, 1.1299851573684267e-14),
    (43199.0, 6.235129509643933e-12),
    (43201.0, 6.201433331220414e-12),
    (70000.0, 6.520891611136169e-11),
]


def test_nrlmsise00_is_that_of_the_c_version_without_a_network(monkeypatch):
    pymsis = pytest.importorskip("pymsis")

    def fetch(*arguments, **keywords):
        raise AssertionError("indices are given: none is looked up")

    monkeypatch.setattr(pymsis.msis, "get_f107_ap", fetch)
    _, profile, _ = air(NRL, times={"start": 0, "stop": 86400, "count": 2, "unit": "s"})
    t, expected = np.array(NRL_IN_C).T
    assert density_profile.evaluate(profile, t) == pytest.approx(expected, rel=2e-5)
    assert 43200.0 in profile.cuts  # midnight, at which the day of the year is another


@pytest.mark.parametrize(
    "orbit", [{"altitude": quantity(400, "km"), "inclination": quantity(97, "deg")}, ECCENTRIC]
)
@pytest.mark.parametrize(("density", "off"), [(TABLE, 1e-11), (BULGE, 1e-11), (NRL, 2e-5)])
def test_profile_is_the_density_itself_at_any_instant(density, off, orbit):
    if density is NRL:
        pytest.importorskip("pymsis")
    model, profile, state = air(density, orbit)
    t = np.random.default_rng(1).uniform(0.0, 6000.0, 3000)
    expected = model.log_densities(state, t)
    for each in (profile, density_profile.along(model, replace(state, refined=True))):
        assert np.abs(np.log(density_profile.evaluate(each, t)) - expected).max() < off
    assert len(each.pieces) >= len(profile.pieces)


def test_profile_breaks_where_the_orbit_passes_rows_of_the_table():
    e = 0.043
    _, profile, _ = air(TABLE, {**ECCENTRIC, "eccentricity": e})
    n, ratio = math.sqrt(3.986004e14 / 6878.1e3**3), math.sqrt((1 - e) / (1 + e))
    E = 2 * math.atan(ratio * math.tan(math.radians(100)))
    start, expected = E - e * math.sin(E), []
    for altitude in (300, 400, 600):
        E = math.acos((1 - (6378.1 + altitude) / 6878.1) / e)
        for anomaly in (E, 2 * math.pi - E):
            mean = anomaly - e * math.sin(anomaly) - start
            expected += [(mean % (2 * math.pi) + turn) / n for turn in (0.0, 2 * math.pi)]
    assert profile.cuts == pytest.approx(sorted(t for t in expected if t < 6000.0), abs=1e-5)


def test_file_of_a_table_is_read_beside_its_document(tmp_path):
    rows = "\n".join(f"{h},{rho!r}" for h, rho in zip(ALTITUDES, DENSITIES, strict=True))
    (tmp_path / "density.csv").write_text(f"# US\naltitude_km,density_kg_m3\n{rows}\n")
    drag = {"type": "drag", "plates": [PLATE], "density": {"file": "density.csv"}}
    (tmp_path / "scene.json").write_text(json.dumps(document(drag, orbit=ECCENTRIC)))
    read = Scene.read(tmp_path / "scene.json")
    _, inline, _ = air(TABLE)
    assert np.array_equal(read.effects[0].air(read.initial_state()).pieces, inline.pieces)
    with files_in(None), pytest.raises(InputError, match="no file is read here"):
        air({"file": "density.csv"})


# -- what is said, and what is refused -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("density", "text"),
    [
        (quantity(1e-12, "kg/m3"), "density the same everywhere"),
        (TABLE, "density by the table (6 rows, 150 km to 900 km), 1.4e-14 to 2.5e-10 kg/m3 along the orbit"),
        (BULGE, "density by harris_priester (mean solar activity, exponent 4)"),
    ],
)
def test_plan_names_the_model_and_the_range_of_the_density(density, text):
    drag = {"type": "drag", "plates": [PLATE], "density": density}
    plan = Scene.model_validate(document(drag, orbit=ECCENTRIC, tolerance="best")).plan()
    assert text in plan.effects[0].reason


@pytest.mark.parametrize(("density", "changes", "drag", "pointer", "message"), refusals("density_refusals"))
def test_density_that_is_not_defined_is_refused_by_name(density, changes, drag, pointer, message):
    assert_refused(lambda: air(density, **({"orbit": ECCENTRIC} | changes), drag=drag), pointer, message)


def test_model_without_its_package_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymsis", None)
    with pytest.raises(InputError, match=r"pip install 'attitude\[atmosphere\]'"):
        air(NRL)


def test_altitude_of_a_circle_may_be_that_of_the_last_row():
    _, profile, _ = air(TABLE, {"altitude": quantity(900, "km"), "inclination": quantity(10, "deg")})
    assert density_profile.evaluate(profile, np.array([3000.0]))[0] == pytest.approx(5e-15, rel=1e-9)
