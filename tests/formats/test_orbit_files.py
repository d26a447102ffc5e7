"""Orbits in files: against the ellipse that they are of, Orekit and CSPICE; and what is refused."""

import json

import numpy as np
import pytest
from astropy import units as u

from attitude import FormatError, InputError, Scene
from attitude.formats.orbits import read_orbit
from attitude.samples.transform import rotation_between

from .aem_oracles import orekit_positions
from .orbit_texts import EPOCH, csv, oem, oem_segment, oem_xml, state, stk

ROWS = np.arange(0.0, 6001.0, 60.0)
BASE = {
    "body": {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"},
    "epoch": {"time": "2026-01-01T00:00:00", "scale": "utc"},
    "frame": "EME2000",
    "attitude": {"quaternion": [1.0, 0.0, 0.0, 0.0], "order": "wxyz"},
    "angular_velocity": {"value": [0.0, 0.01, 0.0], "unit": "rad/s"},
    "times": {"start": 0, "stop": 6000, "step": 7, "unit": "s"},
}
RADIUS = 7.1e6


def scene(orbit, **changes):
    return Scene.model_validate({**BASE, "orbit": orbit, **changes})


def ephemeris(orbit, **changes):
    return scene(orbit, **changes).run()


INLINE = {
    "oem": {"oem": oem(oem_segment(ROWS))},
    "oem xml": {"oem": oem_xml(ROWS)},
    "oem xml with units": {"oem": oem_xml(ROWS).replace("<X>", '<X units="km">')},
    "oem, TAI": {"oem": oem(oem_segment(ROWS, "tai"))},
    "oem, TDB": {"oem": oem(oem_segment(ROWS, "tdb"))},
    "oem without method": {"oem": oem(oem_segment(ROWS, INTERPOLATION=None, INTERPOLATION_DEGREE=None))},
    "oem, Lagrange": {"oem": oem(oem_segment(ROWS, INTERPOLATION="LAGRANGE", INTERPOLATION_DEGREE="9"))},
    "oem, two segments": {"oem": oem(oem_segment(ROWS[:51]), oem_segment(ROWS[50:]))},
    "stk": {"stk": stk(ROWS)},
    "stk, m": {"stk": stk(ROWS, "EphemerisTimePos", "Lagrange", 9, "Meters")},
    "csv": {"csv": csv(ROWS), "frame": "EME2000"},
    "csv, m": {"csv": csv(ROWS, "m")},
}


@pytest.mark.parametrize("orbit", INLINE.values(), ids=INLINE)
def test_positions_and_velocities_are_those_of_the_ellipse(orbit):
    """Between rows 60 s apart a polynomial of degree 7 or 9 errs by less than a millimetre."""
    found = ephemeris(orbit)
    r, v = state(found.elapsed)
    np.testing.assert_allclose(found.position, r, atol=2e-3)
    np.testing.assert_allclose(found.velocity, v, atol=2e-4)


@pytest.mark.parametrize(
    ("name", "text"),
    [("x.oem", oem(oem_segment(ROWS))), ("x.xml", oem_xml(ROWS)), ("x.e", stk(ROWS)), ("x.csv", csv(ROWS))],
)
def test_file_lies_beside_its_document(tmp_path, monkeypatch, name, text):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / name).write_text(text)
    path = tmp_path / "folder" / "scene.json"
    path.write_text(json.dumps({**BASE, "orbit": {"file": name}}))
    monkeypatch.chdir(tmp_path)
    for spelled in ("folder/scene.json", path):
        read = Scene.read(spelled)
        np.testing.assert_allclose(read.run().position, state(read.run().elapsed)[0], atol=2e-3)
        again = Scene.from_json(read.to_json())  # the path is then relative to the working folder
        np.testing.assert_array_equal(again.run().position, read.run().position)


@pytest.mark.parametrize(
    ("kind", "degree"), [("HERMITE", 5), ("HERMITE", 7), ("LAGRANGE", 5), ("LAGRANGE", 7)]
)
def test_degree_of_the_file_is_that_of_the_interpolation(kind, degree):
    """Rows 240 s apart: errors are those of that degree by scipy, not of the best that there is."""
    from scipy.interpolate import BarycentricInterpolator, KroghInterpolator

    t = np.arange(0.0, 6001.0, 240.0)
    orbit = {"oem": oem(oem_segment(t, INTERPOLATION=kind, INTERPOLATION_DEGREE=str(degree)))}
    at = np.array([2450.0, 2520.0, 2600.0])
    count = (degree + 1) // 2 if kind == "HERMITE" else degree + 1
    first = 10 - (count // 2 - 1)
    nodes = t[first : first + count]
    r, v = state(nodes)
    if kind == "HERMITE":
        both = np.stack([r, v], axis=1).reshape(-1, 3)
        expected = KroghInterpolator(np.repeat(nodes - 2520.0, 2), both)(at - 2520.0)
    else:
        expected = BarycentricInterpolator(nodes - 2520.0, r)(at - 2520.0)
    found = ephemeris(orbit, times={"elapsed": at.tolist(), "unit": "s"}).position
    error = np.abs(expected - state(at)[0]).max()
    assert error > 1e-5
    assert np.abs(found - expected).max() < 0.5 * error + 1e-4


def test_orekit_reads_the_same_positions():
    text = oem(oem_segment(ROWS))
    found = ephemeris({"oem": text}, times={"start": 0, "stop": 6000, "step": 59, "unit": "s"})
    theirs = orekit_positions(text, found.elapsed, 4)
    np.testing.assert_allclose(found.position, theirs, atol=1e-3)


@pytest.fixture(scope="module")
def spk(tmp_path_factory):
    """An SPK of type 9 and the states in it, in J2000 of SPICE."""
    spice = pytest.importorskip("spiceypy")
    path = str(tmp_path_factory.mktemp("spk") / "x.bsp")
    handle = spice.spkopn(path, "x", 0)
    seconds = (EPOCH + ROWS * u.s).tdb
    et = (seconds.jd1 - 2451545.0) * 86400.0 + seconds.jd2 * 86400.0
    r, v = state(ROWS)
    states = np.concatenate([r, v], axis=1) / 1e3
    spice.spkw09(handle, -999, 399, "J2000", et[0], et[-1], "ours", 9, len(et), states, et)
    spice.spkcls(handle)
    return path


@pytest.mark.parametrize("name", [None, "-999"])
def test_spk_is_evaluated_by_spice(spk, name):
    found = ephemeris({"file": spk, **({"object": name} if name else {})}, frame="ICRF")
    np.testing.assert_allclose(found.position, state(found.elapsed)[0], atol=2e-3)


def test_spk_covers_what_it_covers(spk):
    with pytest.raises(InputError, match=r"covers from .*2026-01-01T00:00:00.*to.*T01:40:00"):
        scene({"file": spk}, times={"start": 0, "stop": 7000, "step": 7, "unit": "s"})
    with pytest.raises(InputError, match="no object '-31', but -999"):
        scene({"file": spk, "object": "-31"})


def in_frame(text, frame):
    return text.replace("REF_FRAME = EME2000", f"REF_FRAME = {frame}")


@pytest.mark.parametrize(
    ("name", "frame"), [("ITRF2014", "ITRF"), ("TEME", "TEME"), ("GCRF", "GCRF"), ("GTOD", "GTOD")]
)
def test_frame_of_the_file_is_turned_to_that_of_the_scene(name, frame):
    """The numbers of the ellipse, now along the axes of another frame."""
    text = in_frame(oem(oem_segment(ROWS)), name)
    found = ephemeris({"oem": text})
    turn = rotation_between(frame, "EME2000", found.instants)
    w, xyz = turn.quaternion[..., :1], turn.quaternion[..., 1:]
    r = state(found.elapsed)[0]
    expected = r + 2.0 * (w * np.cross(xyz, r) + np.cross(xyz, np.cross(xyz, r)))
    np.testing.assert_allclose(found.position, expected, atol=5e-3)


def test_tables_written_here_are_read_as_an_orbit(tmp_path):
    written = ephemeris(INLINE["oem"])
    for unit, columns in (("dates", "time,position,velocity"), ("elapsed", "elapsed,position")):
        path = tmp_path / f"{unit}.csv"
        written.with_columns(columns).write(path)
        found = ephemeris({"file": str(path)}, frame="ICRF").in_frame("EME2000")
        np.testing.assert_allclose(found.position, written.position, atol=2e-3)


GAP = oem(oem_segment(ROWS[:40]), oem_segment(ROWS[45:]))
USEABLE = oem(
    oem_segment(ROWS, USEABLE_START_TIME="2026-01-01T00:05:00", USEABLE_STOP_TIME="2026-01-01T01:30:00")
)
TWO = oem(oem_segment(ROWS[:20], OBJECT_NAME="A [1]"), oem_segment(ROWS[20:], OBJECT_NAME="A [2]"))


@pytest.mark.parametrize(
    ("orbit", "field", "said"),
    [
        ({"oem": oem(oem_segment(ROWS[:90]))}, "orbit.oem", "covers from 0 s .*00:00:00.* to 5340 s"),
        ({"oem": GAP}, "orbit.oem", "has a gap from 2340 s .* to 2700 s"),
        ({"oem": USEABLE}, "orbit.oem", "covers from 300 s .* to 5400 s"),
        ({"oem": INLINE["oem"]["oem"].replace("EARTH", "MOON")}, "orbit.mu", "of MOON"),
        ({"oem": in_frame(INLINE["oem"]["oem"], "MCI")}, "orbit.oem", "positions along one of"),
        ({"oem": in_frame(INLINE["oem"]["oem"], "RTN")}, "orbit.oem", "positions along one of"),
        ({"oem": INLINE["oem"]["oem"], "frame": "ITRF"}, "orbit.frame", "the file states EME2000"),
        ({"oem": INLINE["oem"]["oem"], "format": "stk"}, "orbit.format", "no format beside oem"),
        ({"oem": INLINE["oem"]["oem"], "file": "x.oem"}, "orbit", "exactly one of file, oem, stk, csv"),
        ({"file": "no.oem"}, "orbit.file", "no.oem: cannot be read"),
        ({"file": "no.txt"}, "orbit.file", "no format of orbits"),
        (
            {"oem": INLINE["oem"]["oem"].replace("T00:01:00.000000000 ", "T00:00:00 ")},
            "orbit.oem",
            "line 16: an epoch that is not after",
        ),
        (
            {"oem": INLINE["oem"]["oem"].replace("HERMITE", "SPLINE")},
            "orbit.oem",
            "line 12: INTERPOLATION = SPLINE",
        ),
        ({"oem": INLINE["oem"]["oem"].replace("OBJECT_NAME = SAT\n", "")}, "orbit.oem", "no OBJECT_NAME"),
        ({"oem": "CCSDS_AEM_VERS = 2.0"}, "orbit.oem", "not an OEM"),
        ({"oem": INLINE["oem"]["oem"], "object": "OTHER"}, "orbit.oem", "no object 'OTHER', but SAT"),
        (
            {"oem": oem(oem_segment(ROWS, REF_FRAME="TEME", REF_FRAME_EPOCH="2026-01-01T00:00:00"))},
            "orbit.oem",
            "REF_FRAME_EPOCH = 2026-01-01T00:00:00: TEME is read as that of date",
        ),
        ({"oem": TWO}, "orbit.oem", r"several objects \(A \[1\], A \[2\]\)"),
        ({"oem": TWO, "object": "A"}, "orbit.oem", "no object 'A', but A"),
        ({"oem": oem_xml(ROWS).replace("<Y>", '<Y units="m">', 1)}, "orbit.oem", "Y in m, not km"),
        ({"oem": oem_xml(ROWS).replace("<Y>", "<X>1.0</X><Y>", 1)}, "orbit.oem", "X twice in a row"),
        ({"stk": stk(ROWS, "EphemerisTimePos")}, "orbit.stk", "Hermite without velocities"),
        ({"stk": stk(ROWS, NumberOfEphemerisPoints=3)}, "orbit.stk", "line 4: 101 rows"),
        (
            {"oem": oem(oem_segment(ROWS, INTERPOLATION="LAGRANGE", INTERPOLATION_DEGREE="20000"))},
            "orbit.oem",
            "INTERPOLATION_DEGREE = 20000: not a whole number from 1 to 31",
        ),
        ({"stk": stk(ROWS, InterpolationOrder="20000")}, "orbit.stk", "InterpolationOrder 20000: at most 31"),
        ({"stk": stk(ROWS, InterpolationSamplesM1="900000000")}, "orbit.stk", "at most 31 is read"),
        ({"stk": stk(ROWS, CoordinateSystem="MeanOfDate")}, "orbit.stk", "ICRF and J2000 are read"),
        ({"stk": stk(ROWS).replace("END Ephemeris", "")}, "orbit.stk", "ends before END"),
        ({"csv": csv(ROWS).replace("z_km,", "w_km,")}, "orbit.csv", "position_x_m"),
        ({"csv": csv(ROWS).replace("time", "when")}, "orbit.csv", "no column time or elapsed_s"),
        (
            {"csv": csv(ROWS).replace("T00:02:00.000000000,", "T00:02:00.000000000,x")},
            "orbit.csv",
            "line 4: x_km is 'x",
        ),
    ],
)
def test_refusals_name_field_and_place(orbit, field, said):
    with pytest.raises(InputError, match=said) as raised:
        scene(orbit)
    assert raised.value.field == field


def test_an_orbit_about_another_body_needs_its_mu():
    text = INLINE["oem"]["oem"].replace("EARTH", "MARS")
    found = ephemeris({"oem": text, "mu": {"value": 4.2828e13, "unit": "m3/s2"}})
    np.testing.assert_allclose(found.position, state(found.elapsed)[0], atol=2e-3)


def test_dates_need_an_epoch_in_the_scene():
    document = {key: value for key, value in BASE.items() if key != "epoch"}
    with pytest.raises(InputError, match="an epoch"):
        Scene.model_validate({**document, "orbit": INLINE["oem"]})


def test_what_stk_leaves_out_is_in_the_plan():
    found = scene({"stk": stk(ROWS, InterpolationOrder=None)})
    assert "no InterpolationOrder, taken as 5" in " ".join(found.plan().notes)
    assert found.run().plan.notes == found.plan().notes


def test_torque_along_a_file_is_that_along_the_table_of_its_rows():
    r, v = state(ROWS)
    table = {
        "times": {"value": ROWS.tolist(), "unit": "s"},
        "positions": {"value": r.tolist(), "unit": "m"},
        "velocities": {"value": v.tolist(), "unit": "m/s"},
    }
    effects = [{"type": "gravity_gradient"}]
    times = {"start": 0, "stop": 5000, "step": 500, "unit": "s"}
    one, other = (ephemeris(orbit, effects=effects, times=times) for orbit in (INLINE["oem"], table))
    np.testing.assert_allclose(one.quaternion("wxyz"), other.quaternion("wxyz"), atol=1e-9)


def test_formats_are_told_by_endings_alone(tmp_path):
    path = tmp_path / "x.OEM"
    path.write_text(oem(oem_segment(ROWS)))
    assert len(read_orbit(str(path)).segments) == 1
    with pytest.raises(FormatError, match="not an STK file"):
        read_orbit(str(path), "stk")
